#!/usr/bin/env bash
# Runs the commands of the page about many machines in the current directory. The digest that the
# page promises must be that of one process.
#
#   many_machines_test.sh PLAIT PAGE
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd) plait=$1
mkdir bin && ln -s "$plait" bin/plait
export PATH="$PWD/bin:$PATH"
sh -e -c "$("$here/code_blocks.sh" "$2" sh)" >printed
cat printed
plait subdivide molecule.ply one.plait --levels 4 --normals >/dev/null
digest=$(plait digest one.plait)
grep -qx "$digest" printed || { echo "many_machines_test: expected $digest" >&2; exit 1; }
