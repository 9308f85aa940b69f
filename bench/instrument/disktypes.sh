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
#   --floor-seconds N   how long a floor writes, and reads, at the wanted rate; default 2
#
# Arguments: an argument that is {} becomes all directories, one argument each. An argument that contains
# {}, such as --dir={}, is repeated for each directory; {kind} in it is the kind of the disk.
#
# Every disk is proved before use: 1 MiB blocks are written and read past the page cache. A throttled disk
# must have 0.85 to 1.1 of its rate, or it is not used. A kind that this machine refuses is reported with
# the reason, and the run goes on with the rest. Without root only tmpfs is left.
#
# Mounts are in a mount namespace of the run, loop devices detach themselves, and their files have no name,
# so nothing of them outlives the run, even if it is killed. Limits and cgroups are removed at the end, also after a signal; after a SIGKILL, by the next run or by `clean`.
#
# Exit status: that of the command; 1 if no disk could be made; 2 for
# bad usage; 128 + N after signal N.
#
# Examples:
#   sudo bench/instrument/disktypes.sh run -- plait bench run --dir={kind}={} --out runs.jsonl
#   sudo bench/instrument/disktypes.sh run --kinds ext4@200,tmpfs --size 8G -- df -h {}
set -euo pipefail

readonly state_root=${PLAIT_DISKTYPES_STATE:-/run/plait-disktypes}
kinds=ext4@200,ext4@300,ext4@1000,xfs@300,btrfs@300,tmpfs
size_text=4G images=/var/tmp floor_seconds=2
state='' work='' child='' signal=0 blkio='' group=''
made_kinds=() made_directories=()

say() { echo "disktypes: $*" >&2; }
refuse_usage() {
  echo "bench/instrument/disktypes.sh: $* (see bench/instrument/disktypes.sh --help)" >&2
  exit 2
}

# bytes_of TEXT: "4G" as bytes; fails for anything else.
bytes_of() {
  [[ $1 =~ ^([1-9][0-9]{0,5})([KMGT])$ ]] || return 1
  local power
  case ${BASH_REMATCH[2]} in K) power=10 ;; M) power=20 ;; G) power=30 ;; T) power=40 ;; esac
  echo $((BASH_REMATCH[1] << power))
}
type_of() { echo "${1%%@*}"; }
rate_of() { [[ $1 == *@* ]] && echo "${1#*@}" || echo 0; }

check_kinds() {
  local kind list
  IFS=, read -ra list <<<"$kinds"
  [ "${#list[@]}" -gt 0 ] || refuse_usage "--kinds names no kind"
  for kind in "${list[@]}"; do
    [[ $kind =~ ^((ext4|xfs|btrfs)(@[1-9][0-9]{0,4})?|tmpfs)$ ]] ||
      refuse_usage "--kinds: expected ext4, xfs or btrfs, with or without @RATE, or tmpfs, found '$kind'"
  done
}

parse() {
  while [ $# -gt 0 ]; do
    case $1 in
      --kinds | --size | --images | --floor-seconds)
        [ $# -gt 1 ] || refuse_usage "$1 needs a value"
        case $1 in
          --kinds) kinds=$2 ;;
          --size) size_text=$2 ;;
          --images) images=$2 ;;
          --floor-seconds) floor_seconds=$2 ;;
        esac
        shift 2 ;;
      --) shift; break ;;
      *) refuse_usage "unknown option '$1'" ;;
    esac
  done
  command=("$@")
  check_kinds
  size=$(bytes_of "$size_text") || refuse_usage "--size: expected a number with K, M, G or T, found '$size_text'"
  [ "$size" -ge $((512 << 20)) ] || refuse_usage "--size: expected at least 512M, found $size_text"
  [[ $floor_seconds =~ ^[1-9][0-9]?$ ]] || refuse_usage "--floor-seconds: expected 1 to 99, found '$floor_seconds'"
  [ -d "$images" ] || refuse_usage "--images $images: no such directory"
}

# What a killed run may leave is written down before it is made: one line each in STATE/PID.
note() { echo "$*" >>"$state"; }

