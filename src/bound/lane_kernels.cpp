#include "bound/lane_corners.hpp"
#include "bound/lane_errors.hpp"
#include "bound/lane_tally.hpp"
#include "lanes/compiled_set.hpp"

namespace qerr::lanes {
namespace {

/// Values of `count` forms of one shape. They share what is loaded of the columns, and some eight sums
/// overlap in the pipeline: a quarter of the time of one form and one vector.
template <std::size_t count, bool squared, bool biased, bool rooted, class L>
void forms_of(const double* const* columns, const ColumnForm* form, double* figures) {
  constexpr std::size_t vectors = count > 1 ? 2 : 4;
  for (std::size_t i = 0; i < batch_size; i += vectors * lane_count<L>) {
    L sum[count][vectors] = {}, mean[count][vectors] = {};
    for (std::size_t k = 0; k < form->columns; ++k) {
      L column[vectors], size[vectors];
#pragma GCC unroll 4
      for (std::size_t v = 0; v < vectors; ++v) {
        column[v] = load<L>(columns[k] + i + v * lane_count<L>);
        size[v] = squared ? column[v] * column[v] : abs(column[v]);
      }
#pragma GCC unroll 4
      for (std::size_t f = 0; f < count; ++f) {
        const L weight = broadcast<L>(form[f].weights[k]);
        const L of_mean = broadcast<L>(biased ? form[f].means[k] : 0);
#pragma GCC unroll 4
        for (std::size_t v = 0; v < vectors; ++v) {
          sum[f][v] = fma(size[v], weight, sum[f][v]);
          if (biased) mean[f][v] = fma(column[v], of_mean, mean[f][v]);
        }
      }
    }
#pragma GCC unroll 4
    for (std::size_t f = 0; f < count; ++f)
#pragma GCC unroll 4
      for (std::size_t v = 0; v < vectors; ++v) {
        const L all = sum[f][v] + form[f].added;
        store(figures + f * batch_size + i + v * lane_count<L>,
              rooted    ? sqrt(all)
              : squared ? all
                        : min(biased ? all + abs(mean[f][v]) : all, broadcast<L>(form[f].most)));
      }
  }
}

template <std::size_t count, class L>
void forms_of(const double* const* columns, const ColumnForm* form, bool rooted, double* figures) {
  (form->squared ? rooted ? forms_of<count, true, false, true, L> : forms_of<count, true, false, false, L>
   : form->means ? forms_of<count, false, true, false, L>
                 : forms_of<count, false, false, false, L>)(columns, form, figures);
}

/// Whether both are computed by the same instructions.
bool have_one_shape(const ColumnForm& a, const ColumnForm& b) {
  return a.squared == b.squared && a.columns == b.columns && !a.means == !b.means;
}

template <class L>
void forms(const double* const* columns, std::size_t count, const ColumnForm* form, bool rooted,
           double* figures) {
  constexpr std::size_t together = 4;
  while (count > 0) {
    std::size_t done = 1;
    while (done < count && done < together && have_one_shape(form[0], form[done])) ++done;
    if (done < together) done = 1;
    (done == together ? forms_of<together, L> : forms_of<1, L>)(columns, form, rooted, figures);
    count -= done, form += done, figures += done * batch_size;
  }
}

template <class L>
double* append_larger(const double* values, double least, double* to) {
  constexpr std::size_t at_once = 16;  // few of which have one, where a hundredth of all values are larger
  for (const double* const end = values + batch_size; values != end; values += at_once) {
    Bits<L> larger{};
#pragma GCC unroll 8
    for (std::size_t i = 0; i < at_once; i += lane_count<L>) larger |= load<L>(values + i) > least;
    std::int64_t any = 0;
#pragma GCC unroll 8
    for (std::size_t i = 0; i < lane_count<L>; ++i) any |= larger[i];
    if (!any) continue;
    for (std::size_t i = 0; i < at_once; ++i) {  // without branches, which would be mispredicted
      *to = values[i];
      to += values[i] > least;
    }
  }
  return to;
}

}  // namespace
}  // namespace qerr::lanes

namespace qerr {

template <>
const BoundKernels& compiled_kernels<BoundKernels, lanes::compiled_set>() {
  using namespace lanes;
  using L = CompiledLanes;
  static constexpr BoundKernels kernels{lane_count<L>, scratch<L>,       errors<L>,         tally<L>,
                                        forms<L>,      append_larger<L>, largest_corners<L>};
  return kernels;
}

}  // namespace qerr
