#!/usr/bin/env bash
# Prints the code blocks of a page, one after another.
#
#   code_blocks.sh PAGE LANGUAGE [HEADING]
#
#   LANGUAGE   the word after the three backquotes: cpp, c, cmake, sh. Blocks of C++ are preceded by
#              #line, so that the compiler names the page and its line
#   HEADING    only the blocks between this heading (without its #) and the next one
#
# A block marked `sh` can be run by a test; a block marked `console` is for people: it needs root, or
# takes long. Fails if there is no such block.
set -euo pipefail

if [ $# -lt 2 ] || [ $# -gt 3 ]; then
  sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "$0" >&2
  exit 2
fi
awk -v language="$2" -v heading="${3:-}" -v page="$1" '
  in_block && /^```$/ { in_block = 0; next }
  in_block == 1 { print; next }
  in_block { next }
  /^```/ {
    in_block = 2
    if ($0 == "```" language && (heading == "" || here)) {
      in_block = 1
      found = 1
      if (language == "cpp" || language == "c") printf "#line %d \"%s\"\n", NR + 1, page
    }
    next
  }
  /^#+ / { text = $0; sub(/^#+ /, "", text); here = text == heading }
  END {
    if (found) exit 0
    print "code_blocks: no block of " language " in " page (heading == "" ? "" : ", " heading) >"/dev/stderr"
    exit 1
  }' "$1"
