#!/usr/bin/env bash
# Times qerr's main job beside KDL, and beside RBDL and Pinocchio where they are installed, in one run.
#
#   scripts/compare_peers.sh [SPEC_OR_URDF...] [OPTIONS]
#
#   scripts/compare_peers.sh                                     configs/kuka_lwr, as it is and calibrated
#   scripts/compare_peers.sh panda.urdf --tip panda_link8        a plain URDF
#   scripts/compare_peers.sh --only kdl,workspace --rounds 15    fewer contestants, more rounds
#   scripts/compare_peers.sh --markdown --json figures.json      for the README, for machines
#   scripts/compare_peers.sh --help                              all options
#
# First every contestant must agree with qerr's scalar code (exit code 1 where one does not). Then all take
# turns, round by round, on one thread, by its CPU time: jac is the tip Jacobian, job adds the worst case and
# the covariance, full adds the statistics. RBDL and Pinocchio in other places than the system's are named with
# CMAKE_PREFIX_PATH in the environment.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

"$root/scripts/setup.sh" --bench

# The build of run_tests.sh serves, unless it is one for finding faults: those are slow.
build=$root/build
cache=$build/CMakeCache.txt
if [[ -f $cache ]]; then
  grep -q '^CMAKE_BUILD_TYPE:.*=Release$' "$cache" && grep -q '^QERR_SANITIZE:.*=$' "$cache" || build=$root/build-bench
fi
options=(-DQERR_TESTS=ON -DQERR_BENCH=ON -DCMAKE_BUILD_TYPE=Release)
if [[ ! -f $build/CMakeCache.txt ]]; then
  options+=(-G Ninja)
fi
cmake -S "$root" -B "$build" "${options[@]}" >"$build.log" || { cat "$build.log" >&2; exit 1; }
grep compare_peers "$build.log" >&2 || true
rm "$build.log"
cmake --build "$build" --target compare_peers --parallel "$(nproc)" >&2

exec "$build/tests/bench/peers/compare_peers" "$@"
