#!/usr/bin/env bash
# Runs clang-tidy (.clang-tidy) over the sources, and our headers by way of them. Tests are left
# out to save time unless asked for.
#
#   tools/dev/check_tidy.sh [--tests] [FILE...]      default: all sources
#
# PLAIT_CLANG_TIDY names another clang-tidy than clang-tidy-14.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
clang_tidy=${PLAIT_CLANG_TIDY:-clang-tidy-14}

folders='engine|backends|kernels|tools|examples|bench'
if [ "${1:-}" = --tests ]; then
  folders+='|tests'
  shift
fi

cmake --preset release -DPLAIT_TESTS=ON -DPLAIT_TOOLS=ON -DPLAIT_EXAMPLES=ON --log-level=WARNING \
  >/dev/null

files=("$@")
if [ ${#files[@]} -eq 0 ]; then
  # Largest first, so that no processor waits at the end for one that began last.
  mapfile -t files < <(
    sed -n "s|^ *\"file\": \"$PWD/\(.*\)\",\{0,1\}\$|\1|p" build/release/compile_commands.json |
      grep -E "^($folders)/" | sort -u | xargs -r ls -S
  )
fi
if [ ${#files[@]} -eq 0 ]; then
  echo "check_tidy: found no source file" >&2
  exit 1
fi

# Clang counts the warnings in the system's headers, which nobody asked for.
printf '%s\0' "${files[@]}" |
  xargs -0 --max-procs="$(nproc)" --max-args=1 "$clang_tidy" -p build/release --quiet 2>&1 |
  { grep -vE '^[0-9]+ warnings?( and [0-9]+ errors?)? generated\.$' || true; }
echo "check_tidy: ${#files[@]} files in order"
