#!/usr/bin/env bash
# Builds qerr with sanitizers, each mode in its own folder, and runs the tests.
#
#   scripts/sanitize.sh            addresses and undefined behaviour, with Clang, in build-address/
#   scripts/sanitize.sh thread     data races, in build-thread/
#
# Further arguments are passed to ctest, such as -R Filter.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
mode=${1-address}
[[ $# -eq 0 ]] || shift
case $mode in
  address) sanitizers=address,undefined ;;
  thread) sanitizers=thread ;;
  *) echo "usage: ${0##*/} [address|thread] [CTEST OPTIONS]" >&2; exit 2 ;;
esac
build=$root/build-$mode

"$root/scripts/setup.sh" --tests
[[ $mode == thread ]] || "$root/scripts/setup.sh" --fuzz  # Clang

export ASAN_OPTIONS=strict_string_checks=1:detect_stack_use_after_return=1
export UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1
export TSAN_OPTIONS=halt_on_error=1:second_deadlock_stack=1

# GCC 12's thread sanitizer fails to start if the kernel randomizes addresses over too many bits.
command_prefix=()
if [[ $mode == thread ]] && setarch "$(uname -m)" --addr-no-randomize true 2>/dev/null; then
  command_prefix=(setarch "$(uname -m)" --addr-no-randomize)
fi

# Line numbers suffice for reports. Clang takes a third of GCC's time for sources that are joined and watched.
options=(-DQERR_TESTS=ON "-DQERR_SANITIZE=$sanitizers" -DCMAKE_BUILD_TYPE=RelWithDebInfo
         "-DCMAKE_CXX_FLAGS_RELWITHDEBINFO=-O1 -g1 -DNDEBUG")
if [[ $mode == address ]]; then
  options+=(-DCMAKE_CXX_COMPILER=clang++ -DCMAKE_C_COMPILER=clang)
else
  options+=(-DQERR_UNITY=OFF)
fi
if [[ ! -f $build/CMakeCache.txt ]]; then
  options+=(-G Ninja)
fi
cmake -S "$root" -B "$build" "${options[@]}"
# The build runs the test program to list its tests, therefore under setarch too.
"${command_prefix[@]}" cmake --build "$build" --parallel "$(nproc)"
# Left out: tests that limit memory or CPU time, or preload a library ahead of the sanitizer's.
"${command_prefix[@]}" ctest --test-dir "$build" --output-on-failure --no-tests=error --parallel "$(nproc)" \
  --exclude-regex '^acceptance[.](bad_input|hard_inputs|diagnosis_page|faults|package)$' "$@"
