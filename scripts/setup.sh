#!/usr/bin/env bash
# Installs the missing ones of the Debian packages that qerr needs.
#
#   scripts/setup.sh              packages for the program
#   scripts/setup.sh --tests      and for the tests
#   scripts/setup.sh --package    and for scripts/package.sh
#   scripts/setup.sh --plots      and for the figures of the paper
#   scripts/setup.sh --bench      and for the benchmarks
#   scripts/setup.sh --fuzz       and for scripts/fuzz.sh
#   scripts/setup.sh --libfuzzer  and for the fuzz targets without Clang, as continuous integration runs them
#   scripts/setup.sh --slurm      and for the test of scripts/slurm_sweep.sh, which is skipped without them
#
# Several options may be given.
#
# The only list of packages (Debian 12 or later).
set -euo pipefail

packages=(
  g++ cmake ninja-build
  libeigen3-dev         # matrices
  liburdfdom-dev        # URDF
  libexpat1-dev         # URDF: line and column of each element, for messages
  libyaml-cpp-dev       # specs
  libsqlite3-dev liblz4-dev libzstd-dev  # logs: bags of ROS 2
  libboost-dev          # headers only: Sobol sequence, multiprecision, distributions
  nlohmann-json3-dev    # reports
  libcli11-dev          # command line
)
test_packages=(
  libgtest-dev librapidcheck-dev
  liborocos-kdl-dev     # reference for Jacobians and dynamics
  libvalijson-dev       # JSON Schema validator
  python3 python3-numpy
  python3-mpmath        # reference for the figures of filters
  python3-jsonschema    # reports against their schemas
  zsh fish groff-base   # completions and man pages
  valgrind              # commands that compute, under it
  tidy                  # validates HTML pages (with chromium, if it is there, tests also show them)
  jq python3-pandas     # README.md and the help use them
  python3-yaml          # recipes of continuous integration
  pybind11-dev python3-dev  # the Python module
  pkg-config            # a program that links the installed library
  ament-cmake           # the same in a package of ROS 2
  parallel              # scripts/parallel_sweep.sh
  clang-format
)
package_packages=(
  dpkg-dev file         # libraries that the program needs, by package
  pybind11-dev python3-dev  # python3-qerr
)
plot_packages=(
  python3 python3-numpy python3-matplotlib
)
bench_packages=(
  libbenchmark-dev      # timing
  liborocos-kdl-dev     # scripts/compare_peers.sh
  python3-pandas        # bench_read_log
)
libfuzzer_packages=(
  libclang-rt-14-dev
)
fuzz_packages=(
  clang "${libfuzzer_packages[@]}"
)
slurm_packages=(
  slurm-wlm munge       # 14 MB; apart from the tests', as they bring daemons that start with the machine
)

for option in "$@"; do
  case "$option" in
    --tests) packages+=("${test_packages[@]}") ;;
    --package) packages+=("${package_packages[@]}") ;;
    --plots) packages+=("${plot_packages[@]}") ;;
    --bench) packages+=("${bench_packages[@]}") ;;
    --fuzz) packages+=("${fuzz_packages[@]}") ;;
    --libfuzzer) packages+=("${libfuzzer_packages[@]}") ;;
    --slurm) packages+=("${slurm_packages[@]}") ;;
    *) echo "usage: ${0##*/} [--tests|--package|--plots|--bench|--fuzz|--libfuzzer|--slurm]" >&2; exit 2 ;;
  esac
done

if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
  echo "setup: not a Debian system; please install the equivalents of: ${packages[*]}" >&2
  exit 0
fi

missing=()
for package in "${packages[@]}"; do
  state=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true)
  [[ $state == installed ]] || missing+=("$package")
done
if [[ ${#missing[@]} -eq 0 ]]; then
  exit 0
fi

as_root=()
if [[ $(id -u) -ne 0 ]]; then
  if ! command -v sudo >/dev/null; then
    echo "setup: please run as root: apt-get install ${missing[*]}" >&2
    exit 1
  fi
  as_root=(sudo)
fi
apt_get() {
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get -qq -o Dpkg::Use-Pty=0 -o DPkg::Lock::Timeout=300 "$@" >/dev/null
}

echo "setup: installing ${missing[*]}" >&2
apt_get update
apt_get install --yes --no-install-recommends "${missing[@]}"
