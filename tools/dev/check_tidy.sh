#!/usr/bin/env bash
# Runs clang-tidy (.clang-tidy) over the sources, and our headers by way of them. Tests are left
# out to save time unless asked for.
#
#   tools/dev/check_tidy.sh [--tests] [--since COMMIT] [FILE...]      default: all sources
#
#   --since COMMIT   only sources that differ from this commit, and for each header that does one
#                    source that includes it; everything if .clang-tidy differs
#
# PLAIT_CLANG_TIDY names another clang-tidy than clang-tidy-14.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
clang_tidy=${PLAIT_CLANG_TIDY:-clang-tidy-14}

folders='engine|backends|kernels|tools|examples|bench'
since=
while [ $# -gt 0 ]; do
  case $1 in
    --tests) folders+='|tests' ;;
    --since)
      since=${2:?--since needs a commit}
      shift
      ;;
    *) break ;;
  esac
  shift
done

# A build that is only configured: clang-tidy cannot read what GCC precompiles.
build=build/tidy
cmake --preset release -B "$build" -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON -DPLAIT_TESTS=ON \
  -DPLAIT_TOOLS=ON -DPLAIT_EXAMPLES=ON --log-level=WARNING >/dev/null

# Largest first, so that no processor waits at the end for one that began last.
built_sources() {
  sed -n "s|^ *\"file\": \"$PWD/\(.*\)\",\{0,1\}\$|\1|p" "$build"/compile_commands.json |
    grep -E "^($folders)/" | sort -u | xargs -r ls -S
}

# The sources of the list `all` that clang-tidy reads for what changed since a commit.
changed_sources() {
  local changed header includers
  mapfile -t changed < <(git diff --name-only --diff-filter=d "$1" -- '*.cpp' '*.h')
  {
    printf '%s\n' "${changed[@]}" | grep '\.cpp$' || true
    for header in $(printf '%s\n' "${changed[@]}" | grep '\.h$'); do
      includers=$(grep -lE "#include \"([^\"]*/)?${header##*/}\"" "${all[@]}" || true)
      # The source of the same name, or else the smallest: one is enough to see the header by.
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

# Clang counts the warnings in the system's headers, which nobody asked for.
printf '%s\0' "${files[@]}" |
  xargs -0 --max-procs="$(nproc)" --max-args=1 "$clang_tidy" -p "$build" --quiet 2>&1 |
  { grep -avE '^[0-9]+ warnings?( and [0-9]+ errors?)? generated\.$' || true; }
echo "check_tidy: ${#files[@]} files in order"
