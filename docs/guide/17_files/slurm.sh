#!/bin/bash
# Lesson 17 as one job of Slurm: sbatch docs/guide/17_files/slurm.sh, in the kit's folder, which every machine must have
# at the same place, such as your home directory. The keys are made once, before the first job:
#     python python/15_security/keys.py make server
#     python python/15_security/keys.py make client
#     python python/15_security/keys.py enrol fleet=keys/client.key
#SBATCH --job-name=fleet
# One task is for the hub and the trainer, which run where this script runs; the others are simulators, anywhere.
#SBATCH --ntasks=33
#SBATCH --cpus-per-task=1
#SBATCH --time=01:00:00
#SBATCH --output=fleet-%j.log
set -euo pipefail

PYTHON=${PYTHON:-.venv/bin/python}
KEYS=${KEYS:-keys}
# A port of its own for each job: two of them may have the same first machine.
PORT=${PORT:-$((20000 + SLURM_JOB_ID % 10000))}
LESSON=python/17_many_machines
SIMULATORS=$((SLURM_NTASKS - 1))

# Whatever happens, nothing is left behind.
trap 'kill $(jobs -p) 2>/dev/null || true' EXIT

# A simulator that comes early waits for the last one. Each has an episode of the trainer: one that dies is started again.
"$PYTHON" $LESSON/server.py --endpoint "tcp://0.0.0.0:$PORT" --keys "$KEYS" --idle 600 --timeout 300 &
srun --ntasks="$SIMULATORS" bash -c 'until "$@"; do sleep 1; done' simulator \
    "$PYTHON" $LESSON/client.py --endpoint "tcp://$(hostname):$PORT" --keys "$KEYS" --timeout 300 &

# The job ends with its trainer.
"$PYTHON" $LESSON/train.py --endpoint "tcp://127.0.0.1:$PORT" --keys "$KEYS" \
    --areas "$SIMULATORS" --episodes "${EPISODES:-1000}" --timeout 330
