#!/usr/bin/env bash
# bench/instrument/disktypes.sh: bad usage is refused, nothing is left after any end, a kind that is refused does not
# stop the others. What needs root and loop devices is left out where they are missing.
#
#   disktypes_test.sh DISKTYPES
set -euo pipefail
disktypes=$1
here=$(mktemp -d)
# What runs write down about themselves; that of other runs is not this test's.
export PLAIT_DISKTYPES_STATE="$here.state"
trap 'rm -rf "$here" "$here.state" "$here.said" "$here.ready"' EXIT
fail() { printf '%s\n' "$*" >&2; exit 1; }

# expect STATUS TEXT ARGUMENTS...: TEXT is in what the script prints.
expect() {
  local status=$1 text=$2 found=0
  shift 2
  output=$("${as[@]}" "$disktypes" "$@" 2>&1) || found=$?
  if [ "$found" != "$status" ] || [[ $output != *"$text"* ]]; then
    fail "$*: expected status $status and '$text', found status $found and: $output"
  fi
}
as=(env)
quick=(--size 512M)

expect 2 'expected run or clean'
expect 2 "found 'walk'" walk
expect 2 'run needs a command after --' run --kinds tmpfs
expect 2 "found 'ntfs'" run --kinds ntfs -- true
expect 2 "found 'tmpfs@200'" run --kinds tmpfs@200 -- true
expect 2 "found 'ext4@0'" run --kinds ext4@0 -- true
expect 2 "found 'x;reboot'" run --kinds 'x;reboot' -- true
expect 2 "found '4Q'" run --size 4Q -- true
expect 2 'at least 512M' run --size 1M -- true
expect 2 'no such directory' run --images "$here/no" -- true
expect 2 "unknown option '--kind'" run --kind tmpfs -- true
expect 2 'needs a value' run --kinds
expect 0 'Examples:' --help
[ -z "$(ls "$here")" ] || fail "refused usage left files: $(ls "$here")"

nothing_left() {
  [ -z "$(ls "$here")" ] || fail "$1 left files: $(ls "$here")"
  ! losetup -a 2>/dev/null | grep -q "$here" || fail "$1 left a loop device"
  ! grep -q "$here" /proc/mounts || fail "$1 left a mount"
  compgen -G '/dev/shm/plait-disktypes.*' >/dev/null && fail "$1 left a directory in /dev/shm"
  return 0
}

# Without root: loop devices are refused in words, tmpfs is used, and the command's status is passed on.
if [ "$(id -u)" -eq 0 ]; then
  as=(setpriv --reuid=65534 --regid=65534 --clear-groups)
  chmod 777 "$here"
fi
if "${as[@]}" test -x "$disktypes" 2>/dev/null && [ "$(stat -f -c %T /dev/shm)" = tmpfs ]; then
  expect 7 'ext4@200: refused: it needs root' run "${quick[@]}" --images "$here" --kinds ext4@200,tmpfs -- \
    sh -c 'test $# = 2 && test -d "$1" && test "$2" = "--dir=tmpfs=$1" && exit 7' x {} --dir={kind}={}
  [[ $output == *'tmpfs: floor write '*' MB/s'* ]] || fail "no floor was measured: $output"
  expect 1 'no disk could be made' run "${quick[@]}" --images "$here" --kinds ext4,xfs -- true
  nothing_left 'a run without root'
else
  echo 'skipped: no other user can run the script here, or there is no /dev/shm'
fi
as=(env)

if [ "$(id -u)" -ne 0 ] || ! unshare --mount true 2>/dev/null || ! losetup --find >/dev/null 2>&1; then
  echo 'skipped: making loop devices needs root'
  exit 0
fi
if ! "$disktypes" run "${quick[@]}" --images "$here" --kinds ext4 -- true 2>"$here.said"; then
  cat "$here.said"
  echo 'skipped: this machine refuses a loop device with direct I/O'
  exit 0
fi
nothing_left 'a run'
expect 9 'ext4: floor' run "${quick[@]}" --images "$here" --kinds ext4,tmpfs -- \
  sh -c 'grep -q "$1 ext4" /proc/mounts && grep -q "$2 tmpfs" /proc/mounts && exit 9' x {}
nothing_left 'a run whose command failed'

# The command writes into its disk when the signal comes.
for signal in TERM INT KILL; do
  rm -f "$here.ready"
  # Bash ignores SIGINT in what it starts in the background.
  env --default-signal=INT "$disktypes" run "${quick[@]}" --images "$here" --kinds ext4 -- sh -c \
    'echo $$ >"$2"; while :; do echo more >>"$1/file"; sleep 0.01; done' x {} "$here.ready" 2>/dev/null &
  running=$!
  for _ in $(seq 600); do [ ! -s "$here.ready" ] || break; sleep 0.05; done
  [ -s "$here.ready" ] || fail "the command did not start before SIG$signal"
  kill -"$signal" "$running"
  status=0
  wait "$running" 2>/dev/null || status=$?
  [ "$status" -eq $((128 + $(kill -l "$signal"))) ] || fail "SIG$signal: found status $status"
  [ "$signal" != KILL ] || kill "$(cat "$here.ready")"
  for _ in $(seq 100); do kill -0 "$(cat "$here.ready")" 2>/dev/null || break; sleep 0.05; done
  rm -f "$here.ready"
  if [ "$signal" = KILL ]; then
    for _ in $(seq 100); do losetup -a | grep -q "$here" || break; sleep 0.05; done
    "$disktypes" clean 2>/dev/null
  fi
  nothing_left "SIG$signal"
done
