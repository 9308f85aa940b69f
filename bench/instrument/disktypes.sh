#!/usr/bin/env bash
# Runs a command with directories on several types of disk, made for the run and removed after it.
#
#   bench/instrument/disktypes.sh run [OPTION...] -- COMMAND [ARGUMENT...]
#   bench/instrument/disktypes.sh clean                 removes what killed runs left, if anything is left
#
#   --kinds LIST    kinds, with commas: ext4, xfs, btrfs (on a loop device with direct I/O), with @RATE in
#                   MB/s if the device shall be throttled; tmpfs.
#                   Default: ext4@200,ext4@300,ext4@1000,xfs@300,btrfs@300,tmpfs
#   --size SIZE     of each disk, with K, M, G or T; at least 512M; default 4G
#   --images DIR    where the files behind the loop devices are made; default /var/tmp
#
# Arguments: an argument that is {} becomes all directories, one argument each. An argument that contains
# {}, such as --dir={}, is repeated for each directory; {kind} in it is the kind of the disk.
#
# Every disk is proved before use: 1 MiB blocks are written and read past the page cache, for about two
# seconds each. A throttled disk must have 0.85 to 1.1 of its rate, or it is not used. A kind that this
# machine refuses is reported with the reason, and the run goes on with the rest. Without root only tmpfs
# is left.
#
# Mounts are in a mount namespace of the run, loop devices detach themselves, and their files have no name,
# so nothing of them outlives the run, even if it is killed. Limits and cgroups are removed at the end, also
# after a signal; after a SIGKILL, by the next run or by `clean`.
#
# Exit status: that of the command; 1 if no disk could be made; 2 for bad usage; 128 + N after signal N.
#
# Examples:
#   sudo bench/instrument/disktypes.sh run -- plait bench run --dir={kind}={} --out runs.jsonl
#   sudo bench/instrument/disktypes.sh run --kinds ext4@200,tmpfs --size 8G -- df -h {}
set -euo pipefail

readonly state_root=${PLAIT_DISKTYPES_STATE:-/run/plait-disktypes}
kinds=ext4@200,ext4@300,ext4@1000,xfs@300,btrfs@300,tmpfs
size=4G images=/var/tmp
state='' work='' child='' signal=0 blkio='' group=''
made_kinds=() made_directories=()

say() { echo "disktypes: $*" >&2; }
refuse_usage() {
  echo "bench/instrument/disktypes.sh: $* (see bench/instrument/disktypes.sh --help)" >&2
  exit 2
}

parse() {
  while [ $# -gt 0 ] && [ "$1" != -- ]; do
    case $1 in
      --kinds | --size | --images)
        [ $# -gt 1 ] || refuse_usage "$1 needs a value"
        printf -v "${1#--}" %s "$2" ;;
      *) refuse_usage "unknown option '$1'" ;;
    esac
    shift 2
  done
  command=("${@:2}")
  local kind
  IFS=, read -ra kinds <<<"$kinds"
  [ "${#kinds[@]}" -gt 0 ] || refuse_usage "--kinds names no kind"
  for kind in "${kinds[@]}"; do
    [[ $kind =~ ^((ext4|xfs|btrfs)(@[1-9][0-9]{0,4})?|tmpfs)$ ]] ||
      refuse_usage "--kinds: expected ext4, xfs or btrfs, with or without @RATE, or tmpfs, found '$kind'"
  done
  [[ $size =~ ^[1-9][0-9]{0,5}[KMGT]$ ]] ||
    refuse_usage "--size: expected a number with K, M, G or T, found '$size'"
  size=$(numfmt --from=iec "$size")
  [ "$size" -ge $((512 << 20)) ] || refuse_usage "--size: expected at least 512M, found $size bytes"
  [ -d "$images" ] || refuse_usage "--images $images: no such directory"
  [ "${#command[@]}" -gt 0 ] || refuse_usage "run needs a command after --"
}

# What a killed run may leave is written down before it is made: one line each in STATE/PID.
note() { echo "$*" >>"$state"; }

# undo FILE: removes what the lines of a state file name, the last first.
undo() {
  local line process
  while read -ra line; do
    case ${line[0]:-} in
      limit) echo "${line[2]} 0" >"${line[1]}" || true ;;
      group)
        while read -r process; do echo "$process" >"${line[1]%/*}/cgroup.procs" || true; done <"${line[1]}/cgroup.procs"
        rmdir "${line[1]}" || true ;;
      directory) rm -rf --one-file-system -- "${line[1]}" ;;
    esac 2>/dev/null
  done < <(tac -- "$1")
  rm -f -- "$1"
}
undo_dead_runs() {
  local file
  for file in "$state_root"/*; do
    [[ -f $file && ! -L $file && ${file##*/} =~ ^[0-9]+$ ]] || continue
    kill -0 "${file##*/}" 2>/dev/null || { say "removing what process ${file##*/} left"; undo "$file"; }
  done
}

