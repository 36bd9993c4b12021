#!/usr/bin/env bash
# Prepares the machine, builds qerr into build/ and makes the paper's tables and figures with it, as CSV and PNG.
#
#   scripts/reproduce_paper.sh [FOLDER]       default: build/paper
#   scripts/reproduce_paper.sh --check        is the table of configs/paper/README.md still right?
#   scripts/reproduce_paper.sh --write-page   renews that table
#
# --quick leaves the long simulations out (Figs. 12 and 13).
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

"$root/scripts/setup.sh" --plots

options=()
if [[ ! -f $root/build/CMakeCache.txt ]]; then
  options=(-G Ninja -DCMAKE_BUILD_TYPE=Release -DQERR_TESTS=OFF)
fi
cmake -S "$root" -B "$root/build" "${options[@]}" >&2
cmake --build "$root/build" --parallel "$(nproc)" --target qerr >&2

# Debian's own interpreter, where it is: it is the one that has Debian's numpy and matplotlib.
python=/usr/bin/python3
[[ -x $python ]] || python=python3
exec "$python" "$root/scripts/reproduce_paper" --qerr "$root/build/qerr" "$@"
