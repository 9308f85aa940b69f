#!/usr/bin/env bash
# Two mounts of one directory that do not see each other's locks (FUSE), as two nodes of a cluster have it: a
# join, a part and a join of a pass are stopped in the middle, the same command runs through the other mount, and
# the first one goes on. Skipped without bindfs and FUSE.
#
#   two_mounts_test.sh PLAIT
set -euo pipefail
plait=$1
skip() { echo "two_mounts_test: skipped: $*"; exit 77; }
command -v bindfs >/dev/null || skip 'no bindfs'
here=$(mktemp -d)
cd "$here"
mkdir shared a b
finish() {
  for node in a b; do umount "$here/$node" 2>/dev/null || fusermount3 -u "$here/$node" 2>/dev/null || true; done
  rm -rf "$here"
}
trap finish EXIT
for node in a b; do bindfs shared "$node" 2>/dev/null || skip 'FUSE may not be used here'; done
fail() { echo "two_mounts_test: $*" >&2; cat b.log a.log >&2; exit 1; }

# stopped PATTERN COMMAND...: starts the command, and stops it as soon as shared/PATTERN is there. Fails if the
# command was faster.
stopped() {
  local pattern=$1
  shift
  "$@" >b.log 2>&1 &
  first=$!
  until compgen -G "shared/$pattern" >/dev/null || ! kill -0 $first 2>/dev/null; do :; done
  kill -STOP $first 2>/dev/null && compgen -G "shared/$pattern" >/dev/null && return
  wait $first || true
  return 1
}
# go_on COMMAND...: runs to its end while the command of stopped() stands still. Sets both statuses.
go_on() {
  of_a=0 of_b=0
  "$@" >a.log 2>&1 || of_a=$?
  kill -CONT $first
  wait $first || of_b=$?
}

"$plait" generate torus m.ply --vertices 2000 >/dev/null
"$plait" plan m.ply shared/p --levels 2 --normals --parts 60 >/dev/null
for part in $(seq 2 59); do "$plait" part shared/p "$part" --threads 1 >/dev/null; done

stopped 'p/part.0-*' "$plait" part b/p 0 || fail 'the part was too fast'
go_on "$plait" part a/p 0
[ "$of_a $of_b" = '0 0' ] || fail "expected that both parts end with 0, found $of_a and $of_b"
"$plait" part a/p 1 >/dev/null

for attempt in 1 2 3 4 5; do
  stopped 't.plait.partial-*' "$plait" join b/p b/t.plait && break
  [ "$attempt" -lt 5 ] || fail 'the join was too fast'
  rm -r shared/t.plait
done
go_on "$plait" join a/p a/t.plait
[ "$of_a $of_b" = '0 0' ] || fail "expected that both joins end with 0, found $of_a and $of_b"
grep -q 'was joined before' b.log || fail 'expected that the later join says so'
"$plait" verify shared/t.plait >verify.log || fail "$(tail -n 1 verify.log)"
[ "$(tail -n 1 a.log)" = "$("$plait" digest shared/t.plait)" ] || fail 'expected the digest of the join'
! compgen -G 'shared/t.plait.*' >/dev/null || fail 'expected nothing beside the store'

# A pass: both joins make the same version of the same files.
"$plait" plan --pass smooth shared/t.plait shared/q >/dev/null
for part in $(seq 0 59); do "$plait" part shared/q "$part" --threads 1 >/dev/null; done
stopped 't.plait/version.2.shard0' "$plait" join b/q b/t.plait || fail 'the join of the pass was too fast'
go_on "$plait" join a/q a/t.plait
[ "$of_a" = 0 ] || fail "expected that the join of the pass ends with 0, found $of_a"
"$plait" verify shared/t.plait >verify.log || fail "$(tail -n 1 verify.log)"
