# Builds `digests` of the project in BUILD, runs INSIDE and it, and fails unless both succeed and print
# the same. What the processor cannot run says that it is skipped (status 77).
execute_process(COMMAND ${CMAKE_COMMAND} --build ${BUILD} --target digests
  OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
set(OUTSIDE ${BUILD}/digests)
foreach(program INSIDE OUTSIDE)
  execute_process(COMMAND ${${program}} RESULT_VARIABLE status OUTPUT_VARIABLE ${program}_PRINTS)
  if(status EQUAL 77)
    message("${${program}_PRINTS}")
    return()
  endif()
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${${program}}: ${status}\n${${program}_PRINTS}")
  endif()
endforeach()
if(NOT INSIDE_PRINTS STREQUAL OUTSIDE_PRINTS)
  message(FATAL_ERROR "inside:\n${INSIDE_PRINTS}outside:\n${OUTSIDE_PRINTS}")
endif()
