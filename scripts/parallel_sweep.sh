#!/usr/bin/env bash
# A sweep, or many specs, on all cores of this machine with GNU parallel. After an interruption run it again: what
# is complete is kept.
#
#   scripts/parallel_sweep.sh SPEC SHARDS OUT.csv [OPTION...]              options of qerr sweep
#   scripts/parallel_sweep.sh --each COMMAND FOLDER SPEC... [-- OPTION...] qerr analyze or qerr check of each spec
#
# The shards are in OUT.csv.shards until they are merged; reports are FOLDER/SPEC.json. The exit code is 1 if a
# requirement of `--each check` is not met. QERR is the program (default: qerr), JOBS the number of jobs (one per core).
set -euo pipefail

task=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)/batch_task.sh
usage() {
  sed -n '2,/^set/s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2
  exit 2
}
run() {  # when to halt, and a task's command line, with {} for what standard input has
  local halt=$1
  shift
  parallel --will-cite --quote --jobs "${JOBS:-100%}" --halt "$halt" "$task" "$@"
}
command -v parallel >/dev/null || { echo "parallel_sweep: please install GNU parallel" >&2; exit 2; }

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
  printf '%s\n' "${specs[@]}" | run never each "$command" "$folder" {} "$@" || exit 3
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
seq "$shards" | run soon,fail=1 sweep {} "$shards" "$folder" "$spec" "$@"
"${QERR:-qerr}" merge "${files[@]}" --output "$out" --spec "$spec" "${same[@]}"
rm -r "$folder"
