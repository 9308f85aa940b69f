#!/usr/bin/env bash
# What is made of the program's --help: the completion of bash, and the manual pages.
#
#   help_users_test.sh PROGRAM PACKAGING
#
#   PACKAGING   the folder of the completion and of man_pages.sh
set -euo pipefail
program=$1 packaging=$2
here=$(mktemp -d)
trap 'rm -rf "$here"' EXIT
fail() { echo "help_users_test: $*" >&2; exit 1; }

ln -s "$program" "$here/plait"
PATH=$here:$PATH
# shellcheck source=/dev/null
source "$packaging/bash-completion/plait"
# completes EXPECTED WORD...: the last word is the one that the user has begun.
completes() {
  local expected=$1
  shift
  COMP_WORDS=("$@") COMP_CWORD=$(($# - 1))
  COMPREPLY=()
  _plait
  [ "${COMPREPLY[*]}" = "$expected" ] || fail "$*: expected '$expected', found '${COMPREPLY[*]}'"
}
completes bounds plait bo
completes "digest" plait dig
completes --attribute plait bounds --at
completes "auto float32 float64" plait subdivide --precision ""
completes molecule plait generate mol
completes "" plait bounds su

"$packaging/man_pages.sh" "$program" "$here/pages"
commands=$("$program" --help | awk '/^Subcommands:/ { on = 1; next } /^$/ { on = 0 } on { print $1 }')
[ "$(wc -w <<<"$commands")" -ge 12 ] || fail "expected all commands in --help, found $commands"
for command in $commands; do
  page=$(gzip -dc "$here/pages/plait-$command.1.gz")
  for part in '.SH NAME' '.SH SYNOPSIS' '.SH OPTIONS' '.SH EXAMPLES' '.SH SEE ALSO'; do
    grep -qi "^$part" <<<"$page" || fail "manual page of $command: expected '$part'"
  done
done
gzip -dc "$here/pages/plait-bounds.1.gz" | grep -q '^\.B \\-\\-attribute' ||
  fail "manual page of bounds: expected its options"
