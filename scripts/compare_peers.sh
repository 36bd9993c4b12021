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
# the covariance, full adds the statistics. Builds into build-bench/, always optimized; RBDL and Pinocchio in
# other places than the system's are named with CMAKE_PREFIX_PATH.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

"$root/scripts/setup.sh" --bench

options=(-DQERR_BENCH=ON -DCMAKE_BUILD_TYPE=Release)
if [[ ! -f $root/build-bench/CMakeCache.txt ]]; then
  options+=(-G Ninja)
fi
cmake -S "$root" -B "$root/build-bench" "${options[@]}" | { grep compare_peers || true; } >&2
cmake --build "$root/build-bench" --target compare_peers --parallel "$(nproc)" >&2

exec "$root/build-bench/tests/bench/peers/compare_peers" "$@"
