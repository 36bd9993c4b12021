#!/usr/bin/env bash
# Installs missing packages, builds qerr in build/ and analyzes a shipped robot.
#
#   scripts/run_example.sh [SPEC]    default: configs/phantom_premium/spec.yaml
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
spec=${1-$root/configs/phantom_premium/spec.yaml}

"$root/scripts/setup.sh"

options=()
if [[ ! -f $root/build/CMakeCache.txt ]]; then
  options=(-G Ninja -DCMAKE_BUILD_TYPE=Release -DQERR_TESTS=OFF)
fi
# Build messages go to standard error, so that standard output is the report alone.
cmake -S "$root" -B "$root/build" "${options[@]}" >&2
cmake --build "$root/build" --parallel "$(nproc)" --target qerr >&2

"$root/build/qerr" analyze "$spec"
