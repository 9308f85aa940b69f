#!/usr/bin/env bash
# Is the present commit slower than an earlier one? Builds both, lets them measure the same cells in turn, and
# compares the records (plait bench compare).
#
#   bench/runs/against.sh COMMIT [--rounds N] [OPTION OF plait bench run...]
#
#   --rounds N   rounds of each; default 5
#
# Without further options: build, sweep-read and sweep-update of pread and compressed under a memory limit of
# 64 MiB, in the working directory. The records stay in bench-before.jsonl and bench-after.jsonl.
#
# Exit status: that of the comparison, 1 for a regression; 2 for bad usage.
set -euo pipefail
case ${1:-} in
  -h | --help) sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "$0"; exit ;;
  '' | -*) echo "bench/runs/against.sh: expected a commit (see --help)" >&2; exit 2 ;;
esac
source=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
before=$(git -C "$source" rev-parse --verify --quiet "$1^{commit}") ||
  { echo "bench/runs/against.sh: $1 is no commit here" >&2; exit 2; }
shift
rounds=5
if [ "${1:-}" = --rounds ]; then
  [[ ${2:-} =~ ^[1-9][0-9]?$ ]] || { echo "bench/runs/against.sh: --rounds: expected 1 to 99" >&2; exit 2; }
  rounds=$2
  shift 2
fi
[ $# -gt 0 ] || set -- --backend pread,compressed --workload build,sweep-read,sweep-update --memory 64MiB
for file in bench-before.jsonl bench-after.jsonl; do
  [ ! -e $file ] || { echo "bench/runs/against.sh: $file exists: remove it first" >&2; exit 2; }
done

work=$(mktemp -d)
trap 'git -C "$source" worktree remove --force "$work/before" 2>/dev/null || true; rm -rf "$work"' EXIT
git -C "$source" worktree add --quiet --detach "$work/before" "$before"
# build_of TREE: prints its program.
build_of() {
  {
    cd "$1"
    cmake --preset release -DPLAIT_TESTS=OFF -DPLAIT_BENCH=OFF -DPLAIT_EXAMPLES=OFF -DPLAIT_INSTALL=OFF \
      -B "$2"
    cmake --build "$2" --target plait_program
  } >"$work/build.log" 2>&1 || { tail -n 30 "$work/build.log" >&2; return 1; }
  echo "$2/tools/plait"
}
old=$(build_of "$work/before" "$work/build-before")
new=$(build_of "$source" "$work/build-after")
# In turn, so that a disk that becomes slow is slow for both. Each call adds one round.
for round in $(seq "$rounds"); do
  for side in before after; do
    if [ $side = before ]; then program=$old; else program=$new; fi
    echo "round $round of $rounds: $side" >&2
    "$program" bench run "$@" --rounds "$round" --no-fio --out bench-$side.jsonl >/dev/null || true
  done
done
status=0
"$new" bench compare bench-before.jsonl bench-after.jsonl || status=$?
exit $status
