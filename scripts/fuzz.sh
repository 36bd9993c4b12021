#!/usr/bin/env bash
# Builds the fuzz targets of tests/fuzz with Clang and libFuzzer in build-fuzz/, and runs them in turn.
#
#   scripts/fuzz.sh [--built FOLDER] [SECONDS] [TARGET...]
#
# SECONDS: of all targets together, default 60; TARGET: spec urdf log motion points commands diagnose, default all. --built: with
# the targets of that build, such as one by GCC with QERR_FUZZ=ON, which finds crashes but does not learn what inputs reach.
#
# Inputs that reach new code are kept in build-fuzz/corpus/TARGET for the next run. tests/fuzz/corpus/TARGET has inputs that
# once found a defect, or that are worth starting from. An input that crashes is written to build-fuzz/found/, and ends the run
# with exit code 1; `build-fuzz/tests/fuzz/fuzz_TARGET FILE` repeats it. FUZZ_SEED fixes the random numbers.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build=$root/build-fuzz
built=
if [[ ${1-} == --built ]]; then
  build=${2?--built: which folder?}
  built=yes
  shift 2
fi
seconds=${1-60}
[[ $# -eq 0 ]] || shift
all=(spec urdf log motion points commands diagnose)
targets=("$@")
[[ ${#targets[@]} -gt 0 ]] || targets=("${all[@]}")
usage() {
  echo "usage: ${0##*/} [--built FOLDER] [SECONDS] [TARGET...]; targets: ${all[*]}" >&2
  exit 2
}
[[ $seconds =~ ^[1-9][0-9]*$ ]] || usage
for target in "${targets[@]}"; do
  [[ " ${all[*]} " == *" $target "* ]] || usage
done

if [[ -z $built ]]; then
  "$root/scripts/setup.sh" --fuzz
  options=(-DQERR_FUZZ=ON -DQERR_TESTS=OFF -DCMAKE_CXX_COMPILER=clang++ "-DQERR_SANITIZE=fuzzer-no-link,address,undefined"
           -DQERR_UNITY=ON -DCMAKE_BUILD_TYPE=RelWithDebInfo "-DCMAKE_CXX_FLAGS_RELWITHDEBINFO=-O1 -g1 -DNDEBUG")
  if [[ ! -f $build/CMakeCache.txt ]]; then
    options+=(-G Ninja)
  fi
  cmake -S "$root" -B "$build" "${options[@]}" >&2
  cmake --build "$build" --parallel "$(nproc)" --target qerr_fuzz >&2
fi

# The first byte of an input of `commands` chooses the command lines, which the fuzzer changes; each spec starts with one of them.
# Fewer samples a second: more inputs.
with_commands() {
  mkdir -p "$build/specs"
  local spec uses=abcdefghijklmnopqrstuvwxyz use=0
  for spec in "$root"/tests/corpus/good_specs/*.yaml; do
    { printf '%s' "${uses:use++:1}"; sed 's/1 kHz/200 Hz/g' "$spec"; } > "$build/specs/${spec##*/}"
  done
  echo "$build/specs"
}

starts() {  # folders with inputs to start from
  case $1 in
    spec) echo "$root/tests/corpus/good_specs" "$root/tests/corpus/bad_specs" ;;
    urdf) echo "$root/tests/corpus/flawed_urdfs" "$root/tests/corpus/bad_urdfs" ;;
    commands) with_commands ;;
  esac
  if [[ -d $root/tests/fuzz/corpus/$1 ]]; then
    echo "$root/tests/fuzz/corpus/$1"
  fi
}

export UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1
mkdir -p "$build/found"
each=$(( (seconds + ${#targets[@]} - 1) / ${#targets[@]} ))
status=0
for target in "${targets[@]}"; do
  mkdir -p "$build/corpus/$target"
  echo "== fuzz $target" >&2
  length=8192
  [[ $target != diagnose ]] || length=32768  # what a diagnosis does depends on the number of rows
  read -ra folders <<< "$(starts "$target" | tr '\n' ' ')"
  "$build/tests/fuzz/fuzz_$target" -max_total_time="$each" -max_len="$length" -keep_seed=1 -timeout=20 -rss_limit_mb=2048 -seed="${FUZZ_SEED-0}" \
    -print_final_stats=1 -verbosity=0 -artifact_prefix="$build/found/$target-" \
    "$build/corpus/$target" "${folders[@]}" >&2 || status=1
done
exit $status
