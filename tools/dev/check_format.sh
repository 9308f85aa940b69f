#!/usr/bin/env bash
# Fails if a file does not have the format of .clang-format and .editorconfig.
#
#   tools/dev/check_format.sh          names each place
#   tools/dev/check_format.sh --fix    formats the C++ files
#
# PLAIT_CLANG_FORMAT in the environment names another program than clang-format-14.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
clang_format=${PLAIT_CLANG_FORMAT:-clang-format-14}

# Files that are not yet added to git count too, because they are new.
list() { git ls-files --cached --others --exclude-standard -z -- "$@"; }

if [ "${1:-}" = --fix ]; then
  list '*.h' '*.c' '*.cpp' | xargs -0 --no-run-if-empty "$clang_format" -i
  exit 0
fi

failed=0
list '*.h' '*.c' '*.cpp' | xargs -0 --no-run-if-empty "$clang_format" --dry-run -Werror || failed=1

text_files=('*.h' '*.c' '*.cpp' '*.sh' '*.md' '*.txt' '*.json' '*.cmake' .ci/run .clang-format .clang-tidy)
if list "${text_files[@]}" | xargs -0 --no-run-if-empty grep -nE '[[:blank:]]+$|'$'\r' /dev/null; then
  echo "check_format: blanks or a carriage return at the end of the lines above" >&2
  failed=1
fi
while IFS= read -r -d '' file; do
  if [ -s "$file" ] && [ -n "$(tail -c 1 "$file")" ]; then
    echo "check_format: $file: no newline at its end" >&2
    failed=1
  fi
done < <(list "${text_files[@]}")
while IFS= read -r -d '' script; do
  bash -n "$script" || failed=1
done < <(list '*.sh' .ci/run)
exit $failed
