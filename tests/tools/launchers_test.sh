#!/usr/bin/env bash
# Programs that start many commands make the parts of a plan, as docs/many-machines.md and the examples
# say. Skipped if there is no such program.
#
#   launchers_test.sh PLAIT EXAMPLES LAUNCHER       parallel, snakemake or dask
set -euo pipefail
plait=$1 examples=$2 launcher=$3
python=/usr/bin/python3
skip() { echo "launchers_test: skipped: $*"; exit 77; }
case $launcher in
  parallel) parallel --version 2>/dev/null | grep -q GNU || skip 'no GNU parallel' ;;  # moreutils has another one
  snakemake) command -v snakemake >/dev/null || skip 'no snakemake' ;;
  dask) "$python" -c 'import dask.distributed' 2>/dev/null || skip "no dask.distributed for $python" ;;
esac
here=$(mktemp -d)
trap 'rm -rf "$here"' EXIT
mkdir "$here/bin" && ln -s "$plait" "$here/bin/plait"
export PATH="$here/bin:$PATH" HOME="$here" DASK_DISTRIBUTED__WORKER__DAEMON=false
cd "$here"
plait generate torus m.ply --vertices 500 >/dev/null
plait subdivide m.ply whole.plait --levels 4 --normals >/dev/null
digest=$(plait digest whole.plait)
plait plan m.ply p --levels 4 --normals --parts 7 >/dev/null
# make PLAN STORE: all parts, and the join.
make() {
  case $launcher in
    parallel) seq 0 6 | parallel --will-cite -j 2 plait part "$1" {} --threads 1 && plait join "$1" "$2" ;;
    snakemake) snakemake --snakefile "$examples/Snakefile" --cores 2 --config plan="$1" store="$2" parts=7 ;;
    dask) "$python" "$examples/dask_parts.py" "$1" "$2" ;;
  esac >log 2>&1 || { cat log >&2; exit 1; }
}
# expect DIGEST: the store is whole, and has it.
expect() {
  plait verify s.plait >/dev/null
  found=$(plait digest s.plait)
  [ "$found" = "$1" ] || { echo "launchers_test: expected $1, found $found" >&2; exit 1; }
}
if [ "$launcher" = dask ]; then
  # One worker is killed while it makes a part: the program that it runs kills it.
  mv bin/plait bin/real
  cat >bin/plait <<'SCRIPT'
#!/bin/sh
if [ "$1" = part ] && mkdir killed 2>/dev/null; then
  "${0%/*}/real" "$@" &
  kill -KILL "$PPID"
  exit 1
fi
exec "${0%/*}/real" "$@"
SCRIPT
  chmod +x bin/plait
fi
make p s.plait
[ "$launcher" != dask ] || [ -d killed ] || { echo 'launchers_test: expected a killed worker' >&2; exit 1; }
expect "$digest"
make p s.plait  # all is done and joined
make p again.plait
[ "$(plait digest again.plait)" = "$digest" ] || { echo 'launchers_test: expected a second store' >&2; exit 1; }

# A pass changes its store, which no launcher may remove before.
plait pass whole.plait smooth >/dev/null
plait plan --pass smooth s.plait p2 >/dev/null
make p2 s.plait
plait plan --pass normals s.plait p3 >/dev/null
make p3 s.plait
expect "$(plait digest whole.plait)"
make p3 s.plait
expect "$(plait digest whole.plait)"
