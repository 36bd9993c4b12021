#!/usr/bin/env bash
# Installs missing packages, builds qerr in build/ and reproduces the paper's tables and figures, as CSV and PNG.
#
#   scripts/reproduce_paper.sh [FOLDER]       default: build/paper
#   scripts/reproduce_paper.sh --row N        row N of configs/paper/README.md, computed anew, and the commands behind it
#   scripts/reproduce_paper.sh --check        compares the tables of that page with new results, digit by digit
#   scripts/reproduce_paper.sh --write-page   writes new results into that page
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

"$root/scripts/setup.sh" --plots

options=()
if [[ ! -f $root/build/CMakeCache.txt ]]; then
  options=(-G Ninja -DCMAKE_BUILD_TYPE=Release -DQERR_TESTS=OFF)
fi
cmake -S "$root" -B "$root/build" "${options[@]}" >&2
cmake --build "$root/build" --parallel "$(nproc)" --target qerr >&2

# The system's own interpreter if there is one: Debian installs numpy and matplotlib for this one only.
python=/usr/bin/python3
[[ -x $python ]] || python=python3
exec "$python" "$root/scripts/reproduce_paper" --qerr "$root/build/qerr" "$@"
