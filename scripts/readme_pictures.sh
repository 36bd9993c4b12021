#!/usr/bin/env bash
# Draws the picture of README.md anew, in .github/pictures, with Debian's chromium.
#
#   scripts/readme_pictures.sh [QERR]    default: build/qerr
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
qerr=$(realpath "${1-$root/build/qerr}")
pictures=$root/.github/pictures
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$pictures"
cd "$root/configs"

"$qerr" analyze -q kuka_lwr/spec.yaml -o "$work/analyze.html"
chromium --headless --no-sandbox --disable-gpu --hide-scrollbars --window-size=1000,1000 \
  --screenshot="$pictures/analyze.png" "file://$work/analyze.html" 2>/dev/null
