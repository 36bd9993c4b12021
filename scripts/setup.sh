#!/usr/bin/env bash
# Installs the Debian packages that qerr needs, those that are missing and no others.
#
#   scripts/setup.sh           to build qerr
#   scripts/setup.sh --tests   also to test it
#   scripts/setup.sh --plots   also to draw the paper's figures
#   scripts/setup.sh --bench   also to test it and to time it
#
# This is the one place where the packages are listed (Debian 12 or later).
set -euo pipefail

packages=(
  g++ cmake ninja-build
  libeigen3-dev         # matrices
  liburdfdom-dev        # URDF
  libexpat1-dev         # URDF: line and column of every element
  libyaml-cpp-dev       # specs
  libboost-dev          # headers only: Sobol sequence, multiprecision
  nlohmann-json3-dev    # reports
  libcli11-dev          # command line
)
test_packages=(
  libgtest-dev librapidcheck-dev
  liborocos-kdl-dev     # Jacobians to compare with
  libvalijson-dev       # JSON Schema validator
  python3 python3-numpy
  clang-format
)

plot_packages=(
  python3 python3-numpy python3-matplotlib
)
bench_packages=(
  libbenchmark-dev      # the parts' times
  liborocos-kdl-dev     # the peer of scripts/compare_peers.sh
  python3-pandas        # reads logs beside qerr
)

case "${1-}" in
  "") ;;
  --tests) packages+=("${test_packages[@]}") ;;
  --plots) packages+=("${plot_packages[@]}") ;;
  --bench) packages+=("${test_packages[@]}" "${bench_packages[@]}") ;;
  *) echo "usage: ${0##*/} [--tests|--plots|--bench]" >&2; exit 2 ;;
esac

if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
  echo "setup: this is no Debian system; please see to the equivalents of: ${packages[*]}" >&2
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
