#include "qerr/bound/figure.hpp"

#include <array>

namespace qerr {

namespace {

struct BoundRow {
  std::string_view name, summary;
};

/// In the order of the enumeration.
constexpr std::array<BoundRow, 5> bound_rows{
    {{"worst_case", "largest error of the linearized kinematics; behind a filter with its l1 norm"},
     {"worst_case_rigorous", "the same plus the linearization remainder: no error exceeds it"},
     {"sigma", "standard deviation, errors of encoders independent (IPQN); behind a filter with its H2 norm"},
     {"sigma_quantization", "sigma of quantization alone, without accuracies and effects"},
     {"sigma_in_motion", "root mean square along `motion:`, over all zeros of the encoders"}}};

}  // namespace

std::span<const Bound> bounds_of(bool behind_filter) {
  static constexpr std::array of_position{Bound::worst_case, Bound::worst_case_rigorous, Bound::sigma};
  static constexpr std::array of_filter{Bound::worst_case, Bound::sigma, Bound::sigma_quantization,
                                        Bound::sigma_in_motion};
  if (behind_filter) return of_filter;
  return of_position;
}

std::string_view name_of(Bound b) { return bound_rows[static_cast<std::size_t>(b)].name; }

std::string_view summary_of(Bound b) { return bound_rows[static_cast<std::size_t>(b)].summary; }

}  // namespace qerr
