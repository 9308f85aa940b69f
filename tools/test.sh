#!/usr/bin/env bash
# Installs missing packages, builds, and runs all tests. The output ends with CTest's summary.
#
#   tools/test.sh [--preset NAME] [--target NAME]... [--threads] [--label REGEX] [--exclude-label REGEX]
#                 [--warnings-are-errors] [CTEST OPTION...]
#
#   --preset NAME           a preset of CMakePresets.json; default release
#   --target NAME           builds and runs only the test of this name; may be repeated
#   --threads               builds and runs only the tests of code with threads (label threads)
#   --label REGEX           only tests with such a label: fast (under a minute in all), slow
#   --exclude-label REGEX   only tests without such a label
#   --warnings-are-errors   as .ci/run has it; compiles everything once more
#   anything else           is passed to ctest: -R NAME, --verbose, --rerun-failed ...
#
# The exit status is 0 if the build succeeded and every test passed. If no test ran, that is a
# failure.
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
build_options=()
# Warnings are errors only where they are asked for: a user's compiler may have more warnings than ours, and
# what tools/quickstart.sh has built is not compiled again for the sake of an option.
warnings_are_errors=OFF
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
    --threads)
      build_options+=(--target tests_with_threads)
      ctest_options+=(--label-regex '^threads$')
      shift
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
    --warnings-are-errors)
      warnings_are_errors=ON
      shift
      ;;
    *)
      ctest_options+=("$1")
      shift
      ;;
  esac
done

jobs=$(nproc)
tools/dev/install_packages.sh build tests
# Switches on what other scripts switch off to save time. The presets of the sanitizers decide for
# themselves.
configure=(-DPLAIT_TESTS=ON -DPLAIT_TOOLS=ON)
case $preset in
  asan-ubsan | tsan) ;;
  *) configure+=(-DPLAIT_EXAMPLES=ON -DPLAIT_BENCH=ON -DPLAIT_SLOW_TESTS=ON) ;;
esac
[ "$preset" != release ] || configure+=("-DPLAIT_WERROR=$warnings_are_errors")
cmake --preset "$preset" "${configure[@]}" --log-level=WARNING
if [ ${#targets[@]} -gt 0 ]; then
  cmake --build --preset "$preset" --parallel "$jobs" --target "${targets[@]}"
  ctest_options+=(--tests-regex "^($(IFS='|' && echo "${targets[*]}"))$")
else
  cmake --build --preset "$preset" --parallel "$jobs" "${build_options[@]}"
fi
ctest --preset "$preset" --parallel "$jobs" "${ctest_options[@]}"
