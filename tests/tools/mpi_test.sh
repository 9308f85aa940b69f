#!/usr/bin/env bash
# plait-mpi under an MPI: any number of ranks gives the store of one process, a part that fails stops no
# other, and the same command again makes what is missing. Skipped if PLAIT_MPI is "none", or if
# MPI cannot start ranks here.
#
#   mpi_test.sh PLAIT PLAIT_MPI MPIEXEC RANKS
set -euo pipefail
plait=$1 plait_mpi=$2 mpiexec=$3 ranks=$4
skip() { echo "mpi_test: skipped: $*"; exit 77; }
[ "$plait_mpi" != none ] || skip 'this build found no such MPI'
here=$(mktemp -d)
trap 'rm -rf "$here"' EXIT
cd "$here"
fail() {
  echo "mpi_test: $*" >&2
  cat printed errors >&2 || true
  exit 1
}

# In a container tests are root, and the machine may have fewer cores than ranks.
start=("$mpiexec")
if "$mpiexec" --version 2>&1 | grep -qi 'open *mpi\|openrte'; then
  start+=(--allow-run-as-root --oversubscribe)
  export OMPI_MCA_plm_rsh_agent=/bin/false OMPI_MCA_btl_base_warn_component_unused=0
fi
"${start[@]}" -n 2 true >printed 2>errors || skip "$mpiexec cannot start two ranks: $(head -n 3 errors)"

# expect STATUS COMMAND...: what it prints is in the files printed and errors.
expect() {
  local status=$1 found=0
  shift
  "$@" >printed 2>errors </dev/null || found=$?
  [ "$found" = "$status" ] || fail "$*: expected status $status, found $found"
}
expect_last_line() { [ "$(tail -n 1 printed)" = "$1" ] || fail "expected the last line '$1'"; }
parts_done() { find "$1" -name 'done.*' -type f | wc -l; }

"$plait" generate torus m.ply --vertices 500 >/dev/null
"$plait" subdivide m.ply whole.plait --levels 4 --normals >/dev/null
digest=$("$plait" digest whole.plait)
new_plan() { "$plait" plan m.ply "$1" --levels 4 --normals --parts "$2" >/dev/null; }

# One rank does everything.
new_plan one 5
expect 0 "${start[@]}" -n 1 "$plait_mpi" one one.plait
expect_last_line "$digest"

# A part fails on whatever rank has it: where its file done.I goes is a directory.
new_plan many 21
mkdir many/done.3
expect 4 "${start[@]}" -n "$ranks" "$plait_mpi" many many.plait
expect_last_line 3
grep -q 'rank [0-9]* on .*: part 3: ' errors || fail 'expected an error that names the rank and the part'
[ "$(parts_done many)" = 20 ] || fail "expected 20 parts, found $(parts_done many)"
[ ! -e many.plait ] || fail 'expected no store'
rmdir many/done.3
expect 0 "${start[@]}" -n "$ranks" "$plait_mpi" many
grep -q "1 of 21 parts by $ranks ranks, 20 were done before" printed || fail 'expected one new part'
expect 0 "${start[@]}" -n "$ranks" "$plait_mpi" many many.plait --json
grep -q "\"digest\": \"$digest\"" printed || fail "expected digest $digest"
expect 0 "${start[@]}" -n 2 "$plait_mpi" many many.plait --json
grep -q '"was_joined": true' printed || fail 'expected a store that was joined before'
expect 2 "${start[@]}" -n 2 "$plait_mpi" many whole.plait
grep -q 'whole.plait: it exists already' errors || fail 'expected that another store is refused'

# A pass: its parts change the store of the plan, whose name is refused for another one.
"$plait" pass whole.plait smooth smooth.plait >/dev/null
"$plait" plan --pass smooth many.plait smooth.plan >/dev/null
expect 2 "${start[@]}" -n 2 "$plait_mpi" smooth.plan one.plait
expect 0 "${start[@]}" -n "$ranks" "$plait_mpi" smooth.plan many.plait
expect 0 "${start[@]}" -n "$ranks" "$plait_mpi" smooth.plan many.plait
"$plait" plan --pass normals many.plait normals.plan >/dev/null
expect 0 "${start[@]}" -n "$ranks" "$plait_mpi" normals.plan many.plait
[ "$("$plait" digest many.plait)" = "$("$plait" digest smooth.plait)" ] || fail 'expected the store of plait pass'

# A rank on a machine that is full: its parts go to another rank, and it takes no more than three. It
# is rank 0, which always has the first part: of so few parts another rank may come too late for any.
new_plan full 12
cat >full_rank.sh <<'END'
trap '' XFSZ
ulimit -f 8
exec "$@"
END
expect 0 "${start[@]}" -n 1 sh full_rank.sh "$plait_mpi" full : -n 1 "$plait_mpi" full
failed=$(grep -c 'rank 0 on .*: part ' errors) || true
[ "$failed" -ge 1 ] && [ "$failed" -le 3 ] || fail "expected one to three errors of rank 0, found $failed"
grep -q '12 of 12 parts by 2 ranks' printed || fail 'expected all parts by the other rank'
expect 0 "$plait" join full full.plait
expect_last_line "$digest"

# A rank whose parts fail again and again takes no more.
new_plan failing 7
mkdir failing/done.{0,1,2}
expect 4 "${start[@]}" -n 1 "$plait_mpi" failing
expect_last_line 0-6

# A job that is killed in the middle goes on where it was.
new_plan killed 40
"${start[@]}" -n "$ranks" "$plait_mpi" killed >printed 2>errors &
job=$!
for ((turn = 0; turn < 6000; ++turn)); do
  [ "$(parts_done killed)" = 0 ] && kill -0 "$job" 2>/dev/null || break
  sleep 0.01
done
kill -KILL "$job" 2>/dev/null || true
wait "$job" 2>/dev/null || true
[ "$(parts_done killed)" -gt 0 ] || fail 'expected a part before the job was killed'
expect 0 "${start[@]}" -n "$ranks" "$plait_mpi" killed killed.plait
expect_last_line "$digest"

expect 2 "${start[@]}" -n 2 "$plait_mpi" nothing
grep -q 'open nothing' errors || fail 'expected that the plan is not there'
expect 2 "${start[@]}" -n 2 "$plait_mpi" many --threads none
expect 0 "$plait_mpi" --help
grep -q Examples: printed || fail 'expected examples'
