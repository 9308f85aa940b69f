#!/usr/bin/env bash
# Holds the advice of `plait tune` against an exhaustive run, and its prediction of a full read against
# the measured one: on six surfaces and three disks, or on those that are named.
#
#   bench/tune_check.sh [OPTION...]                 prints a row of a table for each surface and disk
#
#   --plait PROGRAM    default build/release/tools/plait
#   --dir DIR          on the bare disk; default /var/tmp
#   --ram DIR          a file system in memory, also for the surfaces themselves; default /dev/shm
#   --disks LIST       of bare, ext4@300 (MB/s; or another kind of tools/disktypes.sh) and ram, with
#                      commas; default: these three. Throttled disks need root
#   --surfaces LIST    of exact, noise1e-7, noise3e-7, fractal, white, and sphere or scan; default: all,
#                      with scan if there is a --mesh
#   --mesh FILE        a scan instead of the sphere, refined --mesh-levels times (default 3)
#   --vertices N       of the base mesh of the other surfaces; default 2000
#   --levels L         how often it is refined; default 5: 50 MB of positions and normals
#   --seconds N        for each run of `plait tune`; default 20
#   --out DIR          keeps the JSON of each run as SURFACE-DISK.json
#
# A run takes about a minute for each surface and disk, with two processors. Exit status: 1 if a pick was more
# than 5 % behind the best or a prediction more than 20 % wrong; 2 for bad usage.
#
# Examples:
#   sudo bench/tune_check.sh --mesh bunny.ply --out checks
#   bench/tune_check.sh --disks bare,ram --surfaces exact,fractal
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

plait=$here/build/release/tools/plait directory=/var/tmp ram=/dev/shm disks=bare,ext4@300,ram
surfaces='' mesh='' mesh_levels=3 vertices=2000 levels=5 seconds=20 out='' made='' disk_name='' kept=''
failed=0

refuse_usage() {
  echo "bench/tune_check.sh: $* (see bench/tune_check.sh --help)" >&2
  exit 2
}

parse() {
  while [ $# -gt 0 ]; do
    case $1 in
      -h | --help)
        sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"
        exit 0
        ;;
      --plait | --dir | --ram | --disks | --surfaces | --mesh | --mesh-levels | --vertices | --levels | \
        --seconds | --out | --made | --disk-name)
        [ $# -gt 1 ] || refuse_usage "$1 needs a value"
        case $1 in
          --plait) plait=$2 ;;
          --dir) directory=$2 ;;
          --ram) ram=$2 ;;
          --disks) disks=$2 ;;
          --surfaces) surfaces=$2 ;;
          --mesh) mesh=$2 ;;
          --mesh-levels) mesh_levels=$2 ;;
          --vertices) vertices=$2 ;;
          --levels) levels=$2 ;;
          --seconds) seconds=$2 ;;
          --out) out=$2 ;;
          --made) made=$2 ;;           # by this script, for its own rows on one disk
          --disk-name) disk_name=$2 ;; # likewise
        esac
        shift 2
        ;;
      *) refuse_usage "unknown option $1" ;;
    esac
  done
  [ -n "$surfaces" ] || surfaces=exact,noise1e-7,noise3e-7,fractal,white,$([ -n "$mesh" ] && echo scan || echo sphere)
  command -v "$plait" >/dev/null || refuse_usage "--plait $plait: no such program"
  command -v jq >/dev/null || refuse_usage "needs jq"
}

