#!/usr/bin/env bash
# One full report: all backends and `auto` on five kinds of disk, at two sizes beside the memory, with the
# default options: the presets fast and default, as many threads as processors. Makes the disks
# (bench/instrument/disktypes.sh), measures (plait bench run) and writes the report (plait bench report).
#
#   sudo bench/runs/all_disks.sh [OPTION...] [DIRECTORY]      default: report
#
#   --kinds LIST     default: ext4@200,xfs@200,btrfs@200,ext4,tmpfs
#   --rounds N       default: auto: four, and then more of what is not decided until the time is up
#   --memory SIZE    limit of each measured process; the stores have half and three times as much; default 96MiB
#   --minutes N      ends the measurement as Ctrl-C does: what there is becomes the report; default 43
#   --program FILE   default: build/release/tools/plait
#   --dry-run        says what would be measured in the working directory, beside how many minutes
#   --force          replaces the files in DIRECTORY
#
# DIRECTORY gets report.html, report.txt and runs.jsonl.zst (zstd -d gives the records, of which
# plait bench report makes the other two again).
#
# The sizes are small because the memory limit is: a page cache of 96 MiB serves no more of 288 MiB than one
# of 16 GiB of 64 GiB. Without root there is no limit and only tmpfs, and the report says so.
#
# Exit status: 1 if a run failed or backends gave different data, 2 for bad usage. The report is there in
# the first case too.
set -euo pipefail

kinds=ext4@200,xfs@200,btrfs@200,ext4,tmpfs
rounds=auto memory=96MiB minutes=43 dry_run=false force=false target=report
here=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
program=$here/build/release/tools/plait

refuse_usage() {
  echo "bench/runs/all_disks.sh: $* (see bench/runs/all_disks.sh --help)" >&2
  exit 2
}
while [ $# -gt 0 ]; do
  case $1 in
    --kinds | --rounds | --memory | --minutes | --program)
      [ $# -gt 1 ] || refuse_usage "$1 needs a value"
      declare "${1#--}=$2"
      shift 2 ;;
    --dry-run) dry_run=true; shift ;;
    --force) force=true; shift ;;
    -h | --help) sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "$0"; exit ;;
    -*) refuse_usage "unknown option '$1'" ;;
    *) target=$1; shift ;;
  esac
done
[[ $minutes =~ ^[1-9][0-9]{0,3}$ ]] || refuse_usage "--minutes: expected a whole number, found '$minutes'"
[ -x "$program" ] || refuse_usage "--program $program: no such program; tools/quickstart.sh builds it"
program=$(realpath "$program")

measure=("$program" bench run --memory "$memory" --rounds "$rounds" --time "${minutes}m"
  --workload build,sweep-read,sweep-update,patch-random,scan-export
  --backend pread,uring,mmap,compressed,auto --threads "$(nproc)")
if $dry_run; then
  IFS=, read -ra list <<<"$kinds"
  disks=()
  for kind in "${list[@]}"; do disks+=(--dir "$kind=."); done
  exec "${measure[@]}" "${disks[@]}" --dry-run
fi

for file in report.html report.txt runs.jsonl.zst; do
  [ ! -e "$target/$file" ] || $force || refuse_usage "$target/$file exists; --force replaces it"
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
status=0
# Status 124: the time was up, and what there is counts.
"$here/bench/instrument/disktypes.sh" run --kinds "$kinds" --size 6G -- \
  timeout --signal=INT --kill-after=120 "${minutes}m" \
  "${measure[@]}" --dir='{kind}={}' --out "$work/runs.jsonl" >"$work/said" || status=$?
[ -s "$work/runs.jsonl" ] || { echo "bench/runs/all_disks.sh: nothing was measured" >&2; exit 1; }
mkdir -p "$target"
# The page says how it was made.
cd "$work"
"$program" bench report runs.jsonl --html report.html >report.txt || status=$?
zstd -q -19 runs.jsonl -o runs.jsonl.zst
cd - >/dev/null
cp "$work"/{report.html,report.txt,runs.jsonl.zst} "$target/"
cat "$target/report.txt"
[ "$status" -eq 124 ] || exit "$status"
