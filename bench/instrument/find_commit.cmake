# Writes OUTPUT, the definition of built_from_commit() (environment.cpp), with the git commit of SOURCE. A
# file that would not change stays as it is, so that nothing is built again.
set(PLAIT_COMMIT "")
if(EXISTS ${SOURCE}/.git)
  set(ENV{GIT_OPTIONAL_LOCKS} 0)
  execute_process(COMMAND git -C ${SOURCE} describe --always --abbrev=40 --exclude=* --dirty
    OUTPUT_VARIABLE PLAIT_COMMIT OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
  if(failed)
    set(PLAIT_COMMIT "")
  endif()
endif()
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT [[// Made by CMake (bench/instrument/find_commit.cmake).
#include <string_view>
namespace plait::instrument {
std::string_view built_from_commit() { return "@PLAIT_COMMIT@"; }
}  // namespace plait::instrument
]] @ONLY)
