# cmake --install: the library, its headers, its CMake package and its pkg-config file. Nothing that
# is installed names this build or the prefix, so that the tree may be moved.
#
# Components: runtime (what a program needs to run), development (what a compiler needs), program
# (plait itself; tools/CMakeLists.txt), mpi (plait-mpi).
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(plait_package_directory ${CMAKE_INSTALL_LIBDIR}/cmake/plait)

# plait_install_program(TARGET COMPONENT): the library is found beside the program, wherever the tree is
# moved to; in /usr the system does it.
function(plait_install_program target component)
  install(TARGETS ${target} RUNTIME COMPONENT ${component})
  if(NOT CMAKE_INSTALL_PREFIX STREQUAL "/usr")
    cmake_path(RELATIVE_PATH CMAKE_INSTALL_FULL_LIBDIR
      BASE_DIRECTORY ${CMAKE_INSTALL_FULL_BINDIR} OUTPUT_VARIABLE from_bin_to_lib)
    set_target_properties(${target} PROPERTIES INSTALL_RPATH "$ORIGIN/${from_bin_to_lib}")
  endif()
endfunction()

install(TARGETS plait EXPORT plaitTargets
  LIBRARY COMPONENT runtime NAMELINK_COMPONENT development
  INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
foreach(part IN LISTS plait_parts)
  install(TARGETS plait_component_${part} EXPORT plaitTargets)
endforeach()
foreach(includes IN LISTS plait_public_headers)
  install(DIRECTORY ${includes}/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
    COMPONENT development FILES_MATCHING PATTERN "*.h")
endforeach()
# In a file of its own, because only who links it needs the libraries that it names.
install(TARGETS plait_static EXPORT plaitStaticTargets ARCHIVE COMPONENT development
  INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
foreach(export plaitTargets plaitStaticTargets)
  install(EXPORT ${export} NAMESPACE plait:: DESTINATION ${plait_package_directory}
    COMPONENT development)
endforeach()

# pkg-config modules that the static library needs, as name of ours=module.
set(plait_static_modules
  plait_xxhash=libxxhash plait_zstd=libzstd plait_lz4=liblz4 plait_highway=libhwy
  plait_png=libpng)
if(plait_liburing_FOUND)
  list(APPEND plait_static_modules plait_liburing=liburing)
endif()
list(JOIN plait_parts ", " plait_component_names)
configure_package_config_file(cmake/plaitConfig.cmake.in ${PROJECT_BINARY_DIR}/plaitConfig.cmake
  INSTALL_DESTINATION ${plait_package_directory} NO_SET_AND_CHECK_MACRO)
# Before version 1.0 each minor version may change the interface.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/plaitConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/plaitConfig.cmake ${PROJECT_BINARY_DIR}/plaitConfigVersion.cmake
  DESTINATION ${plait_package_directory} COMPONENT development)

# The libraries stand in Libs.private and not in Requires.private, because pkg-config --cflags would
# ask for the latter even for a program that links the shared library.
set(plait_pc_private "-lboost_iostreams -ltbb -lfmt")
foreach(module IN LISTS plait_static_modules)
  string(REGEX REPLACE "=.*" "_STATIC_LDFLAGS" flags ${module})
  foreach(flag IN LISTS ${flags})
    string(REGEX REPLACE "^-L" "" directory "${flag}")
    if(NOT directory IN_LIST CMAKE_CXX_IMPLICIT_LINK_DIRECTORIES AND NOT flag STREQUAL "-pthread")
      string(APPEND plait_pc_private " ${flag}")
    endif()
  endforeach()
endforeach()
foreach(directory LIBDIR INCLUDEDIR)
  cmake_path(RELATIVE_PATH CMAKE_INSTALL_FULL_${directory}
    BASE_DIRECTORY ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig OUTPUT_VARIABLE plait_pc_${directory})
endforeach()
configure_file(cmake/plait.pc.in ${PROJECT_BINARY_DIR}/plait.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/plait.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig
  COMPONENT development)