# undo FILE: removes what the lines of a state file name, the last first.
undo() {
  local line
  while read -ra line; do
    case ${line[0]:-} in
      limit) echo "${line[2]} 0" >"${line[1]}" || true ;;
      group) move_out "${line[1]}"; rmdir "${line[1]}" || true ;;
      directory) rm -rf --one-file-system -- "${line[1]}" ;;
    esac 2>/dev/null
  done < <(tac -- "$1")
  rm -f -- "$1"
}
move_out() {
  local process
  while read -r process; do echo "$process" >"$(dirname "$1")/cgroup.procs" || true; done <"$1/cgroup.procs"
}
undo_dead_runs() {
  local file
  for file in "$state_root"/*; do
    [[ -f $file && ! -L $file && ${file##*/} =~ ^[0-9]+$ ]] || continue
    kill -0 "${file##*/}" 2>/dev/null || { say "removing what process ${file##*/} left"; undo "$file"; }
  done
}

clean_up() {
  local status=$?
  trap '' INT TERM HUP
  if [ -n "$child" ]; then
    kill -"${signal/#0/TERM}" -- "-$child" 2>/dev/null || true
    wait "$child" 2>/dev/null || true
  fi
  local directory
  for directory in ${made_directories[@]+"${made_directories[@]}"}; do
    # A command that was just killed may hold the directory for a moment.
    for _ in 1 2 3 4 5; do umount "$directory" 2>/dev/null && break; sleep 0.2; done
  done
  [ -z "$state" ] || [ ! -e "$state" ] || undo "$state"
  [ "$signal" -eq 0 ] || status=$((128 + signal))
  exit "$status"
}
on_signal() { signal=$1; exit; }

# throttle DEVICE_NUMBERS RATE: limits a device, or fails with the reason in `reason`.
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
# cgroup v1 charges writeback to the root group, and a limit holds for one group only: so this process has
# to be in the root group, where the limit of a device then holds for all. v2 needs a group of our own.
find_throttle() {
  local v1=/sys/fs/cgroup/blkio v2=/sys/fs/cgroup
  if [ -w "$v1/blkio.throttle.write_bps_device" ]; then
    grep -q ':blkio[^:]*:/$' /proc/self/cgroup || echo $$ >"$v1/cgroup.procs" || return 0
    blkio=$v1
  elif [ -f "$v2/cgroup.controllers" ] && grep -qw io "$v2/cgroup.controllers"; then
    echo +io >"$v2/cgroup.subtree_control" 2>/dev/null || return 0
    local ours=$v2/plait-disktypes-$$
    note "group $ours"
    { mkdir "$ours" && [ -f "$ours/io.max" ] && echo $$ >"$ours/cgroup.procs"; } 2>/dev/null || return 0
    group=$ours
  fi
}

# first_line FILE: of what a refused command said.
first_line() { tr -d '\r' <"$1" | grep -v '^$' | tail -n 1 | cut -c1-200; }

