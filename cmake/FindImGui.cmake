# Dear ImGui as Debian packages it (libimgui-dev): a static library with the GLFW and Vulkan backends inside and no CMake
# config of its own. Defines ImGui::imgui.
find_path(ImGui_INCLUDE_DIR imgui.h PATH_SUFFIXES imgui)
find_library(ImGui_LIBRARY imgui)
find_library(ImGui_STB_LIBRARY stb)
find_package(glfw3 QUIET)
find_package(Vulkan QUIET)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(ImGui REQUIRED_VARS ImGui_LIBRARY ImGui_INCLUDE_DIR ImGui_STB_LIBRARY glfw3_FOUND
                                                      Vulkan_FOUND)
if(ImGui_FOUND AND NOT TARGET ImGui::imgui)
    add_library(ImGui::imgui STATIC IMPORTED)
    set_target_properties(ImGui::imgui PROPERTIES
        IMPORTED_LOCATION "${ImGui_LIBRARY}"
        INTERFACE_INCLUDE_DIRECTORIES "${ImGui_INCLUDE_DIR};${ImGui_INCLUDE_DIR}/backends"
        INTERFACE_LINK_LIBRARIES "glfw;Vulkan::Vulkan;${ImGui_STB_LIBRARY}")
endif()
