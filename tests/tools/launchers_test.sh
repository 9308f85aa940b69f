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
case $launcher in
  parallel)
    seq 0 6 | parallel --will-cite -j 2 plait part p {} --threads 1 >/dev/null
    plait join p s.plait >/dev/null
    ;;
  snakemake)
    snakemake --snakefile "$examples/Snakefile" --cores 2 --config plan=p store=s.plait parts=7 >log 2>&1 ||
      { cat log >&2; exit 1; }
    ;;
  dask)
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
    "$python" "$examples/dask_parts.py" p s.plait >log 2>&1 || { cat log >&2; exit 1; }
    [ -d killed ] || { echo 'launchers_test: expected a killed worker' >&2; exit 1; }
    # Where all is done, the example joins and nothing else.
    "$python" "$examples/dask_parts.py" p again.plait >log 2>&1 || { cat log >&2; exit 1; }
    [ "$(plait digest again.plait)" = "$digest" ] || { echo 'launchers_test: expected a second store' >&2; exit 1; }
    ;;
esac
"$plait" verify s.plait >/dev/null
found=$("$plait" digest s.plait)
[ "$found" = "$digest" ] || { echo "launchers_test: expected $digest, found $found" >&2; exit 1; }
