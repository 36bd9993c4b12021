#!/usr/bin/env bash
# Installs missing packages, builds qerr in build/ and reproduces the paper's tables and figures, as CSV and PNG.
#
#   scripts/reproduce_paper.sh [FOLDER]       default: build/paper
#   scripts/reproduce_paper.sh --check        compares the table of configs/paper/README.md with new results
#   scripts/reproduce_paper.sh --write-page   writes new results into that table
#
# --quick omits the long simulations (Figs. 12 and 13).
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
