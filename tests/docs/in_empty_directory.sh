#!/usr/bin/env bash
# Empties DIRECTORY, and runs a command in it.
#
#   in_empty_directory.sh DIRECTORY COMMAND...
set -euo pipefail

rm -rf "$1"
mkdir -p "$1"
cd "$1"
shift
"$@"
