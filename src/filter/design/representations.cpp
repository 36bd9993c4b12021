#include "filter/design/representations/representations.hpp"

#include <cmath>

#include "qerr/filter/family.hpp"

namespace qerr {

const std::vector<FilterRepresentation>& filter_representations() {
  static const std::vector<FilterRepresentation> list{
      coefficients_representation(),          sections_representation(),
      zero_pole_gain_representation(),        state_space_representation(),
      ros_transfer_function_representation(),
  };
  return list;
}

std::vector<double> flat(const Rows& rows, const std::string& key) {
  std::vector<double> list;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].size() != 1) {
      throw Error(Fault{{},
                        key + '[' + std::to_string(i) + ']',
                        "must be one number",
                        "a list of " + std::to_string(rows[i].size()),
                        "write [c0, c1, ...]"});
    }
    list.push_back(rows[i][0]);
  }
  return list;
}

void check_finite(const Rows& rows, const std::string& key) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (const double x : rows[i]) {
      if (!std::isfinite(x))
        throw Error(
            Fault{{}, key + '[' + std::to_string(i) + ']', "the numbers must be finite", figure(x), ""});
    }
  }
}

Error unstable(const std::string& key, double largest_modulus) {
  return Error(Fault{{},
                     key,
                     "the filter is not stable: a pole lies on or outside the unit circle, or within "
                     "the rounding of its numbers of it",
                     "largest pole modulus " + figure(largest_modulus),
                     "all poles must lie inside"});
}

}  // namespace qerr
