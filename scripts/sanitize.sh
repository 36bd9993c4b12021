#!/usr/bin/env bash
# Builds qerr with Clang's sanitizers, each mode in its own folder, and runs the tests.
#
#   scripts/sanitize.sh            addresses and undefined behaviour: all tests, in build-address/
#   scripts/sanitize.sh thread     data races: the tests that run threads, in build-thread/
#
# Further arguments are passed to ctest, such as -R Filter. The build alone takes ten minutes or more.
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

"$root/scripts/setup.sh" --tests --fuzz  # Clang, which takes a third of GCC's time here

export ASAN_OPTIONS=strict_string_checks=1:detect_stack_use_after_return=1
export UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1
export TSAN_OPTIONS=halt_on_error=1:second_deadlock_stack=1

# A thread sanitizer may fail to start, as GCC 12's does, if the kernel randomizes addresses over too many bits.
command_prefix=()
if [[ $mode == thread ]] && setarch "$(uname -m)" --addr-no-randomize true 2>/dev/null; then
  command_prefix=(setarch "$(uname -m)" --addr-no-randomize)
fi

# Line numbers suffice for reports.
options=(-DQERR_TESTS=ON "-DQERR_SANITIZE=$sanitizers" -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_C_COMPILER=clang
         -DCMAKE_BUILD_TYPE=RelWithDebInfo "-DCMAKE_CXX_FLAGS_RELWITHDEBINFO=-O1 -g1 -DNDEBUG")
if [[ ! -f $build/CMakeCache.txt ]]; then
  options+=(-G Ninja)
fi
cmake -S "$root" -B "$build" "${options[@]}"
# The build runs the test program to list its tests, therefore under setarch too.
"${command_prefix[@]}" cmake --build "$build" --parallel "$(nproc)"

# A regular expression: the suites in the files, and the scripts, that ask for threads.
threaded() {
  local suites scripts
  suites=$(grep -lE 'threads|parallel|in_order' "$root"/tests/*/*_test.cpp | xargs sed -nE 's/^(TEST|TEST_F|TEST_P|RC_GTEST_PROP)\(([A-Za-z0-9_]+).*/\2/p')
  scripts=$(grep -l -e --threads "$root"/tests/acceptance/check_*.py | sed -E 's/.*check_(.*)[.]py/acceptance.\1/')
  printf '^(.*/)?(%s)([.].*)?$' "$(printf '%s\n' $suites $scripts | sort -u | paste -sd '|')"
}
selected=()
[[ $mode == address ]] || selected=(--tests-regex "$(threaded)")

# Left out: tests that limit memory or CPU time, or watch it by other means.
"${command_prefix[@]}" ctest --test-dir "$build" --output-on-failure --no-tests=error --parallel "$(nproc)" \
  --exclude-regex '^acceptance[.](bad_input|hard_inputs|diagnosis_page|faults|memory|package)$' "${selected[@]}" "$@"
