#!/usr/bin/env bash
# Tries sweep.sbatch on a Slurm of one node, which this script starts and stops, and compares the merged parts with a single
# run, byte for byte. Needs root and Debian's packages `slurm-wlm` and `munge`.
#
#     docs/slurm/try.sh target/release/qrm
set -euo pipefail
export QRM=$(realpath "${1:-target/release/qrm}")
here=$(realpath "$(dirname "$0")")
work=$(mktemp -d)
node=$(hostname -s)
cleanup() {
    for daemon in slurmd slurmctld; do
        [ -f "$work/$daemon.pid" ] && kill "$(cat "$work/$daemon.pid")" 2>/dev/null || true
    done
    [ -n "${munged:-}" ] && kill "$munged" 2>/dev/null || true
    # The daemons write their state before they end.
    for _ in $(seq 20); do
        rm -rf "$work" 2>/dev/null && return
        sleep 0.5
    done
    echo "left behind: $work" >&2
}
trap cleanup EXIT

mkdir -p "$work/state" "$work/spool" "$work/munge"
chmod 755 "$work"
export SLURM_CONF=$work/slurm.conf
cat > "$SLURM_CONF" <<EOF
ClusterName=one
SlurmctldHost=$node(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$work/munge/socket
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmctldPort=16817
SlurmdPort=16818
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
ReturnToService=2
MpiDefault=none
NodeName=$node NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=all Nodes=$node Default=YES State=UP
EOF

# A key of our own, so that a munge that runs here already is left alone.
dd if=/dev/urandom of="$work/munge/key" bs=128 count=1 status=none
chmod 600 "$work/munge/key"
chmod 755 "$work/munge"
munged --force --foreground --socket="$work/munge/socket" --key-file="$work/munge/key" \
    --log-file="$work/munge/log" --pid-file="$work/munge/pid" --seed-file="$work/munge/seed" >"$work/munge/out" 2>&1 &
munged=$!
for _ in $(seq 50); do [ -S "$work/munge/socket" ] && break; sleep 0.1; done

slurmctld -f "$SLURM_CONF" -L "$work/slurmctld.log"
slurmd -f "$SLURM_CONF" -L "$work/slurmd.log" -N "$node"
for _ in $(seq 100); do
    sinfo --noheader --format=%T 2>/dev/null | grep -q idle && break
    sleep 0.2
done
sinfo || { cat "$work"/*.log; exit 1; }

cd "$work"
timeout 120 sbatch --wait --output="$work/task-%a.log" "$here/sweep.sbatch" || { cat "$work"/*.log; exit 1; }
cat "$work"/task-*.log
"$QRM" merge merged.csv part-{1..4}.csv
"$QRM" sweep quick-return --vary O2A=0.15:0.25:200 --vary J2=50,100,200 --out single.csv >/dev/null
cmp merged.csv single.csv
echo "the merged parts are the single run, byte for byte"
