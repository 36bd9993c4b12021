#pragma once

// Compiled once for all modules (CMakeLists.txt). A source still includes what it uses: this file saves time,
// and nothing depends on it (-DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON builds without it).

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <numeric>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
