#!/usr/bin/env bash
# One task of parallel_sweep.sh or slurm_sweep.sh. A task that was killed goes on where it was.
#
#   scripts/batch_task.sh sweep K N FOLDER SPEC [OPTION...]        shard K of N, into FOLDER/K.csv
#   scripts/batch_task.sh each COMMAND FOLDER SPEC [OPTION...]     analyze or check, into FOLDER/SPEC.json
#
# QERR is the program (default: qerr).
set -euo pipefail

qerr=${QERR:-qerr}
threads=${SLURM_CPUS_PER_TASK:-1}
mode=$1
shift
case $mode in
  sweep)
    shard=$1 shards=$2 folder=$3 spec=$4
    shift 4
    exec "$qerr" sweep --quiet "$spec" --shard "$shard/$shards" --output "$folder/$shard.csv" --resume \
      --threads "$threads" "$@"
    ;;
  each)
    command=$1 folder=$2 spec=$3
    shift 3
    report=$folder/${spec//\//_}.json
    # Reports are renamed to their names when they are complete.
    if [[ $report -nt $spec ]]; then
      exit 0
    fi
    code=0
    "$qerr" "$command" --quiet "$spec" --output "$report" --threads "$threads" "$@" || code=$?
    # 1: done, and a requirement is not met.
    [[ $code -le 1 ]] || exit "$code"
    ;;
esac
