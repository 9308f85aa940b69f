#!/usr/bin/env bash
# Makes the reference of the public headers with Doxygen. Fails if Doxygen warns of anything, or if a
# public class has no comment.
#
#   tools/dev/check_reference.sh            makes it in a temporary directory
#   tools/dev/check_reference.sh OUTPUT     makes OUTPUT/html/index.html
#
#   tools/dev/check_reference.sh --filter FILE     prints FILE as Doxygen reads it
set -euo pipefail

# The comment at the head of a header begins with two slashes, and the comments of a header in C with
# one asterisk; Doxygen wants one more of each. As many lines come out as go in, so that warnings name
# the right line.
filter() {
  awk '
    NR == 1 { head = /^\/\// ? "//" : "/*"; in_c = head == "/*" }
    head == "//" && /^\/\// {
      # Markdown takes lines that are indented by four blanks, after an empty line, for code.
      sub(/^\/\//, "///")
      code = /^\/\/\/   +[^-0-9 ]/ && (code || empty)
      if (code) sub(/^\/\/\//, "///   ")
      empty = /^\/\/\/$/
    }
    head == "//" && /^#pragma once/ { $0 = "/// @file"; head = "" }
    in_c && !/\/\* ----/ {
      if (/^ *\/\* /) sub(/\/\* /, "/** "); else sub(/\/\* /, "/**< ")
      if (head == "/*" && sub(/ \*\/$/, " @file */")) head = ""
    }
    { print }' "$1"
}
if [ "${1:-}" = --filter ]; then
  filter "$2"
  exit
fi

cd "$(dirname "${BASH_SOURCE[0]}")/../.."
if ! command -v doxygen >/dev/null; then
  echo "check_reference: no doxygen; tools/dev/install_packages.sh checks installs it" >&2
  exit 1
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
output=${1:-$work/output}
mkdir -p "$output"
version=$(sed -nE 's/^project\(plait VERSION ([0-9.]+).*/\1/p' CMakeLists.txt)
includes=$(find "$PWD" -path "$PWD/build" -prune -o -type d -name include -print | LC_ALL=C sort | tr '\n' ' ')

# run STRICT LENIENT: Doxygen's warnings.
run() {
  sed -e "s#@VERSION@#$version#; s#@OUTPUT@#$output#; s#@INPUT@#$includes#; s#@STRICT@#$1#; s#@LENIENT@#$2#" \
    -e "s#@FILTER@#bash $PWD/tools/dev/check_reference.sh --filter#" docs/Doxyfile.in >"$work/Doxyfile"
  doxygen "$work/Doxyfile" 2>&1
}
run YES NO >"$work/strict"
run NO YES >"$work/warnings"
# Specialisations of templates need no comment of their own.
grep -E 'Compound [^<]* is not documented' "$work/strict" >>"$work/warnings" || true
if [ -s "$work/warnings" ]; then
  sed "s#$PWD/##" "$work/warnings" >&2
  echo "check_reference: expected no warning, found $(wc -l <"$work/warnings")" >&2
  exit 1
fi
[ $# -eq 0 ] || echo "$output/html/index.html"
