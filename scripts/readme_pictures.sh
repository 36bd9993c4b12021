#!/usr/bin/env bash
# Draws the pictures of README.md anew, in .github/pictures, with Debian's chromium.
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
"$qerr" filter -q scara/spec.yaml -o "$work/filter.html"
"$qerr" simulate -q scara/spec.yaml --log "$work/scara.csv" -o "$work/simulated.txt" \
  --set 'effects=[{type: eccentricity, joint: elbow, amplitude: 0.2 mrad, phase: 30 deg}, {type: backlash, joint: wrist, gap: 0.4 mrad}]'
(cd "$work" && "$qerr" diagnose -q "$root/configs/scara/spec.yaml" scara.csv -o diagnose.html)
"$qerr" sweep -q kuka_lwr/spec.yaml -o "$work/sweep.html" --set configurations.count=1000 \
  --set 'sweep=[{key: "encoders.*.counts_per_rev", from: 1024, to: 65536, count: 7, scale: log}]'

shoot() {  # page, height in pixels
  chromium --headless --no-sandbox --disable-gpu --hide-scrollbars --window-size="1000,$2" \
    --screenshot="$pictures/$1.png" "file://$work/$1.html" 2>/dev/null
}
shoot analyze 1000
shoot filter 900
shoot diagnose 710
shoot sweep 700
ls -l "$pictures"