# make_loop TYPE RATE DIRECTORY
make_loop() {
  local image=$work/image device numbers free
  free=$(df --output=avail -B1 -- "$images" | tail -n 1)
  local all; all=$(df --output=size -B1 -- "$images" | tail -n 1)
  if [ $((free - size)) -lt $((all / 10)) ]; then
    reason="$images has $((free >> 20)) MiB free, and $((size >> 20)) MiB more would leave less than a tenth"
    return 1
  fi
  command -v "mkfs.$1" >/dev/null || { reason="mkfs.$1 is not installed"; return 1; }
  rm -f -- "$image"
  fallocate -l "$size" -- "$image" 2>"$work/said" || { reason="$(first_line "$work/said")"; rm -f -- "$image"; return 1; }
  device=$(losetup --find --show --direct-io=on -- "$image" 2>"$work/said") ||
    { reason="losetup: $(first_line "$work/said")"; rm -f -- "$image"; return 1; }
  # From here on the kernel keeps device and file until the last user is gone.
  if ! "mkfs.$1" -q "$device" >"$work/said" 2>&1 || ! mount "$device" "$3" 2>"$work/said"; then
    reason="$(first_line "$work/said")"
    losetup -d "$device" || true
    rm -f -- "$image"
    return 1
  fi
  local direct; direct=$(cat "/sys/block/${device##*/}/loop/dio" 2>/dev/null || echo 0)
  numbers=$(cat "/sys/block/${device##*/}/dev")
  losetup -d "$device"
  rm -f -- "$image"
  [ "$direct" = 1 ] || { reason="$device has no direct I/O here"; umount "$3"; return 1; }
  [ "$2" -eq 0 ] || throttle "$numbers" "$2" || { umount "$3"; return 1; }
}
make_tmpfs() {
  if mount -t tmpfs -o "size=$size,mode=700" plait-disktypes "$1" 2>"$work/said"; then return 0; fi
  local shared; shared=$(first_line "$work/said")
  # Without root: a directory of the tmpfs that every Linux has.
  if [ "$(stat -f -c %T /dev/shm 2>/dev/null)" = tmpfs ] && shared=$(mktemp -d /dev/shm/plait-disktypes.XXXXXX); then
    note "directory $shared"
    rmdir "$1" && ln -s "$shared" "$1"
    return 0
  fi
  reason=$shared
  return 1
}
# move LANE_MEBIBYTES write|read DIRECTORY: MB/s past the page cache, of data that do not compress. Eight
# processes, so that the device has work while one of them waits for a processor.
move() {
  local lane from=$work/random to=$3/floor start end failed=0 processes=()
  start=$(date +%s%N)
  for lane in {0..7}; do
    if [ "$2" = write ]; then
      dd if="$from" of="$to" bs=1M count="$1" seek=$((lane * $1)) conv=notrunc oflag=direct 2>"$work/said$lane" &
    else
      dd if="$to" of=/dev/null bs=1M count="$1" skip=$((lane * $1)) iflag=direct 2>"$work/said$lane" &
    fi
    processes+=($!)
  done
  for lane in {0..7}; do
    wait "${processes[$lane]}" || { failed=1; reason="dd to $2: $(first_line "$work/said$lane")"; }
  done
  [ "$failed" -eq 0 ] || return 1
  [ "$2" = read ] || sync "$to"
  end=$(date +%s%N)
  moved=$((8 * $1 * 1048576 * 1000 / (end - start + 1)))
}
# prove KIND DIRECTORY: measures the floor; a throttled disk must have its rate.
prove() {
  local rate mebibytes written
  rate=$(rate_of "$1")
  mebibytes=$(((rate > 0 ? rate : 300) * floor_seconds / 8))
  [ $mebibytes -le $((size >> 25)) ] || mebibytes=$((size >> 25)) # a quarter of the disk
  [ $mebibytes -le 256 ] || mebibytes=256
  for _ in 1 2 3; do
    move $mebibytes write "$2" || return 1
    written=$moved
    move $mebibytes read "$2" || return 1
    rm -f -- "$2/floor"
    say "$1: floor write $written MB/s, read $moved MB/s ($((8 * mebibytes)) MiB, O_DIRECT, 1 MiB blocks)"
    [ "$rate" -gt 0 ] || return 0
    if [ $((written * 20)) -ge $((rate * 17)) ] && [ $((written * 10)) -le $((rate * 11)) ] &&
      [ $((moved * 20)) -ge $((rate * 17)) ] && [ $((moved * 10)) -le $((rate * 11)) ]; then
      return 0
    fi
    reason="its floor is $written MB/s to write and $moved to read, not $rate: the disk behind it is too slow or too busy, or the limit does not hold"
  done
  return 1
}

# make KIND: a proved directory, or a line that says why not.
make() {
  local kind=$1 directory=$work/${1/@/-} type
  type=$(type_of "$kind")
  reason=
  mkdir "$directory"
  if ! case $type in
    tmpfs) make_tmpfs "$directory" ;;
    *) [ "$(id -u)" -eq 0 ] || { reason="it needs root"; false; } && make_loop "$type" "$(rate_of "$kind")" "$directory" ;;
  esac; then
    say "$kind: refused: $reason"
    rmdir "$directory" 2>/dev/null || true
    return 1
  fi
  if ! prove "$kind" "$directory"; then
    say "$kind: not used: $reason"
    umount "$directory" 2>/dev/null || true
    return 1
  fi
  made_kinds+=("$kind") made_directories+=("$directory")
}

run_command() {
  local argument argument_here arguments=() status=0 at
  for argument in "${command[@]}"; do
    if [[ $argument == *'{}'* ]]; then
      for at in "${!made_kinds[@]}"; do
        argument_here=${argument//'{kind}'/${made_kinds[$at]}}
        arguments+=("${argument_here//'{}'/${made_directories[$at]}}")
      done
    else
      arguments+=("$argument")
    fi
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
  local kind list status=0
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
  IFS=, read -ra list <<<"$kinds"
  for kind in "${list[@]}"; do
    make "$kind" || true
  done
  if [ "${#made_kinds[@]}" -eq 0 ]; then
    say "no disk could be made, so ${command[0]} did not run"
    exit 1
  fi
  run_command || status=$?
  exit "$status"
}

case ${1:-} in
  -h | --help) sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "$0" ;;
  clean) [ $# -eq 1 ] || refuse_usage "clean takes no argument"; undo_dead_runs ;;
  run)
    parse "${@:2}"
    [ "${#command[@]}" -gt 0 ] || refuse_usage "run needs a command after --"
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
