#include "qerr/filter/family.hpp"

#include <array>
#include <cmath>

#include "families/families.hpp"

namespace qerr {

const std::vector<FilterFamily>& filter_families() {
  static const std::vector<FilterFamily> list{
      first_order_family(),
      butterworth_family(),
  };
  return list;
}

std::string figure(double value) {
  std::array<char, 64> text{};
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 12);
  return {text.data(), end.ptr};
}

int whole_number(const FilterDesign& design, const std::string& key, int fallback, int least, int most) {
  const auto entry = design.numbers.find(key);
  if (entry == design.numbers.end()) return fallback;
  const double value = entry->second;
  if (!(value >= least && value <= most) || value != std::floor(value)) {
    throw Error(Fault{{},
                      key,
                      "must be a whole number in range",
                      figure(value),
                      "use " + std::to_string(least) + " to " + std::to_string(most)});
  }
  return static_cast<int>(value);
}

double checked_cutoff(const FilterDesign& design) {
  const auto entry = design.numbers.find("cutoff");
  if (entry == design.numbers.end()) {
    throw Error(Fault{{}, "cutoff", "the filter needs a cut-off", "none", "add e.g. `cutoff: 50 Hz`"});
  }
  const double cutoff = entry->second;
  if (!(cutoff > 0)) {
    throw Error(Fault{{}, "cutoff", "the cut-off must be above 0 Hz", figure(cutoff) + " Hz", ""});
  }
  if (!(cutoff < design.sample_rate / 2)) {
    throw Error(Fault{{},
                      "cutoff",
                      "the cut-off must lie below half the sample rate",
                      figure(cutoff) + " Hz at " + figure(design.sample_rate) + " Hz",
                      "use less than " + figure(design.sample_rate / 2) + " Hz, or sample faster"});
  }
  return cutoff;
}

Filter difference_filter(double sample_rate, int derivative) {
  if (!(sample_rate > 0) || !std::isfinite(sample_rate)) {
    throw Error(
        Fault{{}, "sample_rate", "the sample rate must be above 0 Hz", figure(sample_rate) + " Hz", ""});
  }
  if (derivative < 0 || derivative > max_derivative) {
    throw Error(Fault{{},
                      "derivative",
                      "must be a whole number in range",
                      std::to_string(derivative),
                      "use 0 to " + std::to_string(max_derivative)});
  }
  Filter filter{{}, 1, sample_rate, derivative};
  for (int i = 0; i < derivative; ++i) {
    filter.sections.push_back({{0, 1, 0}, {1, 1, 0}});  // 1 - z^-1 = 2w/(1 + w)
    filter.gain *= 2 * sample_rate;
  }
  return filter;
}

}  // namespace qerr
