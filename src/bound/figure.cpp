#include "qerr/bound/figure.hpp"

#include <array>

namespace qerr {

std::string_view name_of(Bound b) {
  constexpr std::array<std::string_view, 5> names{"worst_case", "worst_case_rigorous", "sigma",
                                                  "sigma_quantization", "sigma_in_motion"};
  return names[static_cast<std::size_t>(b)];
}

}  // namespace qerr
