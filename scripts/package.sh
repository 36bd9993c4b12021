#!/usr/bin/env bash
# Builds the Debian packages qerr_VERSION-1_ARCHITECTURE.deb and python3-qerr_VERSION-1_ARCHITECTURE.deb.
#
#   scripts/package.sh [FOLDER]    the packages are written there; default: build-package/, where it is built
#
# Two builds of one commit, in any folders, give the same bytes: times are those of the commit, or SOURCE_DATE_EPOCH.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build=$root/build-package
output=${1-$build}

"$root/scripts/setup.sh" --package

if [[ -z ${SOURCE_DATE_EPOCH-} ]]; then
  # Without a clone (an archive of the sources), the newest source has the date of the release.
  SOURCE_DATE_EPOCH=$(git -C "$root" log -1 --format=%ct 2>/dev/null || stat -c %Y "$root/CMakeLists.txt")
fi
export SOURCE_DATE_EPOCH

cmake -S "$root" -B "$build" -G Ninja -DQERR_TESTS=OFF -DQERR_PYTHON=ON -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX=/usr \
  "-DCMAKE_CXX_FLAGS=-ffile-prefix-map=$root=. -ffile-prefix-map=$build=." >&2
cmake --build "$build" --parallel "$(nproc)" >&2
mkdir -p "$output"
(umask 022 && cpack --config "$build/CPackConfig.cmake" -B "$output" &&
  cpack --config "$build/CPackConfig.cmake" -B "$output" -D CPACK_COMPONENTS_ALL=python -D CPACK_DEB_COMPONENT_INSTALL=ON) >&2
rm -rf "$output/_CPack_Packages"
ls "$output"/*qerr_*.deb
