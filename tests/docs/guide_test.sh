#!/usr/bin/env bash
# Runs the program of docs/guide.md, and then the commands of the page, in the current directory.
#
#   guide_test.sh GUIDE_PROGRAM PAGE [PLAIT]
#
# A program of a few lines that uses no plait (Loop's scheme in double, with a dictionary of edges) gave
# the two areas. Euler's formula gives the number of vertices. The largest distance is that of the
# corners: 1 - 4 w of the first one, w = 1 / (4 + 3 / (8 b')), b' as in docs/kernels.md.
# Four of an octahedron's faces are above its middle.
set -euo pipefail
program=$1 page=$2 plait=${3:-}
"$program" >printed
grep -v '^a small budget: ' printed | diff - <(cat <<'END'
4098 vertices
area 2.193, largest distance 0.436
4 of 8 patches above
own backend: 1
beside a reader: 1
cancelled: 1
backends: 1
missing store: 1
own rule: area 5.751
END
) || { echo "guide_test: the program printed the lines marked with <, expected those with >" >&2; exit 1; }
grep -q '^a small budget: .*65536' printed
if [ -n "$plait" ]; then
  PATH=$(dirname "$plait"):$PATH
  "$(dirname "$0")/code_blocks.sh" "$page" sh >commands
  # shellcheck disable=SC1091
  . ./commands
fi
