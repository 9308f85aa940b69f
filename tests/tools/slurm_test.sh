#!/usr/bin/env bash
# The script of plait plan --sbatch under a Slurm of one node: an array of 8 parts, of which one is killed and
# requeued while it runs. Skipped unless PLAIT_LONG=1 and this is root, because it starts Slurm's daemons, on the
# loopback address, for a minute.
#
#   slurm_test.sh PLAIT
set -euo pipefail
plait=$1
skip() { echo "slurm_test: skipped: $*"; exit 77; }
[ "${PLAIT_LONG:-}" = 1 ] || skip 'PLAIT_LONG=1 runs it'
[ "$(id -u)" = 0 ] || skip 'not root'
for program in munged slurmctld slurmd sbatch; do
  [ -n "$(PATH=$PATH:/usr/sbin type -P $program)" ] || skip "no $program"
done
here=$(mktemp -d)
daemons=()
finish() {
  [ ${#daemons[@]} = 0 ] || { kill "${daemons[@]}" && wait "${daemons[@]}"; } 2>/dev/null || true
  rm -rf "$here"
}
trap finish EXIT
cd "$here"
chmod 755 . && mkdir munge spool state work bin && chmod 711 munge
fail() {
  echo "slurm_test: $*" >&2
  squeue --array >&2 || true
  tail -n 20 ./*.log work/slurm-*.out >&2 || true
  exit 1
}
# wait_for SECONDS COMMAND...: until it succeeds.
wait_for() {
  local turns=$((10 * $1))
  shift
  while ! "$@" 2>/dev/null; do
    [ $((turns--)) -gt 0 ] || fail "waited in vain for: $*"
    sleep 0.1
  done
}

host=$(hostname -s)
cat >slurm.conf <<END
ClusterName=one
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$here/munge/socket
ProctrackType=proctrack/pgid
TaskPlugin=task/none
StateSaveLocation=$here/state
SlurmdSpoolDir=$here/spool
SlurmctldPidFile=$here/slurmctld.pid
SlurmdPidFile=$here/slurmd.pid
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
MpiDefault=none
KillWait=2
NodeName=$host NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
END
export SLURM_CONF=$here/slurm.conf
(umask 077 && head -c 1024 /dev/urandom >munge/key)
PATH=$PATH:/usr/sbin
munged --foreground --force --key-file="$here/munge/key" --socket="$here/munge/socket" \
  --pid-file="$here/munge/pid" --seed-file="$here/munge/seed" --log-file="$here/munge.log" 2>munged.log &
daemons+=($!)
wait_for 60 test -S munge/socket
slurmctld -D 2>slurmctld.log & daemons+=($!)
slurmd -D 2>slurmd.log & daemons+=($!)
is_idle() { sinfo --noheader | grep -q idle; }
wait_for 120 is_idle

# The first run of part 3 stops in the middle, and stays so until Slurm kills it.
cat >bin/plait <<END
#!/bin/sh
if [ "\$3" = 3 ] && mkdir "$here/stopped" 2>/dev/null; then
  "$plait" "\$@" &
  until [ -n "\$(find "$here/work/p" -name 'part.3*')" ] || ! kill -0 \$!; do :; done
  kill -STOP \$!
  : >"$here/stopped/it"
  wait
fi
exec "$plait" "\$@"
END
chmod +x bin/plait
export PATH=$here/bin:$PATH
cd work
"$plait" generate torus m.ply --vertices 100000 >/dev/null
"$plait" plan m.ply p --levels 5 --normals --parts 8 --sbatch p.sh >/dev/null
job=$(sbatch --parsable p.sh --threads 1)
wait_for 60 test -e ../stopped/it
scontrol requeue "${job}_3"
is_done() {
  scontrol update "jobid=${job}_3" StartTime=now || true  # Slurm would wait for two minutes
  [ "$(find p -name 'done.*' | wc -l)" = 8 ]
}
wait_for 120 is_done
scontrol show job "${job}_3" | grep -q 'Restarts=1' || fail 'expected one restart'
"$plait" join p s.plait --verify >joined || fail 'join'
"$plait" subdivide m.ply whole.plait --levels 5 --normals >/dev/null
[ "$(tail -n 1 joined)" = "$("$plait" digest whole.plait)" ] || fail 'expected the digest of one process'
