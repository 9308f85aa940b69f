#!/usr/bin/env bash
# Checks the command line of every measurement: each option has a help text, bad usage gives status
# 2, and an interrupted program leaves no file.
#
#   tests/bench/usage.sh DIRECTORY_OF_THE_PROGRAMS
set -euo pipefail
programs=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failures=0
fail() {
  echo "$*" >&2
  failures=$((failures + 1))
}

for program in "$programs"/plait_bench_*; do
  [ -x "$program" ] && [ ! -d "$program" ] || continue
  name=${program##*/}
  # A help text begins in column 31; if the option is too long, in column 31 of the next line.
  "$program" --help | awk '
    function tell() { if (bare != "") print bare; bare = "" }
    /^  -/ { tell(); if (length($0) <= 30 || substr($0, 30, 1) != " ") bare = $1; next }
    substr($0, 1, 30) ~ /^ +$/ { bare = "" }
    END { tell() }' >"$work/bare"
  [ ! -s "$work/bare" ] || fail "$name: options without help: $(cat "$work/bare")"
  status=0
  "$program" --no-such-option >/dev/null 2>&1 || status=$?
  [ "$status" -eq 2 ] || fail "$name --no-such-option: expected status 2, found $status"
done

for name in at_overhead patch_reads; do
  mkdir "$work/$name"
  "$programs/plait_bench_$name" --runs 1000 --directory "$work/$name" >/dev/null 2>&1 &
  running=$!
  for _ in $(seq 600); do
    [ -n "$(ls -A "$work/$name")" ] && break
    sleep 0.05
  done
  [ -n "$(ls -A "$work/$name")" ] || fail "$name: it made no file"
  kill -TERM "$running"
  status=0
  wait "$running" || status=$?
  [ "$status" -eq 143 ] || fail "$name interrupted: expected status 143, found $status"
  [ -z "$(ls -A "$work/$name")" ] || fail "$name interrupted: it left $(ls "$work/$name")"
done
exit "$((failures > 0))"
