#include "bound/lane_corners.hpp"
#include "bound/lane_errors.hpp"
#include "bound/lane_tally.hpp"
#include "lanes/compiled_set.hpp"

namespace qerr::lanes {
namespace {

/// Values of a form, four vectors at a time, whose sums overlap in the pipeline: half of the time of one.
template <bool squared, bool biased, class L>
void form_of(const double* const* columns, const ColumnForm& form, double* figures) {
  constexpr std::size_t vectors = 4;
  for (std::size_t i = 0; i < batch_size; i += vectors * lane_count<L>) {
    L sum[vectors] = {}, mean[vectors] = {};
    for (std::size_t k = 0; k < form.columns; ++k) {
      const L weight = broadcast<L>(form.weights[k]), of_mean = broadcast<L>(biased ? form.means[k] : 0);
#pragma GCC unroll 4
      for (std::size_t v = 0; v < vectors; ++v) {
        const L column = load<L>(columns[k] + i + v * lane_count<L>);
        sum[v] = fma(squared ? column * column : abs(column), weight, sum[v]);
        if (biased) mean[v] = fma(column, of_mean, mean[v]);
      }
    }
#pragma GCC unroll 4
    for (std::size_t v = 0; v < vectors; ++v) {
      const L all = sum[v] + form.added;
      store(figures + i + v * lane_count<L>,
            squared ? sqrt(all) : min(all + abs(mean[v]), broadcast<L>(form.most)));
    }
  }
}

template <class L>
void forms(const double* const* columns, std::size_t count, const ColumnForm* begin, double* figures) {
  for (const ColumnForm* form = begin; form != begin + count; ++form, figures += batch_size)
    (form->squared ? form_of<true, false, L>
     : form->means ? form_of<false, true, L>
                   : form_of<false, false, L>)(columns, *form, figures);
}

}  // namespace
}  // namespace qerr::lanes

namespace qerr {

template <>
const BoundKernels& compiled_kernels<BoundKernels, lanes::compiled_set>() {
  using namespace lanes;
  using L = CompiledLanes;
  static constexpr BoundKernels kernels{lane_count<L>, scratch<L>, errors<L>,
                                        tally<L>,      forms<L>,   largest_corners<L>};
  return kernels;
}

}  // namespace qerr
