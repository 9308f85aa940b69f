#!/usr/bin/env bash
# From a mesh file to a committed store, and from a cold store to its digest: raw and with several
# compressions, in turn, on one disk or more.
#
#   bench/whole_runs.sh [OPTION...]       prints a row of a table for each disk, mesh and compression
#
#   --plait PROGRAM       default build/release/tools/plait
#   --dir DIR             on the bare disk; default /var/tmp
#   --disks LIST          of bare and kinds of tools/disktypes.sh such as ext4@300 (MB/s), with commas;
#                         default: bare,ext4@300. Throttled disks need root
#   --meshes LIST         of VERTICES@LEVEL: generated molecules; default 26016@5,545714@4, the sizes of Deo
#                         and Buddha
#   --rounds N            default 5; each round makes and reads every store once; figures are medians
#
# Each store has positions and normals. "raw" is what `--backend auto` chooses, "fast" the preset, "coded" the
# preset `default` without the stage `predicted`, so that each block is encoded, and "default" the preset as it
# is, which stores no block that Loop's rule makes again. A read is `plait digest` after the store's files
# have left the page cache; all digests of a mesh must be equal. The floor is dd, which writes as many zeros as
# the raw store has bytes, past the page cache and with fdatasync, and reads them again. The seconds of making a
# store, and the floor's, end when the bytes are on the disk.
#
# Exit status: 1 if a run failed or digests differ, 2 for bad usage.
#
# Examples:
#   sudo bench/whole_runs.sh
#   bench/whole_runs.sh --disks bare --meshes 2000@4 --rounds 1
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

plait=$here/build/release/tools/plait directory=/var/tmp disks=bare,ext4@300 meshes=26016@5,545714@4
rounds=5 made='' disk_name='' kept='' failed=0
readonly ways=(raw fast coded default)

refuse_usage() {
  echo "bench/whole_runs.sh: $* (see bench/whole_runs.sh --help)" >&2
  exit 2
}

parse() {
  while [ $# -gt 0 ]; do
    case $1 in
      -h | --help)
        sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"
        exit 0
        ;;
      --plait | --dir | --disks | --meshes | --rounds | --made | --disk-name)
        [ $# -gt 1 ] || refuse_usage "$1 needs a value"
        case $1 in
          --plait) plait=$2 ;;
          --dir) directory=$2 ;;
          --disks) disks=$2 ;;
          --meshes) meshes=$2 ;;
          --rounds) rounds=$2 ;;
          --made) made=$2 ;;           # by this script, for its own rows on one disk
          --disk-name) disk_name=$2 ;; # likewise
        esac
        shift 2
        ;;
      *) refuse_usage "unknown option $1" ;;
    esac
  done
  [[ $rounds =~ ^[1-9][0-9]{0,2}$ ]] || refuse_usage "--rounds: expected a whole number, found '$rounds'"
  [[ $meshes =~ ^[0-9]+@[0-9]+(,[0-9]+@[0-9]+)*$ ]] ||
    refuse_usage "--meshes: expected VERTICES@LEVEL, found '$meshes'"
  command -v "$plait" >/dev/null || refuse_usage "--plait $plait: no such program; tools/quickstart.sh builds it"
  command -v jq >/dev/null || refuse_usage "needs jq"
}

# options_of WAY: the options of `plait subdivide`, in the array `chosen`.
options_of() {
  case $1 in
    raw) chosen=() ;;
    coded) chosen=(--compress 'position=hierarchy,bitpack' --compress 'normal=normals,bitpack') ;;
    *) chosen=(--compress "$1") ;;
  esac
}

# timed COMMAND...: prints the seconds and the processor seconds of a command, system time included. The
# command's output goes to the descriptor 3, its messages to the descriptor 4.
timed() {
  local TIMEFORMAT='%R %U %S'
  { time "$@" >&3 2>&4; } 2>&1 | awk '{print $1, $2 + $3}'
}
exec 4>&2

# leave_page_cache PATH: what is in the files is on the disk already.
leave_page_cache() {
  find "$1" -type f -exec sh -c 'for f; do dd if="$f" iflag=nocache count=0 status=none; done' sh {} +
}

