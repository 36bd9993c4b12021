#!/usr/bin/env bash
# Builds the program with Clang in build-clang/ and analyzes a shipped robot with it. Takes some minutes.
#
#   scripts/check_clang.sh [CLANG]    default: clang++
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build=$root/build-clang
clang=${1-clang++}

if ! command -v "$clang" >/dev/null; then
  echo "check_clang: '$clang' not found; on Debian: apt-get install clang" >&2
  exit 1
fi
"$root/scripts/setup.sh"

options=()
if [[ ! -f $build/CMakeCache.txt ]]; then
  options=(-G Ninja)
fi
cmake -S "$root" -B "$build" "${options[@]}" -DQERR_TESTS=OFF -DCMAKE_BUILD_TYPE=Release \
  -DCMAKE_CXX_COMPILER="$clang" >/dev/null
cmake --build "$build" --parallel "$(nproc)" --target qerr
"$build/qerr" analyze -q "$root/configs/phantom_premium/spec.yaml" >/dev/null
echo "check_clang: $("$clang" --version | head -n 1)" >&2
