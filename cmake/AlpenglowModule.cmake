# alpenglow_module(NAME SOURCES <cpp>... [PUBLIC <targets>...] [PRIVATE <targets>...] [DIRECTORY <dir>]
#                  [EXTERNAL "<find_dependency arguments>"...])
#
# Declares the library alpenglow::NAME from <dir>/include and <dir>/<SOURCES>. Without SOURCES it is header-only.
# A target sees only the headers of what it links, so a forbidden include does not compile. Each module is exported on
# its own, so that find_package(alpenglow COMPONENTS x) asks for nothing but what x needs: EXTERNAL lists the packages
# that a consumer must find.
set_property(GLOBAL PROPERTY ALPENGLOW_COMPONENTS "")

function(alpenglow_module name)
    cmake_parse_arguments(M "" "DIRECTORY" "SOURCES;PUBLIC;PRIVATE;EXTERNAL" ${ARGN})
    if(NOT M_DIRECTORY)
        set(M_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}")
    endif()
    set(target alpenglow_${name})
    if(M_SOURCES)
        add_library(${target} STATIC ${M_SOURCES})
        set(scope PUBLIC)
        target_link_libraries(${target} PUBLIC ${M_PUBLIC} PRIVATE ${M_PRIVATE})
    else()
        add_library(${target} INTERFACE)
        set(scope INTERFACE)
        target_link_libraries(${target} INTERFACE ${M_PUBLIC})
        target_compile_features(${target} INTERFACE cxx_std_20)
    endif()
    add_library(alpenglow::${name} ALIAS ${target})
    set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
    target_include_directories(${target} ${scope} "$<BUILD_INTERFACE:${M_DIRECTORY}/include>"
                                                  "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>")
    alpenglow_compile_options(${target})

    # What a consumer of this component has to load before it: our own targets, then other people's packages.
    set(needs "")
    foreach(dependency IN LISTS M_PUBLIC M_PRIVATE)
        if(dependency MATCHES "^alpenglow::(.+)$")
            list(APPEND needs ${CMAKE_MATCH_1})
        endif()
    endforeach()
    set_property(GLOBAL APPEND PROPERTY ALPENGLOW_COMPONENTS ${name})
    set_property(GLOBAL PROPERTY ALPENGLOW_NEEDS_${name} "${needs}")
    set_property(GLOBAL PROPERTY ALPENGLOW_EXTERNAL_${name} "${M_EXTERNAL}")

    if(ALPENGLOW_INSTALL)
        install(TARGETS ${target} EXPORT alpenglow-${name} ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
        if(EXISTS "${M_DIRECTORY}/include")
            install(DIRECTORY "${M_DIRECTORY}/include/" DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
        endif()
        install(EXPORT alpenglow-${name} NAMESPACE alpenglow:: FILE alpenglow-${name}.cmake
                DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/alpenglow)
    endif()
endfunction()

# Writes and installs alpenglow-config.cmake, once all modules are declared.
function(alpenglow_install_package)
    include(CMakePackageConfigHelpers)
    get_property(components GLOBAL PROPERTY ALPENGLOW_COMPONENTS)
    set(ALPENGLOW_COMPONENT_TABLE "set(_alpenglow_all ${components})\n")
    foreach(name IN LISTS components)
        get_property(needs GLOBAL PROPERTY ALPENGLOW_NEEDS_${name})
        get_property(external GLOBAL PROPERTY ALPENGLOW_EXTERNAL_${name})
        string(APPEND ALPENGLOW_COMPONENT_TABLE "set(_alpenglow_needs_${name} ${needs})\n"
                                                "set(_alpenglow_external_${name} \"${external}\")\n")
    endforeach()
    configure_package_config_file("${PROJECT_SOURCE_DIR}/cmake/alpenglow-config.cmake.in"
        "${PROJECT_BINARY_DIR}/alpenglow-config.cmake" INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/alpenglow)
    write_basic_package_version_file("${PROJECT_BINARY_DIR}/alpenglow-config-version.cmake"
        COMPATIBILITY SameMinorVersion)
    install(FILES "${PROJECT_BINARY_DIR}/alpenglow-config.cmake"
                  "${PROJECT_BINARY_DIR}/alpenglow-config-version.cmake"
            DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/alpenglow)
endfunction()
