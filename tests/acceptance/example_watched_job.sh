#!/usr/bin/env bash
# The example watched_job: finishes, is cancelled, and continues from the last commit.
#
#   example_watched_job.sh PROGRAM MESH
set -euo pipefail
here=$(mktemp -d)
trap 'rm -rf "$here"' EXIT
expect() {
  local status=$1 text=$2 found=0
  shift 2
  output=$("$@" 2>&1) || found=$?
  if [ "$found" != "$status" ] || [[ $output != *"$text"* ]]; then
    printf 'expected status %s and "%s", found status %s and:\n%s\n' "$status" "$text" "$found" "$output"
    exit 1
  fi
}
expect 0 'level 2,' "$1" "$2" "$here/s.plait" 2
expect 3 'cancelled' "$1" "$2" "$here/s.plait" 5 0
expect 0 'continues from level 2' "$1" "$2" "$here/s.plait" 5
expect 0 'continues from level 5' "$1" "$2" "$here/s.plait" 5
