# Debian packages: cmake --preset package && cmake --build --preset package && cpack --preset package
#
#   libplait0     the shared library
#   libplait-dev  headers, static library, CMake package, pkg-config file
#   plait         the program, its manual pages and its bash completion
#   python3-plait the Python package
set(PLAIT_PACKAGE_MAINTAINER "The plait developers <plait@example.org>" CACHE STRING
  "Who answers for the Debian packages: Name <address>")

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME plait)
set(CPACK_PACKAGE_VENDOR plait)
set(CPACK_PACKAGE_CONTACT ${PLAIT_PACKAGE_MAINTAINER})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_COMPONENTS_ALL runtime development python)
if(PLAIT_TOOLS)
  list(APPEND CPACK_COMPONENTS_ALL program)
endif()
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR})  # for the program's libplait
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each description below begins with a summary of its own
set(plait_about "plait stores and refines semi-regular triangle meshes far larger than
memory: irregular base meshes whose faces are refined level by level.
")

set(plait_runtime libplait${PROJECT_VERSION_MAJOR})
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME ${plait_runtime})
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_RUNTIME_DESCRIPTION "${PROJECT_DESCRIPTION} (library)
${plait_about}
This package has the shared library that programs need.")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libplait-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "${plait_runtime} (= ${PROJECT_VERSION})")
# Only who links the static library needs them.
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SUGGESTS "pkg-config, libboost-iostreams-dev, libtbb-dev, \
libfmt-dev, libzstd-dev, liblz4-dev, libxxhash-dev, libhwy-dev, libpng-dev,\
 liburing-dev")
set(CPACK_DEBIAN_DEVELOPMENT_DESCRIPTION "${PROJECT_DESCRIPTION} (development files)
${plait_about}
This package has what a compiler needs: headers, the static library, a CMake
package and a pkg-config file.")

set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME plait)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS "${plait_runtime} (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_PROGRAM_DESCRIPTION "${PROJECT_DESCRIPTION} (program)
${plait_about}
This package has the program: it refines meshes into stores, and checks,
repairs, converts, exports and renders stores.")

# Plain Python that loads the library by its name. A plain cmake --install leaves it out: pip installs it.
install(DIRECTORY ${PROJECT_SOURCE_DIR}/python/plait DESTINATION lib/python3/dist-packages COMPONENT python
  EXCLUDE_FROM_ALL FILES_MATCHING PATTERN "*.py" PATTERN "*.pyi" PATTERN "py.typed"
  PATTERN "__pycache__" EXCLUDE)
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-plait)
set(CPACK_DEBIAN_PYTHON_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
  "${plait_runtime} (>= ${PROJECT_VERSION}), python3 (>= 3.9), python3-numpy")
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA
  ${PROJECT_SOURCE_DIR}/packaging/python/postinst ${PROJECT_SOURCE_DIR}/packaging/python/prerm)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-dask, python3-matplotlib")
set(CPACK_DEBIAN_PYTHON_DESCRIPTION "${PROJECT_DESCRIPTION} (Python)
${plait_about}
This package has the Python package: levels, patches and meshes of a store as
numpy arrays.")

# Before version 1.0 each minor version may change the interface, so a package that is built against
# this version wants no later minor version.
math(EXPR plait_next_minor "${PROJECT_VERSION_MINOR} + 1")
set(plait_wants ">= ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}")
string(CONCAT plait_shlibs "libplait ${PROJECT_VERSION_MAJOR} ${plait_runtime} (${plait_wants}), "
  "${plait_runtime} (<< ${PROJECT_VERSION_MAJOR}.${plait_next_minor}~)\n")
set(plait_package_files ${PROJECT_BINARY_DIR}/packaging)
file(CONFIGURE OUTPUT ${plait_package_files}/shlibs CONTENT "${plait_shlibs}")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_CONTROL_EXTRA
  ${plait_package_files}/shlibs ${PROJECT_SOURCE_DIR}/packaging/triggers)

# What Debian wants in the folder of documents of each package, and a plain cmake --install leaves out.
configure_file(packaging/changelog.in ${plait_package_files}/changelog @ONLY)
file(STRINGS ${plait_package_files}/changelog plait_newest LIMIT_COUNT 1)
if(NOT plait_newest MATCHES "^plait \\(${PROJECT_VERSION}\\) ")
  message(FATAL_ERROR "packaging/changelog.in: expected an entry for ${PROJECT_VERSION} at the top, "
    "found '${plait_newest}'")
endif()
find_program(PLAIT_GZIP gzip)
if(NOT PLAIT_GZIP)
  message(NOTICE "plait: gzip not found, so cpack makes no packages")
  return()
endif()
execute_process(COMMAND ${PLAIT_GZIP} -9nf ${plait_package_files}/changelog COMMAND_ERROR_IS_FATAL ANY)
foreach(component IN LISTS CPACK_COMPONENTS_ALL)
  string(TOUPPER ${component} name)
  set(name ${CPACK_DEBIAN_${name}_PACKAGE_NAME})
  install(FILES ${PROJECT_SOURCE_DIR}/packaging/copyright ${plait_package_files}/changelog.gz
    DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name} COMPONENT ${component} EXCLUDE_FROM_ALL)
endforeach()
set(CPACK_POST_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/packaging/without_maintainer_scripts.cmake)
include(CPack)
