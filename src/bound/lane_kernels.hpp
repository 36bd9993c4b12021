#pragma once

#include "bound/lane_errors.hpp"
#include "bound/lane_tally.hpp"

namespace qerr::lanes {
namespace {

template <int n>
constexpr BoundKernels bound_kernels{n, room<Lanes<n>>, errors<Lanes<n>>, tally<Lanes<n>>};

}  // namespace
}  // namespace qerr::lanes
