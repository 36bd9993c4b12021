#!/usr/bin/env bash
# Checks the one-definition rule: builds the program with link-time optimization and fails on any -Wodr warning.
#
#   scripts/check_odr.sh            takes some minutes; the build is in build-odr/
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build=$root/build-odr

"$root/scripts/setup.sh"

options=()
if [[ ! -f $build/CMakeCache.txt ]]; then
  options=(-G Ninja)
fi
# -O1 is sufficient: the linker compares the types of all translation units at every level.
# gcc-ar is needed because plain ar does not index objects that contain GCC's intermediate code.
cmake -S "$root" -B "$build" "${options[@]}" -DQERR_TESTS=OFF -DCMAKE_BUILD_TYPE=Release \
  -DCMAKE_CXX_COMPILER=g++ -DCMAKE_AR="$(command -v gcc-ar)" -DCMAKE_RANLIB="$(command -v gcc-ranlib)" \
  -DCMAKE_CXX_FLAGS_RELEASE="-O1 -DNDEBUG -flto -Wodr -Werror=odr" \
  -DCMAKE_EXE_LINKER_FLAGS_RELEASE="-flto=$(nproc) -Wodr -Werror=odr -Wlto-type-mismatch" >/dev/null
cmake --build "$build" --parallel "$(nproc)" --target qerr
echo "check_odr: no type has two definitions" >&2
