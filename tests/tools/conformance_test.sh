#!/usr/bin/env bash
# The program plait-conformance: a good backend keeps its promises, a broken one does not, and what
# cannot be run is refused.
#
#   conformance_test.sh PROGRAM OWN_BACKEND OWN_CODEC BROKEN_BACKEND OWN_FILES_BACKEND
set -euo pipefail
program=$1 own_backend=$2 own_codec=$3 broken_backend=$4 own_files_backend=$5
here=$(mktemp -d)
trap 'rm -rf "$here"' EXIT

# expect STATUS TEXT ARGUMENTS...: runs the program; TEXT is in what it prints.
expect() {
  local status=$1 text=$2 found=0
  shift 2
  output=$("$program" --directory "$here" "$@" 2>&1) || found=$?
  if [ "$found" != "$status" ] || [[ $output != *"$text"* ]]; then
    printf '%s\nexpected status %s and "%s", found status %s and:\n%s\n' "$*" "$status" "$text" \
      "$found" "$output"
    exit 1
  fi
}

expect 0 'x-map, pipeline none: 11 promises kept, 0 broken, 0 left out' \
  --plugin "$own_backend" --backend x-map
expect 0 'x-files, pipeline none: 20 promises kept, 0 broken, 0 left out' \
  --plugin "$own_files_backend" --backend x-files
expect 0 'codec-gives-back           kept; ' --plugin "$own_codec" --backend compressed \
  --pipeline x-delta+shuffle,x-runs --only codec-gives-back
expect 0 'compressed, pipeline x-delta+shuffle,x-runs: 24 promises kept, 0 broken, 0 left out' \
  --plugin "$own_codec" --backend compressed --pipeline x-delta+shuffle,x-runs
expect 1 'flipped-bit                BROKEN: A flipped bit of a stored block is found' \
  --plugin "$broken_backend" --backend x-trusting
expect 1 'expected that a flipped bit of a stored block is found (kCorruption) (smooth content, byte 0' \
  --plugin "$broken_backend" --backend x-trusting --only flipped-bit
expect 0 '1 promises kept' --plugin "$broken_backend" --backend x-trusting --only threads
expect 1 '"broken": 4' --plugin "$broken_backend" --backend x-trusting --json
expect 2 'open backend "x-map": expected one of compressed' --backend x-map
expect 2 'open backend "x-map:depth=8": expected one of' --plugin "$own_backend" --backend x-map:depth=8
expect 2 'expected pipeline "none", found "lz4"' --backend pread --pipeline lz4
expect 2 'load plug-in: open /dev/null: expected a regular file' --plugin /dev/null --backend pread
expect 2 'expected --backend NAME'
expect 2 '--only' --backend pread --only everything
expect 0 'read-never-written         A block that was never written reads as zeros.' --list
expect 0 'Examples:' --help
if [ -n "$(ls "$here")" ]; then
  echo "the program left files: $(ls "$here")"
  exit 1
fi
