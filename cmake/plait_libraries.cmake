# The library that programs link: one shared library, and a static one of the same objects.
#
#   plait::plait, plait::engine, plait::backends, plait::kernels, plait::jobs, plait::c    the shared library
#   plait::plait_static                                                       its static twin
#
# The installed package has targets of the same names (cmake/plaitConfig.cmake.in).

# What the objects of the parts call, for the linker: their own libraries, without headers alone.
set(plait_link_libraries)
foreach(part IN LISTS plait_parts)
  get_target_property(linked plait_${part} LINK_LIBRARIES)
  list(APPEND plait_link_libraries ${linked})
endforeach()
list(REMOVE_DUPLICATES plait_link_libraries)
list(FILTER plait_link_libraries EXCLUDE REGEX "plait_(engine|backends|kernels|scans|jobs|c|build_rules)|headers$|nlohmann_json")

add_library(plait SHARED)
add_library(plait_static STATIC)
foreach(library plait plait_static)
  foreach(part IN LISTS plait_parts)
    target_sources(${library} PRIVATE $<TARGET_OBJECTS:plait_${part}>)
  endforeach()
  target_include_directories(${library} INTERFACE "$<BUILD_INTERFACE:${plait_public_headers}>")
  target_compile_features(${library} INTERFACE cxx_std_20)
  # Rules that a program of somebody else's writes get the same bits on every machine and by every
  # compiler. The library's own rules do without this option: none is inline in a public header.
  target_compile_options(${library} INTERFACE
    $<$<COMPILE_LANG_AND_ID:CXX,GNU,Clang,AppleClang>:-ffp-contract=off>)
  target_link_libraries(${library}
    PRIVATE $<BUILD_INTERFACE:plait_build_rules> ${plait_link_libraries})
  set_target_properties(${library} PROPERTIES OUTPUT_NAME plait LINKER_LANGUAGE CXX)
  add_library(plait::${library} ALIAS ${library})
endforeach()

# Before version 1.0 the package that a program is built against counts by major and minor version
# (cmake/plait_packages.cmake); the name of the file counts by the major version from the start.
set_target_properties(plait PROPERTIES
  VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR})
if(NOT PLAIT_SANITIZE)
  target_link_options(plait PRIVATE LINKER:--no-undefined)  # a sanitizer's runtime is in the program
endif()

# A program that links the parts and the shared library, or both twins, would have two of each
# registry: CMake refuses it when the values differ.
set_target_properties(plait PROPERTIES INTERFACE_PLAIT_LINKED_AS shared)
set_target_properties(plait_static PROPERTIES INTERFACE_PLAIT_LINKED_AS static)
foreach(library plait plait_static)
  set_property(TARGET ${library} APPEND PROPERTY COMPATIBLE_INTERFACE_STRING PLAIT_LINKED_AS)
endforeach()

foreach(part IN LISTS plait_parts)
  add_library(plait_component_${part} INTERFACE)
  target_link_libraries(plait_component_${part} INTERFACE plait)
  set_target_properties(plait_component_${part} PROPERTIES EXPORT_NAME ${part})
  add_library(plait::${part} ALIAS plait_component_${part})
endforeach()

# A project around this one builds the twin that it links, and not the other.
if(NOT PROJECT_IS_TOP_LEVEL AND NOT PLAIT_INSTALL)
  set_target_properties(plait plait_static plait_engine plait_backends plait_kernels plait_scans plait_jobs
    plait_c plait_library_headers
    PROPERTIES
    EXCLUDE_FROM_ALL ON)
endif()
