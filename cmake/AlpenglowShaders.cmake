# alpenglow_shaders(TARGET FILES <file under shaders/>...)
#
# Compiles GLSL to SPIR-V for Vulkan 1.1 at build time and embeds it: TARGET can include <alpenglow_shaders/FILE.hpp>,
# which holds `const uint32_t NAME[]`, NAME being the file's name with every other character than letters and digits
# replaced by an underscore (passes/terrain.vert -> terrain_vert). #include is relative to the file, then to shaders/.
# A change of an included file compiles again.
find_program(GLSLANG_VALIDATOR glslangValidator REQUIRED)

function(alpenglow_shaders target)
    cmake_parse_arguments(S "" "" "FILES" ${ARGN})
    set(root "${PROJECT_SOURCE_DIR}/shaders")
    set(out "${CMAKE_CURRENT_BINARY_DIR}/shaders/alpenglow_shaders")
    foreach(file IN LISTS S_FILES)
        cmake_path(IS_ABSOLUTE file absolute)
        if(NOT absolute)
            set(file "${root}/${file}")
        endif()
        cmake_path(GET file FILENAME name)
        string(MAKE_C_IDENTIFIER "${name}" variable)
        set(header "${out}/${name}.hpp")
        add_custom_command(OUTPUT "${header}"
            COMMAND "${CMAKE_COMMAND}" -E make_directory "${out}"
            COMMAND "${GLSLANG_VALIDATOR}" --quiet -V --target-env vulkan1.1 "-I${root}" --depfile "${header}.d"
                    --vn "${variable}" -o "${header}" "${file}"
            DEPENDS "${file}"
            DEPFILE "${header}.d"
            COMMENT "Compiling shader ${name}"
            VERBATIM)
        target_sources(${target} PRIVATE "${header}")
    endforeach()
    target_include_directories(${target} PRIVATE "${CMAKE_CURRENT_BINARY_DIR}/shaders")
endfunction()
