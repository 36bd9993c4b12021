#include "bound/lane_errors.hpp"
#include "bound/lane_tally.hpp"
#include "lanes/compiled_set.hpp"

namespace qerr {

template <>
const BoundKernels& compiled_kernels<BoundKernels, lanes::compiled_set>() {
  using namespace lanes;
  using L = CompiledLanes;
  static constexpr BoundKernels kernels{lane_count<L>, scratch<L>, errors<L>, tally<L>};
  return kernels;
}

}  // namespace qerr
