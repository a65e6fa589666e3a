#!/usr/bin/env bash
# A Slurm of its own on this machine, to try the cluster profile on: a controller and two nodes of
# one slot each, everything under one folder, on ports of its own. Needs root and the packages of
# the distribution (Debian, Ubuntu: apt install slurmctld slurmd slurm-client munge).
#
#   .ci/throwaway_slurm.sh start DIR    start it; then: export SLURM_CONF=DIR/slurm.conf
#   .ci/throwaway_slurm.sh stop DIR     end it, with all its jobs
#
# DIR must be short: it holds a socket, whose path may have 107 characters.
set -euo pipefail

usage() { sed -n '2,9s/^# \{0,1\}//p' "$0" >&2; exit 2; }
[ $# -eq 2 ] || usage
action=$1
mkdir -p "$2"
dir=$(cd "$2" && pwd)
export SLURM_CONF=$dir/slurm.conf
PATH=$PATH:/usr/sbin:/sbin
BASE_PORT=${RIG2SEA_SLURM_PORT:-18817}

need() {
    for tool in munged mungekey slurmctld slurmd sinfo; do
        command -v "$tool" >/dev/null || { echo "$tool is missing: apt install slurmctld slurmd slurm-client munge" >&2; exit 1; }
    done
    [ "$(id -u)" -eq 0 ] || { echo "needs root: slurmd starts jobs as their users" >&2; exit 1; }
}

start() {
    need
    local host memory_mb
    host=$(hostname -s)
    memory_mb=$(slurmd -C | grep -oE 'RealMemory=[0-9]+' | cut -d= -f2)
    mkdir -p "$dir/bin" "$dir/munge" "$dir/state" "$dir/log"
    chmod 0755 "$dir/munge"
    [ -f "$dir/munge/key" ] || mungekey --create --keyfile="$dir/munge/key"
    cat >"$SLURM_CONF" <<CONF
ClusterName=throwaway
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$BASE_PORT
SlurmUser=root
AuthType=auth/munge
CredType=cred/munge
AuthInfo=socket=$dir/munge/socket
StateSaveLocation=$dir/state
SlurmdSpoolDir=$dir/spool.%n
SlurmctldPidFile=$dir/slurmctld.pid
SlurmdPidFile=$dir/slurmd.%n.pid
SlurmctldLogFile=$dir/log/slurmctld.log
SlurmdLogFile=$dir/log/slurmd.%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
TaskProlog=$dir/task_prolog
SwitchType=switch/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_interval=1,bf_interval=1
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
MinJobAge=300
ReturnToService=2
SlurmdTimeout=60
NodeName=node[1-2] NodeHostname=$host NodeAddr=127.0.0.1 Port=$((BASE_PORT + 1))-$((BASE_PORT + 2)) CPUs=1 RealMemory=$memory_mb State=UNKNOWN
PartitionName=main Nodes=node[1-2] Default=YES MaxTime=60 State=UP
CONF
    # The engine takes SLURM_CONF out of the environment of its job steps, where srun needs it:
    # a cluster keeps this file in /etc, where nothing is to be written for a try.
    printf '#!/bin/sh\nSLURM_CONF=%s exec %s "$@"\n' "$SLURM_CONF" "$(command -v srun)" >"$dir/bin/srun"
    printf '#!/bin/sh\necho "export PATH=%s/bin:$PATH"\n' "$dir" >"$dir/task_prolog"
    chmod 0755 "$dir/bin/srun" "$dir/task_prolog"
    munged --force --key-file="$dir/munge/key" --socket="$dir/munge/socket" \
        --pid-file="$dir/munge/pid" --log-file="$dir/munge/log" --seed-file="$dir/munge/seed" 2>>"$dir/log/munged.log"
    slurmctld -c
    slurmd -N node1
    slurmd -N node2
    for _ in $(seq 60); do
        [ "$(sinfo --noheader --format=%T --Node 2>/dev/null | grep -c '^idle$')" -eq 2 ] && return 0
        sleep 0.5
    done
    echo "the nodes did not come up; the logs are in $dir/log" >&2
    sinfo >&2 || true
    exit 1
}

stop() {
    if [ -f "$SLURM_CONF" ]; then
        scancel --user=root 2>/dev/null || true
        for _ in $(seq 40); do  # the nodes end what they run, while they still can
            [ -n "$(timeout 5 squeue --noheader 2>/dev/null)" ] || break
            sleep 0.5
        done
    fi
    for pid_file in "$dir"/slurmd.*.pid "$dir/slurmctld.pid" "$dir/munge/pid"; do
        [ -f "$pid_file" ] || continue
        pid=$(cat "$pid_file")
        kill "$pid" 2>/dev/null || continue
        for _ in $(seq 50); do kill -0 "$pid" 2>/dev/null || break; sleep 0.1; done
        kill -9 "$pid" 2>/dev/null || true
    done
}

case $action in
    start) start ;;
    stop) stop ;;
    *) usage ;;
esac
