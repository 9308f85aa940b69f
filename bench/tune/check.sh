#!/usr/bin/env bash
# Holds the advice of `plait tune` against an exhaustive run (plait_bench_tune), on seven surfaces and three disks,
# or on those that are named.
#
#   bench/tune/check.sh [OPTION...]                 prints a row of a table for each surface and disk
#
#   --build DIR        of plait and its measurements; default build/release
#   --dir DIR          on the bare disk; default /var/tmp
#   --ram DIR          a file system in memory, also for the surfaces themselves; default /dev/shm
#   --disks LIST       of bare, ext4@300 (MB/s; or another kind of bench/instrument/disktypes.sh) and ram, with
#                      commas; default: these three. Throttled disks need root
#   --surfaces LIST    of exact, noise1e-7, noise3e-7, fractal, white, scan and remeshed; default: all
#                      but scan and remeshed, which need --mesh (a scan) and --remeshed (a store)
#   --levels L         of 2,000 base vertices; default 5: 50 MB of positions and normals
#   --seconds N        for each run of `plait tune`; default 60
#
# A row takes about five minutes. Exit status: 1 if more than a tenth of the picks was over 5 % behind the best;
# 2 for bad usage.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
build=$here/build/release directory=/var/tmp ram=/dev/shm disks=bare,ext4@300,ram levels=5 seconds=60
surfaces=exact,noise1e-7,noise3e-7,fractal,white mesh='' remeshed='' rows=0 missed=0

refuse_usage() {
  echo "bench/tune/check.sh: $* (see bench/tune/check.sh --help)" >&2
  exit 2
}
while [ $# -gt 0 ]; do
  case $1 in
    -h | --help) sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "$0"; exit ;;
    --build | --dir | --ram | --disks | --surfaces | --levels | --seconds | --mesh | --remeshed)
      [ $# -gt 1 ] || refuse_usage "$1 needs a value"
      case $1 in --dir) directory=$2 ;; *) declare "${1#--}=$2" ;; esac
      shift 2 ;;
    *) refuse_usage "unknown option $1" ;;
  esac
done
plait=$build/tools/plait
[ -x "$plait" ] && [ -x "$build/bench/plait_bench_tune" ] || refuse_usage "--build $build: no plait and plait_bench_tune there"
[ -z "$mesh" ] || surfaces=$surfaces,scan
[ -z "$remeshed" ] || surfaces=$surfaces,remeshed
made=$(mktemp -d "$ram/plait-tune-check-XXXXXX")
trap 'rm -rf "$made"' EXIT

# make SURFACE: as $made/SURFACE.plait.
make() {
  local kind amplitude base=$made/base.ply from=$made/exact.plait
  case $1 in
    remeshed) cp -r "$remeshed" "$made/remeshed.plait"; return ;;
    scan) "$plait" subdivide "$mesh" "$made/scan.plait" --levels 3 --normals --json >/dev/null; return ;;
    exact)
      "$plait" generate molecule "$base" --vertices 2000 >/dev/null
      "$plait" subdivide "$base" "$from" --levels "$levels" --normals --json >/dev/null
      rm "$base"
      return ;;
    fractal) kind=fractal amplitude=0.005 ;;
    white) kind=noise amplitude=0.5 ;;
    noise*) kind=noise amplitude=${1#noise} ;;
    *) refuse_usage "--surfaces: unknown surface $1" ;;
  esac
  [ -d "$from" ] || make exact
  "$plait" pass "$from" "$kind" "$made/$1.plait" --amplitude "$amplitude" --json >/dev/null
}

IFS=, read -ra surface_list <<<"$surfaces"
IFS=, read -ra disk_list <<<"$disks"
for surface in "${surface_list[@]}"; do [ -d "$made/$surface.plait" ] || make "$surface"; done
echo "| disk | surface | pick | MiB | read | best of all | MiB | read | pick behind best |"
echo "|---|---|---|---|---|---|---|---|---|"
for disk in "${disk_list[@]}"; do
  for surface in "${surface_list[@]}"; do
    measure=("$build/bench/plait_bench_tune" "$made/$surface.plait" --seconds "$seconds" --dir)
    case $disk in
      bare) measure+=("$directory") ;;
      ram) measure+=("$ram") ;;
      *) measure=("$here/bench/instrument/disktypes.sh" run --kinds "$disk" --size 2G --images "$directory" -- "${measure[@]}" {}) ;;
    esac
    rows=$((rows + 1))
    row=$("${measure[@]}") || missed=$((missed + 1))
    echo "| $disk $row"
  done
done
[ $((10 * missed)) -le "$rows" ]