# make SURFACE: as $made/SURFACE.plait.
make() {
  local store=$made/$1.plait base=$made/base.ply exact=$made/exact.plait
  [ ! -d "$store" ] || return 0
  case $1 in
    exact)
      "$plait" generate molecule "$base" --vertices "$vertices" >/dev/null
      "$plait" subdivide "$base" "$store" --levels "$levels" --normals --json >/dev/null
      return
      ;;
    sphere)
      "$plait" generate icosphere "$base.sphere.ply" --vertices "$vertices" >/dev/null
      "$plait" subdivide "$base.sphere.ply" "$store" --levels "$levels" --normals --json >/dev/null
      return
      ;;
    scan)
      [ -n "$mesh" ] || refuse_usage "surface scan needs --mesh"
      "$plait" subdivide "$mesh" "$store" --levels "$mesh_levels" --normals --json >/dev/null
      return
      ;;
  esac
  make exact
  case $1 in
    noise1e-7) "$plait" displace "$exact" "$store" --kind noise --amplitude 1e-7 --json >/dev/null ;;
    noise3e-7) "$plait" displace "$exact" "$store" --kind noise --amplitude 3e-7 --json >/dev/null ;;
    fractal) "$plait" displace "$exact" "$store" --kind fractal --amplitude 0.005 --json >/dev/null ;;
    white) "$plait" displace "$exact" "$store" --kind noise --amplitude 0.5 --json >/dev/null ;;
    *) refuse_usage "--surfaces: unknown surface $1" ;;
  esac
}

# check SURFACE: prints the row of the surface on $directory, the disk $disk_name.
check() {
  local json=$made/$1-$disk_name.json
  if ! "$plait" tune "$made/$1.plait" --dir "$directory" --seconds "$seconds" --exhaustive --json >"$json"; then
    echo "bench/tune_check.sh: $1 on $disk_name: plait tune failed: $(jq -r '.error.message? // empty' "$json")" >&2
    failed=1
    return
  fi
  [ -z "$out" ] || cp "$json" "$out/"
  jq -r --arg surface "$1" --arg disk "$disk_name" '
    def percent: . * 1000 | round / 10 | tostring + " %";
    def milliseconds: . * 1e5 | round / 100 | tostring;
    .exhaustive as $e | $e.finalists[0] as $pick |
    [$surface, $disk, $pick.choice, ($pick.read_seconds | milliseconds), $e.finalists[$e.best].choice,
     ($e.finalists[$e.best].read_seconds | milliseconds), ($e.pick_behind_best | percent),
     ($pick.predicted_read_seconds | milliseconds), ($e.error_of_prediction | percent)]
    | "| " + join(" | ") + " |"' "$json"
  jq -e '.exhaustive | .pick_behind_best <= 0.05 and .error_of_prediction <= 0.2 and .error_of_prediction >= -0.2' \
    "$json" >/dev/null || failed=1
}

rows() {
  local surface list
  IFS=, read -ra list <<<"$surfaces"
  for surface in "${list[@]}"; do check "$surface"; done
}

remove_made() { [ -z "$kept" ] || rm -rf "$kept"; }

parse "$@"
if [ -n "$made" ]; then # the rows of one disk
  rows
  exit "$failed"
fi
[ -z "$out" ] || mkdir -p "$out"
made=$(mktemp -d "$ram/plait-tune-check-XXXXXX")
kept=$made
trap remove_made EXIT
trap 'exit 130' INT
trap 'exit 143' TERM
IFS=, read -ra list <<<"$surfaces"
for surface in "${list[@]}"; do make "$surface"; done
echo "| surface | disk | pick | read, ms | best of all | read, ms | pick behind best | predicted, ms | measured against predicted |"
echo "|---|---|---|---|---|---|---|---|---|"
IFS=, read -ra disk_list <<<"$disks"
for disk in "${disk_list[@]}"; do
  arguments=(--plait "$plait" --surfaces "$surfaces" --seconds "$seconds" --made "$made" --disk-name "$disk")
  [ -z "$out" ] || arguments+=(--out "$out")
  case $disk in
    bare) "$0" "${arguments[@]}" --dir "$directory" || failed=1 ;;
    ram) "$0" "${arguments[@]}" --dir "$ram" || failed=1 ;;
    *)
      "$here/tools/disktypes.sh" run --kinds "$disk" --size 2G --images "$directory" -- \
        "$0" "${arguments[@]}" --dir {} || failed=1
      ;;
  esac
done
exit "$failed"
