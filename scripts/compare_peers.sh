#!/usr/bin/env bash
# Compares the throughput of qerr's main job with KDL, and with RBDL and Pinocchio if they are installed, in one run.
#
#   scripts/compare_peers.sh [SPEC_OR_URDF...] [OPTIONS]
#
#   scripts/compare_peers.sh                                     configs/kuka_lwr, nominal and calibrated
#   scripts/compare_peers.sh panda.urdf --tip panda_link8        a plain URDF
#   scripts/compare_peers.sh --only kdl,workspace --rounds 15    fewer contestants, more rounds
#   scripts/compare_peers.sh --markdown --json figures.json      as a Markdown table, as JSON
#   scripts/compare_peers.sh --help                              all options
#
# First every contestant is checked against qerr's scalar code (exit code 1 if one disagrees). Then all are timed in
# interleaved rounds, on one thread, by its CPU time: jac is the tip Jacobian, job adds the worst case and the
# covariance, full adds the statistics. CMAKE_PREFIX_PATH in the environment locates RBDL and Pinocchio outside the
# system's folders.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

"$root/scripts/setup.sh" --bench

# The build of run_tests.sh is used, unless it is a debug or sanitizer build, which would be slow.
build=$root/build
cache=$build/CMakeCache.txt
if [[ -f $cache ]]; then
  grep -q '^CMAKE_BUILD_TYPE:.*=Release$' "$cache" && grep -q '^QERR_SANITIZE:.*=$' "$cache" || build=$root/build-bench
fi
options=(-DQERR_BENCH=ON -DCMAKE_BUILD_TYPE=Release)
if [[ ! -f $build/CMakeCache.txt ]]; then
  options+=(-G Ninja)
fi
cmake -S "$root" -B "$build" "${options[@]}" >"$build.log" || { cat "$build.log" >&2; exit 1; }
grep compare_peers "$build.log" >&2 || true
rm "$build.log"
cmake --build "$build" --target compare_peers --parallel "$(nproc)" >&2

exec "$build/tests/bench/peers/compare_peers" "$@"
