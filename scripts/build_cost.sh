#!/usr/bin/env bash
# What a full build costs: its CPU time over that of compiling one file that includes <Eigen/Dense> and inverts
# a 6x6 matrix, both in the same run. The ratio hardly depends on the machine.
#
#   scripts/build_cost.sh            the program
#   scripts/build_cost.sh --tests    the program with its tests
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
case "${1-}" in
  "") tests=OFF ;;
  --tests) tests=ON ;;
  *) echo "usage: ${0##*/} [--tests]" >&2; exit 2 ;;
esac

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cat >"$folder/unit.cpp" <<'CPP'
#include <Eigen/Dense>
Eigen::MatrixXd inverse(const Eigen::Matrix<double, 6, 6>& a) { return a.inverse(); }
CPP
cmake -S "$root" -B "$folder/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DQERR_TESTS=$tests \
  -DCMAKE_CXX_COMPILER_LAUNCHER= >/dev/null
eigen=$(pkg-config --cflags eigen3 2>/dev/null || echo -I/usr/include/eigen3)

TIMEFORMAT='%U %S'
cpu_time() { { time "$@" >/dev/null 2>"$folder/errors"; } 2>&1 | awk '{ print $1 + $2 }'; }
# The unit before and after the build, as the machine's speed may drift.
unit() { cpu_time "${CXX:-g++}" -std=c++20 -O3 -DNDEBUG $eigen -c "$folder/unit.cpp" -o "$folder/unit.o"; }
before=$(unit)
build=$(cpu_time cmake --build "$folder/build" --parallel "$(nproc)")
after=$(unit)
awk -v a="$before" -v b="$after" -v build="$build" 'BEGIN {
  unit = (a + b) / 2
  printf "build %.0f s of CPU time, one file %.2f s, ratio %.0f\n", build, unit, build / unit }'