# run_once MESH LEVEL WAY FILE: appends "make seconds, processor seconds, bytes, read seconds, processor
# seconds, digest" to the file.
run_once() {
  local store=$directory/whole-run.plait made_in read_in chosen
  options_of "$3"
  rm -rf "$store"
  sync
  made_in=$(timed "$plait" subdivide "$1" "$store" --levels "$2" --normals "${chosen[@]}" --json \
    3>"$made/said.json")
  leave_page_cache "$store"
  read_in=$(timed "$plait" digest "$store" --json 3>"$made/digest.json")
  echo "$made_in $(jq -r .stored_bytes "$made/said.json") $read_in $(jq -r .digest "$made/digest.json")" >>"$4"
  rm -rf "$store"
}

# floor_once BYTES FILE: likewise, for dd.
floor_once() {
  local file=$directory/whole-run.zeros wrote_in read_in
  sync
  wrote_in=$(timed dd if=/dev/zero of="$file" bs=1M count="$(($1 >> 20))" oflag=direct conv=fdatasync status=none 3>/dev/null)
  leave_page_cache "$file"
  read_in=$(timed dd if="$file" of=/dev/null bs=1M iflag=direct status=none 3>/dev/null)
  echo "$wrote_in $1 $read_in -" >>"$2"
  rm -f "$file"
}

# median COLUMN FILE
median() { cut -d' ' -f"$1" "$2" | sort -g | sed -n "$(((rounds + 1) / 2))p"; }

# row NAME WAY FILE
row() {
  local bytes
  bytes=$(median 3 "$3")
  printf '| %s | %s | %s | %s | %s | %s | %s | %s |\n' "$disk_name" "$1" "$2" "$((bytes / 1000000))" \
    "$(median 1 "$3")" "$(median 2 "$3")" "$(median 4 "$3")" "$(median 5 "$3")"
}

# rows VERTICES LEVEL: of one mesh on $directory, the disk $disk_name.
rows() {
  local mesh=$made/$1.ply results=$made/results-$1 name="$1 vertices, level $2" way round bytes
  rm -rf "$results"
  mkdir "$results"
  for ((round = 0; round < rounds; ++round)); do
    for way in "${ways[@]}"; do run_once "$mesh" "$2" "$way" "$results/$way"; done
    bytes=$(cut -d' ' -f3 "$results/raw" | head -n 1)
    floor_once "$bytes" "$results/floor"
  done
  for way in floor "${ways[@]}"; do row "$name" "$way" "$results/$way"; done
  if [ "$(cat "${ways[@]/#/$results/}" | cut -d' ' -f6 | sort -u | wc -l)" -ne 1 ]; then
    echo "bench/whole_runs.sh: $name on $disk_name: the digests differ" >&2
    failed=1
  fi
}

all_rows() {
  local list mesh
  IFS=, read -ra list <<<"$meshes"
  for mesh in "${list[@]}"; do rows "${mesh%@*}" "${mesh#*@}"; done
}

remove_made() { [ -z "$kept" ] || rm -rf "$kept" "$directory/whole-run.plait" "$directory/whole-run.zeros"; }

parse "$@"
if [ -n "$made" ]; then # the rows of one disk
  all_rows
  exit "$failed"
fi
made=$(mktemp -d)
kept=$made
trap remove_made EXIT
trap 'exit 130' INT
trap 'exit 143' TERM
IFS=, read -ra list <<<"$meshes"
for mesh in "${list[@]}"; do
  "$plait" generate molecule "$made/${mesh%@*}.ply" --vertices "${mesh%@*}" --seed 1 >/dev/null
done
echo "| disk | mesh | store | MB | make, s | processor, s | read, s | processor, s |"
echo "|---|---|---|---|---|---|---|---|"
IFS=, read -ra list <<<"$disks"
for disk in "${list[@]}"; do
  arguments=(--plait "$plait" --meshes "$meshes" --rounds "$rounds" --made "$made" --disk-name "$disk")
  if [ "$disk" = bare ]; then
    "$0" "${arguments[@]}" --dir "$directory" || failed=1
  else
    "$here/tools/disktypes.sh" run --kinds "$disk" --size 12G --images "$directory" -- \
      "$0" "${arguments[@]}" --dir {} || failed=1
  fi
done
exit "$failed"
