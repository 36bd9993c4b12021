#!/usr/bin/env bash
# Installs missing packages, builds qerr and its tests in build/, and runs all tests.
#
#   scripts/run_tests.sh [CTEST OPTIONS]    such as -R Filter
#
# The floors and the format of the sources are checked first. With CI=true warnings are errors, and some fuzzing is one of
# the tests.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

options=(-DQERR_PYTHON=ON -DPython_EXECUTABLE=/usr/bin/python3)
if [[ ${CI-} == true ]]; then
  options+=(-DQERR_WERROR=ON)
fi
# On a new machine the program is built while the packages of the tests are fetched and installed.
building=
if [[ ! -f $root/build/CMakeCache.txt ]]; then
  "$root/scripts/setup.sh"
  options+=(-G Ninja -DCMAKE_BUILD_TYPE=Release)
  cmake -S "$root" -B "$root/build" "${options[@]}" -DQERR_PYTHON=OFF -DQERR_TESTS=OFF >/dev/null
  ninja -C "$root/build" -j "$(nproc)" qerr &
  building=$!
  trap 'kill "$building"' EXIT
fi
if [[ ${CI-} == true ]]; then
  "$root/scripts/setup.sh" --tests --libfuzzer
  options+=(-DQERR_FUZZ=ON)
else
  "$root/scripts/setup.sh" --tests
fi

echo "== floors" >&2
python3 "$root/scripts/check_floors.py" --self-test
python3 "$root/scripts/check_floors.py"

echo "== format" >&2
find "$root/include" "$root/src" "$root/tests" \( -name '*.hpp' -o -name '*.cpp' \) -print0 |
  xargs -0 clang-format --dry-run --Werror

echo "== build" >&2
if [[ -n $building ]]; then
  trap - EXIT
  wait "$building"
fi
cmake -S "$root" -B "$root/build" "${options[@]}" -DQERR_TESTS=ON
cmake --build "$root/build" --parallel "$(nproc)"

echo "== tests" >&2
ctest --test-dir "$root/build" --output-on-failure --no-tests=error --parallel "$(nproc)" "$@"
