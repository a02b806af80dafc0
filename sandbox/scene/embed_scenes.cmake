# cmake -DOUTPUT=<cpp> -DSCENES=<file,file,...> -P embed_scenes.cmake: writes the scenes as string literals.
string(REPLACE "," ";" SCENES "${SCENES}")
set(entries "")
foreach(file IN LISTS SCENES)
    get_filename_component(name "${file}" NAME_WE)
    file(READ "${file}" text)
    string(APPEND entries "    {\"${name}\", R\"scene(${text})scene\"},\n")
endforeach()
file(WRITE "${OUTPUT}" "#include \"builtin_scenes.hpp\"

namespace alpenglow::sandbox {
namespace {

constexpr BuiltinScene scenes[] = {
${entries}};

} // namespace

std::span<const BuiltinScene> builtin_scenes() {
    return scenes;
}

} // namespace alpenglow::sandbox
")
