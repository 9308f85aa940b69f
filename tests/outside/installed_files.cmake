# Installs BUILD into PREFIX and moves the tree to MOVED, where other tests use it. Fails if a public
# header of the folders SOURCES is not there, or if a file for compilers names a place of this machine.
file(REMOVE_RECURSE ${PREFIX} ${MOVED})
execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD} --prefix ${PREFIX}
  OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
file(RENAME ${PREFIX} ${MOVED})

set(count 0)
foreach(source IN LISTS SOURCES)
  file(GLOB_RECURSE headers RELATIVE ${source} ${source}/*.h)
  if(NOT headers)
    message(FATAL_ERROR "${source}: no header found")
  endif()
  foreach(header IN LISTS headers)
    math(EXPR count "${count} + 1")
    if(NOT EXISTS ${MOVED}/include/${header})
      message(SEND_ERROR "${header} of ${source} is not installed")
    endif()
  endforeach()
endforeach()

file(GLOB_RECURSE files ${MOVED}/*.cmake ${MOVED}/*.pc ${MOVED}/*.h)
foreach(file IN LISTS files)
  file(STRINGS ${file} places REGEX "${PREFIX}|${BUILD}|${SOURCE_ROOT}")
  if(places)
    message(SEND_ERROR "${file} names a place of this machine: ${places}")
  endif()
endforeach()
message("${count} headers of the source looked for")