clean_up() {
  local status=$? directory
  trap '' INT TERM HUP
  if [ -n "$child" ]; then
    kill -"${signal/#0/TERM}" -- "-$child" 2>/dev/null || true
    wait "$child" 2>/dev/null || true
  fi
  for directory in ${made_directories[@]+"${made_directories[@]}"}; do
    # A command that was just killed may hold the directory for a moment.
    for _ in 1 2 3 4 5; do umount "$directory" 2>/dev/null && break; sleep 0.2; done
  done
  [ -z "$state" ] || [ ! -e "$state" ] || undo "$state"
  [ "$signal" -eq 0 ] || status=$((128 + signal))
  exit "$status"
}
on_signal() { signal=$1; exit; }

# cgroup v1 charges writeback to the root group, and a limit holds for one group only: so this process has
# to be in the root group, where the limit of a device then holds for all. v2 needs a group of our own.
find_throttle() {
  local v1=/sys/fs/cgroup/blkio v2=/sys/fs/cgroup ours
  if [ -w "$v1/blkio.throttle.write_bps_device" ]; then
    grep -q ':blkio[^:]*:/$' /proc/self/cgroup || echo $$ >"$v1/cgroup.procs" || return 0
    blkio=$v1
  elif [ -f "$v2/cgroup.controllers" ] && grep -qw io "$v2/cgroup.controllers"; then
    echo +io >"$v2/cgroup.subtree_control" 2>/dev/null || return 0
    ours=$v2/plait-disktypes-$$
    note "group $ours"
    { mkdir "$ours" && [ -f "$ours/io.max" ] && echo $$ >"$ours/cgroup.procs"; } 2>/dev/null || return 0
    group=$ours
  fi
}
# throttle DEVICE_NUMBERS RATE: limits a device.
throttle() {
  local numbers=$1 bytes=$(($2 * 1000000)) file
  if [ -n "$blkio" ]; then
    for file in "$blkio"/blkio.throttle.{read,write}_bps_device; do
      note "limit $file $numbers"
      echo "$numbers $bytes" >"$file" || { reason="$file refused a limit"; return 1; }
    done
  elif [ -n "$group" ]; then
    echo "$numbers rbps=$bytes wbps=$bytes" >"$group/io.max" || { reason="$group/io.max refused a limit"; return 1; }
  else
    reason="neither blkio (cgroup v1) nor io (cgroup v2) can be used here"
    return 1
  fi
}

# Functions below that fail leave the reason in `reason`.

# try COMMAND...: what it prints is in $work/answer.
try() {
  "$@" >"$work/answer" 2>"$work/said" && return
  reason="$(tr -d '\r' <"$work/said" | grep -v '^$' | tail -n 1 | cut -c1-200)"
  return 1
}

# make_loop TYPE RATE DIRECTORY
make_loop() {
  local image=$work/image device='' made=0 direct='' numbers='' free all
  read -r free all < <(df --output=avail,size -B1 -- "$images" | tail -n 1)
  if [ $((free - size)) -lt $((all / 10)) ]; then
    reason="$images has $((free >> 20)) MiB free, and $((size >> 20)) MiB more would leave less than a tenth"
    return 1
  fi
  try fallocate -l "$size" -- "$image" && try losetup --find --show --direct-io=on -- "$image" &&
    device=$(<"$work/answer") && try "mkfs.$1" -q "$device" && try mount "$device" "$3" && made=1
  if [ -n "$device" ]; then
    direct=$(cat "/sys/block/${device##*/}/loop/dio" 2>/dev/null || true)
    numbers=$(<"/sys/block/${device##*/}/dev")
    # If it is mounted, the kernel keeps device and file until the last user is gone.
    losetup -d "$device" || true
  fi
  rm -f -- "$image"
  [ "$made" -eq 1 ] || return 1
  if [ "$direct" != 1 ]; then
    reason="$device has no direct I/O here"
  elif [ "$2" -eq 0 ] || throttle "$numbers" "$2"; then
    return 0
  fi
  umount "$3"
  return 1
}
make_tmpfs() {
  ! try mount -t tmpfs -o "size=$size,mode=700" plait-disktypes "$1" || return 0
  # Without root: a directory of the tmpfs that every Linux has.
  [ "$(stat -f -c %T /dev/shm 2>/dev/null)" = tmpfs ] && try mktemp -d /dev/shm/plait-disktypes.XXXXXX || return 1
  local shared; shared=$(<"$work/answer")
  note "directory $shared"
  rmdir "$1" && ln -s "$shared" "$1"
}
# move LANE_MEBIBYTES write|read DIRECTORY: sets `moved` to MB/s past the page cache, of data that do not
# compress. Eight processes, so that the device has work while one of them waits for a processor.
move() {
  local lane start processes=() options failed=0
  start=$(date +%s%N)
  for lane in {0..7}; do
    options=(if="$3/floor" of=/dev/null skip=$((lane * $1)) iflag=direct)
    [ "$2" = read ] || options=(if="$work/random" of="$3/floor" seek=$((lane * $1)) conv=notrunc oflag=direct)
    dd "${options[@]}" bs=1M count="$1" 2>"$work/said$lane" &
    processes+=($!)
  done
  for lane in {0..7}; do
    wait "${processes[$lane]}" || { failed=1; reason="dd to $2: $(head -n 1 "$work/said$lane")"; }
  done
  [ "$failed" -eq 0 ] || return 1
  [ "$2" = read ] || sync "$3/floor"
  moved=$((8 * $1 * 1048576 * 1000 / ($(date +%s%N) - start + 1)))
}
# prove KIND RATE DIRECTORY: measures the floor; a throttled disk must have its rate.
prove() {
  local rate=$2 mebibytes written
  mebibytes=$(((rate > 0 ? rate : 300) / 4)) # two seconds on eight lanes
  [ $mebibytes -le $((size >> 25)) ] || mebibytes=$((size >> 25)) # a quarter of the disk
  [ $mebibytes -le 256 ] || mebibytes=256
  has_rate() { [ $(($1 * 20)) -ge $((rate * 17)) ] && [ $(($1 * 10)) -le $((rate * 11)) ]; }
  for _ in 1 2 3; do
    move $mebibytes write "$3" || return 1
    written=$moved
    move $mebibytes read "$3" || return 1
    rm -f -- "$3/floor"
    say "$1: floor write $written MB/s, read $moved MB/s ($((8 * mebibytes)) MiB, O_DIRECT, 1 MiB blocks)"
    [ "$rate" -gt 0 ] || return 0
    ! has_rate "$written" || ! has_rate "$moved" || return 0
    reason="its floor is $written MB/s to write and $moved to read, not $rate: the disk behind it is too slow or too busy, or the limit does not hold"
  done
  return 1
}

