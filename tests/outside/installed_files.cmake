# Installs BUILD into PREFIX and moves the tree to MOVED, where other tests use it. Fails if a public
# header of the folders SOURCES is not there, if a file for compilers names a place of this machine, or
# if the shared library exports what no public header declares.
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
# Public names are in plait::v0; of other libraries' functions none may be visible.
file(GLOB_RECURSE library ${MOVED}/libplait.so)
execute_process(COMMAND nm --dynamic --defined-only ${library} OUTPUT_VARIABLE exported
  COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL " [TWVBDR] [^\n]+" symbols "${exported}")
list(LENGTH symbols symbol_count)
if(symbol_count LESS 100)
  message(SEND_ERROR "${library} exports ${symbol_count} symbols, expected some hundred")
endif()
list(FILTER symbols INCLUDE REGEX " _ZN?K?(5plait([^2]|2[^v])|3fmt|3hwy|3tbb|5boost9iostreams)")
if(symbols)
  message(SEND_ERROR "${library} exports what no public header declares: ${symbols}")
endif()
message("${symbol_count} exported symbols, ${count} headers of the source looked for")
