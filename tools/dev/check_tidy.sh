#!/usr/bin/env bash
# Runs clang-tidy (.clang-tidy) on the sources, and on our headers through them. To save time, it
# checks tests only with --tests.
#
#   tools/dev/check_tidy.sh [--tests] [--since COMMIT] [--most N] [FILE...]    default: all sources
#
#   --most N         no more than N sources: those that changed last
#   --since COMMIT   only sources that differ from this commit, and one source for each header that
#                    differs; all sources if .clang-tidy differs
#
# PLAIT_CLANG_TIDY in the environment names another program than clang-tidy-14.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
clang_tidy=${PLAIT_CLANG_TIDY:-clang-tidy-14}

folders='engine|backends|kernels|c|tools|examples|bench'
since=
most=
while [ $# -gt 0 ]; do
  case $1 in
    --tests) folders+='|tests' ;;
    --since)
      since=${2:?--since needs a commit}
      shift
      ;;
    --most)
      most=${2:?--most needs a number}
      shift
      ;;
    *) break ;;
  esac
  shift
done

# This build is configured but not compiled, because clang-tidy cannot read GCC's precompiled
# headers.
build=build/tidy
cmake --preset release -B "$build" -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON -DPLAIT_TESTS=ON \
  -DPLAIT_TOOLS=ON -DPLAIT_EXAMPLES=ON --log-level=WARNING >/dev/null

# The largest sources come first, so that at the end no processor waits long for the last one.
built_sources() {
  sed -n "s|^ *\"file\": \"$PWD/\(.*\)\",\{0,1\}\$|\1|p" "$build"/compile_commands.json |
    grep -E "^($folders)/" | sort -u | xargs -r ls -S
}

# The sources of the list `all` that must be checked for the changes since a commit.
changed_sources() {
  local changed header includers
  mapfile -t changed < <(git diff --name-only --diff-filter=d "$1" -- '*.cpp' '*.h')
  {
    printf '%s\n' "${changed[@]}" | grep '\.cpp$' || true
    for header in $(printf '%s\n' "${changed[@]}" | grep '\.h$'); do
      includers=$(grep -lE "#include \"([^\"]*/)?${header##*/}\"" "${all[@]}" || true)
      # One source is enough to check a header: the source of the same name, or else the smallest.
      printf '%s\n' "$includers" | grep "/$(basename "$header" .h)\.cpp$" ||
        printf '%s\n' "$includers" | tail -n 1
    done
  } | sort -u | grep -xFf - <(printf '%s\n' "${all[@]}") || true
}

files=("$@")
if [ ${#files[@]} -eq 0 ]; then
  mapfile -t all < <(built_sources)
  if [ ${#all[@]} -eq 0 ]; then
    echo "check_tidy: found no source file" >&2
    exit 1
  fi
  files=("${all[@]}")
  if [ -n "$since" ] && git diff --quiet "$since" -- .clang-tidy; then
    mapfile -t files < <(changed_sources "$since")
    echo "check_tidy: ${#files[@]} of ${#all[@]} files for what changed since $since"
  fi
fi
[ ${#files[@]} -gt 0 ] || exit 0
if [ -n "$most" ] && [ ${#files[@]} -gt "$most" ]; then
  echo "check_tidy: the $most of these ${#files[@]} that changed last"
  mapfile -t files < <(git log --format= --name-only -- '*.cpp' | awk '!seen[$0]++' |
    grep -xFf <(printf '%s\n' "${files[@]}") | sed -n "1,${most}p")
fi

# Removes clang's count of suppressed warnings in system headers.
printf '%s\0' "${files[@]}" |
  xargs -0 --max-procs="$(nproc)" --max-args=1 "$clang_tidy" -p "$build" --quiet 2>&1 |
  { grep -avE '^[0-9]+ warnings?( and [0-9]+ errors?)? generated\.$' || true; }
echo "check_tidy: ${#files[@]} files in order"