# make KIND: a proved directory, or a line that says why not.
make() {
  local kind=$1 directory=$work/${1/@/-} rate=0
  [[ $kind != *@* ]] || rate=${kind#*@}
  mkdir "$directory"
  if [ "$kind" = tmpfs ]; then
    make_tmpfs "$directory"
  elif [ "$(id -u)" -eq 0 ]; then
    make_loop "${kind%%@*}" "$rate" "$directory"
  else
    reason='it needs root'
    false
  fi || { say "$kind: refused: $reason"; return; }
  if prove "$kind" "$rate" "$directory"; then
    made_kinds+=("$kind") made_directories+=("$directory")
  else
    say "$kind: not used: $reason"
    umount "$directory" 2>/dev/null
  fi
}

run_command() {
  local argument argument_here arguments=() status=0 at
  for argument in "${command[@]}"; do
    [[ $argument == *'{}'* ]] || { arguments+=("$argument"); continue; }
    for at in "${!made_kinds[@]}"; do
      argument_here=${argument//'{kind}'/${made_kinds[$at]}}
      arguments+=("${argument_here//'{}'/${made_directories[$at]}}")
    done
  done
  set -m # a process group of its own, so that one signal reaches it once
  "${arguments[@]}" </dev/null &
  child=$!
  set +m
  wait "$child" || status=$?
  child=
  return "$status"
}

run_all() {
  local kind
  trap clean_up EXIT
  trap 'on_signal 2' INT
  trap 'on_signal 15' TERM
  trap 'on_signal 1' HUP
  if mkdir -p "$state_root" 2>/dev/null && [ -w "$state_root" ]; then
    undo_dead_runs
    state=$state_root/$$
  else
    state=$(mktemp "${TMPDIR:-/tmp}/plait-disktypes-state.XXXXXX")
  fi
  work=$(mktemp -d "${images%/}/plait-disktypes.XXXXXX")
  note "directory $work"
  find_throttle
  head -c "$((size >> 25 < 256 ? size >> 25 : 256))M" /dev/urandom >"$work/random" # a lane of a floor
  for kind in "${kinds[@]}"; do make "$kind" || true; done
  [ "${#made_kinds[@]}" -gt 0 ] || { say "no disk could be made, so ${command[0]} did not run"; exit 1; }
  run_command
}

case ${1:-} in
  -h | --help) sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "$0" ;;
  clean) [ $# -eq 1 ] || refuse_usage "clean takes no argument"; undo_dead_runs ;;
  run)
    parse "${@:2}"
    # A mount namespace, so that mounts end with the run whatever happens.
    if [ "$(id -u)" -eq 0 ] && [ -z "${PLAIT_DISKTYPES_INSIDE:-}" ] && unshare --mount true 2>/dev/null; then
      export PLAIT_DISKTYPES_INSIDE=1
      exec unshare --mount --propagation private -- "${BASH_SOURCE[0]}" "$@"
    fi
    unset PLAIT_DISKTYPES_INSIDE
    run_all ;;
  '') refuse_usage "expected run or clean" ;;
  *) refuse_usage "expected run or clean, found '$1'" ;;
esac
