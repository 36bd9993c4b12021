#!/usr/bin/env bash
# A sweep, or many specs, on a cluster with Slurm, as a job array. After an interruption run it again: what is complete
# is kept, and killed tasks go on where they were.
#
#   scripts/slurm_sweep.sh SPEC SHARDS OUT.csv [OPTION...]              options of qerr sweep
#   scripts/slurm_sweep.sh --each COMMAND FOLDER SPEC... [-- OPTION...] qerr analyze or qerr check of each spec
#
# The shards, and the logs of the tasks, are in OUT.csv.shards until they are merged; reports are FOLDER/SPEC.json, with
# the logs in FOLDER/logs. All are in folders that the nodes share. The exit code is 1 if a requirement of `--each check`
# is not met. QERR is the program (default: qerr); sbatch reads its own variables: SBATCH_PARTITION,
# SBATCH_TIMELIMIT, SBATCH_ACCOUNT, ...; SLURM_POLL is the time between looks at the queue [s] (default: 5).
set -euo pipefail

task=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)/batch_task.sh
usage() {
  sed -n '2,/^set/s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2
  exit 2
}
run() {  # number of tasks, folder of logs, arguments of a task, with their shell's variables
  local tasks=$1 logs=$2 job
  shift 2
  mkdir -p "$logs"
  job=$(sbatch --parsable --requeue --job-name=qerr --array="1-$tasks" --output="$logs/%a.log" --wrap="exec $*")
  job=${job%%;*}
  echo "slurm_sweep: job $job, $tasks tasks" >&2
  trap 'scancel "$job"' INT TERM
  while [[ -n $(squeue --noheader --jobs="$job" 2>/dev/null || true) ]]; do sleep "${SLURM_POLL:-5}"; done
  trap - INT TERM
}
command -v sbatch >/dev/null || { echo "slurm_sweep: there is no Slurm on this machine" >&2; exit 2; }

if [[ ${1-} == --each ]]; then
  [[ $# -ge 4 ]] || usage
  command=$2 folder=$3
  shift 3
  specs=()
  while [[ $# -gt 0 && $1 != -- ]]; do
    specs+=("$1")
    shift
  done
  [[ $# -eq 0 ]] || shift
  mkdir -p "$folder"
  printf '%s\n' "${specs[@]}" >"$folder/specs.txt"
  # shellcheck disable=SC2016  # the task's shell expands it
  run "${#specs[@]}" "$folder/logs" "$(printf '%q ' "$task" each "$command" "$folder")" \
    '"$(sed -n "${SLURM_ARRAY_TASK_ID}p"' "$(printf '%q' "$folder/specs.txt"))\"" "$(printf '%q ' "$@")"
  for spec in "${specs[@]}"; do
    if [[ ! $folder/${spec//\//_}.json -nt $spec ]]; then
      echo "slurm_sweep: no report of $spec: see $folder/logs, then run this again" >&2
      exit 3
    fi
  done
  for spec in "${specs[@]}"; do
    if grep -q '^  "met": false' "$folder/${spec//\//_}.json"; then exit 1; fi
  done
  exit 0
fi

[[ $# -ge 3 && $2 =~ ^[1-9][0-9]*$ ]] || usage
spec=$1 shards=$2 out=$3
shift 3
folder=$out.shards
mkdir -p "$folder"
files=()
same=()  # options of which merge knows, too
for option in "$@"; do [[ $option == --allow-long || $option == --check ]] || same+=("$option"); done
for ((k = 1; k <= shards; ++k)); do files+=("$folder/$k.csv"); done
# shellcheck disable=SC2016
run "$shards" "$folder/logs" "$(printf '%q ' "$task" sweep)" '"$SLURM_ARRAY_TASK_ID"' \
  "$(printf '%q ' "$shards" "$folder" "$spec" "$@")"
if ! "${QERR:-qerr}" merge "${files[@]}" --output "$out" --spec "$spec" "${same[@]}"; then
  echo "slurm_sweep: see $folder/logs, then run this again" >&2
  exit 3
fi
rm -r "$folder"
