#!/usr/bin/env bash
# Runs the program of docs/guide.md, and then the commands of that page and of docs/measuring.md, in the current
# directory.
#
#   guide_test.sh GUIDE_PROGRAM DOCS [PLAIT]
#
# A program of a few lines that uses no plait (Loop's scheme in double, with a dictionary of edges) gave
# the area.
set -euo pipefail
program=$1 docs=$2 plait=${3:-}
"$program" >printed
diff printed - <<'END' || { echo "guide_test: the program printed the lines marked with <, expected those with >" >&2; exit 1; }
area 2.193
beside a reader: 1
cancelled: 1
backends: 1
END
if [ -n "$plait" ]; then
  PATH=$(dirname "$plait"):$PATH
  for page in guide measuring; do
    "$(dirname "$0")/code_blocks.sh" "$docs/$page.md" sh
  done >commands
  # shellcheck disable=SC1091
  . ./commands
fi
