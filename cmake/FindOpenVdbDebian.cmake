# Finds OpenVDB where the distribution ships no CMake config for it (Debian 12) and defines the imported target
# OpenVDB::openvdb on the library, TBB and Imath. openvdb.h is costly: link it PRIVATE to the few files that need it.
include(CMakeFindDependencyMacro)
find_dependency(TBB CONFIG)
find_dependency(Imath CONFIG)
find_path(OpenVdbDebian_INCLUDE_DIR openvdb/openvdb.h)
find_library(OpenVdbDebian_LIBRARY openvdb)
if(OpenVdbDebian_INCLUDE_DIR AND EXISTS "${OpenVdbDebian_INCLUDE_DIR}/openvdb/version.h")
    foreach(part MAJOR MINOR PATCH)
        file(STRINGS "${OpenVdbDebian_INCLUDE_DIR}/openvdb/version.h" line
             REGEX "#define OPENVDB_LIBRARY_${part}_VERSION_NUMBER [0-9]+")
        string(REGEX REPLACE ".* ([0-9]+).*" "\\1" _openvdb_${part} "${line}")
    endforeach()
    set(OpenVdbDebian_VERSION "${_openvdb_MAJOR}.${_openvdb_MINOR}.${_openvdb_PATCH}")
endif()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenVdbDebian
    REQUIRED_VARS OpenVdbDebian_LIBRARY OpenVdbDebian_INCLUDE_DIR TBB_FOUND Imath_FOUND
    VERSION_VAR OpenVdbDebian_VERSION)
if(OpenVdbDebian_FOUND AND NOT TARGET OpenVDB::openvdb)
    add_library(OpenVDB::openvdb UNKNOWN IMPORTED)
    set_target_properties(OpenVDB::openvdb PROPERTIES
        IMPORTED_LOCATION "${OpenVdbDebian_LIBRARY}"
        INTERFACE_SYSTEM_INCLUDE_DIRECTORIES "${OpenVdbDebian_INCLUDE_DIR}"
        INTERFACE_LINK_LIBRARIES "TBB::tbb;Imath::Imath")
endif()
mark_as_advanced(OpenVdbDebian_INCLUDE_DIR OpenVdbDebian_LIBRARY)
