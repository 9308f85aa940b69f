#!/usr/bin/env bash
# Installs what is missing, builds, runs all tests; ends with CTest's summary.
#
#   tools/test.sh [--preset NAME] [--target NAME]... [--label REGEX] [--exclude-label REGEX]
#                 [CTEST OPTION...]
#
#   --preset NAME           a preset of CMakePresets.json; default release
#   --target NAME           builds and runs only the test of this name; may be repeated
#   --label REGEX           only tests with such a label: fast (under a minute in all), slow
#   --exclude-label REGEX   all but those
#   anything else           goes to ctest as it is: -R NAME, --verbose, --rerun-failed ...
#
# Exit status 0 if everything was built and every test passed. No test at all is a failure.
set -euo pipefail

case ${1:-} in
  -h | --help)
    sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "$0"
    exit 0
    ;;
esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."

value_of() {
  if [ $# -lt 2 ]; then
    echo "tools/test.sh: $1 needs a value" >&2
    exit 2
  fi
}

preset=release
ctest_options=()
targets=()
while [ $# -gt 0 ]; do
  case $1 in
    --preset)
      value_of "$@"
      preset=$2
      shift 2
      ;;
    --target)
      value_of "$@"
      targets+=("$2")
      shift 2
      ;;
    --label)
      value_of "$@"
      ctest_options+=(--label-regex "$2")
      shift 2
      ;;
    --exclude-label)
      value_of "$@"
      ctest_options+=(--label-exclude "$2")
      shift 2
      ;;
    *)
      ctest_options+=("$1")
      shift
      ;;
  esac
done

jobs=$(nproc)
tools/dev/install_packages.sh build tests
# What other scripts switch off to save time is switched on again here. The presets of the sanitizers
# say themselves what they leave out.
configure=(-DPLAIT_TESTS=ON -DPLAIT_TOOLS=ON)
case $preset in
  asan-ubsan | tsan) ;;
  *) configure+=(-DPLAIT_EXAMPLES=ON -DPLAIT_BENCH=ON -DPLAIT_SLOW_TESTS=ON) ;;
esac
# Instrumented code makes the compiler warn of what is not there, so presets decide for themselves;
# a release is the user's build, whose compiler may warn of more than ours, so it is strict only here.
[ "$preset" != release ] || configure+=(-DPLAIT_WERROR=ON)
cmake --preset "$preset" "${configure[@]}" --log-level=WARNING
if [ ${#targets[@]} -gt 0 ]; then
  cmake --build --preset "$preset" --parallel "$jobs" --target "${targets[@]}"
  ctest_options+=(--tests-regex "^($(IFS='|' && echo "${targets[*]}"))$")
else
  cmake --build --preset "$preset" --parallel "$jobs"
fi
ctest --preset "$preset" --parallel "$jobs" "${ctest_options[@]}"
