# Packages that plait can do without. A package may be installed in part: a compiler wrapper without its
# headers, a module of pkg-config without its library. CMake's own search then ends the run, or the build
# ends later. So another run of CMake tries such a package first (cmake/whole), and what that run cannot use
# counts as not found.

set(plait_whole_folder ${CMAKE_CURRENT_LIST_DIR}/whole)

# plait_is_whole(RESULT WHAT [PACKAGE NAME [ARGUMENTS...]] [MODULE NAME] [TARGET NAME] [HEADERS ALTERNATIVES...]
# [PROGRAM TEXT] [LANGUAGE C]): sets RESULT to whether the CMake package or the module of pkg-config can be
# used: CMake gets through with it, one of the HEADERS is there, and PROGRAM compiles and links with TARGET.
# A package that is not there at all counts as whole: the search that follows says so. If it is not whole,
# one line says that WHAT is left out.
function(plait_is_whole result what)
  cmake_parse_arguments(PARSE_ARGV 2 ARG "" "MODULE;TARGET;PROGRAM;LANGUAGE" "PACKAGE;HEADERS")
  if(NOT ARG_LANGUAGE)
    set(ARG_LANGUAGE CXX)
  endif()
  list(GET ARG_PACKAGE 0 package)
  if(ARG_MODULE)
    set(package ${ARG_MODULE})
  endif()
  set(work ${PROJECT_BINARY_DIR}/CMakeFiles/plait_whole_${ARG_LANGUAGE})
  set(alternatives ${ARG_HEADERS})
  list(TRANSFORM alternatives REPLACE "(.+)" "__has_include(<\\1>)")
  list(JOIN alternatives " || " present)
  set(text "${ARG_PROGRAM}\n")
  if(NOT ARG_PROGRAM)
    set(text "int main(void) { return 0; }\n")
  endif()
  if(ARG_HEADERS)
    string(PREPEND text "#if !(${present})\n#error the headers of ${package} are missing\n#endif\n")
  endif()

  # What the search of this run looks at.
  set(settings "set(WHOLE_PROGRAM [[${text}]] CACHE STRING \"\" FORCE)\n")
  set(WHOLE_PACKAGE ${ARG_PACKAGE})
  set(WHOLE_MODULE ${ARG_MODULE})
  set(WHOLE_TARGET ${ARG_TARGET})
  set(WHOLE_LANGUAGE ${ARG_LANGUAGE})
  foreach(variable WHOLE_PACKAGE WHOLE_MODULE WHOLE_TARGET WHOLE_LANGUAGE CMAKE_TOOLCHAIN_FILE CMAKE_SYSROOT
      CMAKE_PREFIX_PATH CMAKE_FIND_ROOT_PATH CMAKE_MODULE_PATH CMAKE_MAKE_PROGRAM CMAKE_C_COMPILER
      CMAKE_CXX_COMPILER ${package}_DIR ${package}_ROOT)
    if(variable MATCHES "^WHOLE" OR NOT "${${variable}}" STREQUAL "")
      string(APPEND settings "set(${variable} [[${${variable}}]] CACHE STRING \"\" FORCE)\n")
    endif()
  endforeach()
  file(WRITE ${work}.cmake "${settings}")
  execute_process(
    COMMAND ${CMAKE_COMMAND} -C ${work}.cmake -S ${plait_whole_folder} -B ${work} -G ${CMAKE_GENERATOR}
    RESULT_VARIABLE status OUTPUT_VARIABLE said ERROR_VARIABLE said)
  if(status EQUAL 0)
    execute_process(COMMAND ${CMAKE_COMMAND} --build ${work}
      RESULT_VARIABLE status OUTPUT_VARIABLE said ERROR_VARIABLE said)
  endif()
  if(status EQUAL 0)
    set(${result} TRUE PARENT_SCOPE)
    return()
  endif()
  # The first line that tells of an error, and of CMake's the line after the place.
  string(REGEX MATCH "(CMake Error[^\n]*:\n +|error[: ]+|cannot find )[^\n]+" reason "${said}")
  string(REGEX REPLACE "CMake Error[^\n]*:\n +|^error[: ]+" "" reason "${reason}")
  message(NOTICE "plait: ${package} is installed in part (${reason}), so ${what} are left out")
  set(${result} FALSE PARENT_SCOPE)
endfunction()

# plait_needs(OPTION WHAT PACKAGE TARGET HEADERS [VERSIONS...]): finds a package that only a part of the
# project needs. Where it is missing the part is left out, in words, and everything else builds.
function(plait_needs option what package target headers)
  if(NOT ${option})
    return()
  endif()
  plait_is_whole(whole ${what} PACKAGE ${package} TARGET ${target} HEADERS ${headers})
  if(NOT whole)
    set(${option} OFF PARENT_SCOPE)
    return()
  endif()
  if(NOT ARGN)
    find_package(${package} QUIET)
  endif()
  foreach(version IN LISTS ARGN)
    find_package(${package} ${version} QUIET)
    if(${package}_FOUND)
      break()
    endif()
  endforeach()
  if(${package}_FOUND)
    set(${package}_VERSION ${${package}_VERSION} PARENT_SCOPE)
    return()
  endif()
  list(JOIN ARGN " or " versions)
  message(NOTICE "plait: ${package} ${versions} not found, so ${what} are left out; -D${option}=OFF "
    "says no more of it, tools/dev/install_packages.sh installs it on Debian")
  set(${option} OFF PARENT_SCOPE)
endfunction()

# plait_find_module(PREFIX WHAT MODULE PROGRAM [LANGUAGE C]): the same for a module of pkg-config, which
# PROGRAM must compile and link with: PREFIX_FOUND and the target PkgConfig::PREFIX.
macro(plait_find_module prefix what module program)
  plait_is_whole(${prefix}_whole ${what} MODULE "${module}" TARGET PkgConfig::whole PROGRAM "${program}" ${ARGN})
  set(${prefix}_FOUND FALSE)
  if(${prefix}_whole)
    pkg_check_modules(${prefix} QUIET IMPORTED_TARGET ${module})
  endif()
endmacro()
