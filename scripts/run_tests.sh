#!/usr/bin/env bash
# Installs missing packages, builds qerr and its tests in build/, and runs all tests.
#
#   scripts/run_tests.sh [CTEST OPTIONS]    such as -R Filter
#
# The floors and the format of the sources are checked first. With CI=true warnings are errors, and some fuzzing is one of
# the tests.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

"$root/scripts/setup.sh" --tests
if [[ ${CI-} == true ]]; then
  "$root/scripts/setup.sh" --libfuzzer
fi

echo "== floors" >&2
python3 "$root/scripts/check_floors.py" --self-test
python3 "$root/scripts/check_floors.py"

echo "== format" >&2
find "$root/include" "$root/src" "$root/tests" \( -name '*.hpp' -o -name '*.cpp' \) -print0 |
  xargs -0 clang-format --dry-run --Werror

echo "== build" >&2
options=(-DQERR_TESTS=ON -DQERR_PYTHON=ON -DPython_EXECUTABLE=/usr/bin/python3)
if [[ ! -f $root/build/CMakeCache.txt ]]; then
  options+=(-G Ninja -DCMAKE_BUILD_TYPE=Release)
fi
if [[ ${CI-} == true ]]; then
  options+=(-DQERR_WERROR=ON -DQERR_FUZZ=ON)
fi
cmake -S "$root" -B "$root/build" "${options[@]}"
cmake --build "$root/build" --parallel "$(nproc)"

echo "== tests" >&2
ctest --test-dir "$root/build" --output-on-failure --no-tests=error --parallel "$(nproc)" "$@"
