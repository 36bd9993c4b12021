#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "filter/design/families/families.hpp"

namespace qerr {

std::string figure(double value) {
  std::array<char, 64> text{};
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 12);
  return {text.data(), end.ptr};
}

void check_sample_rate(double sample_rate) {
  if (!(sample_rate > 0) || !std::isfinite(sample_rate)) {
    throw Error(
        Fault{{}, "sample_rate", "the sample rate must be above 0 Hz", figure(sample_rate) + " Hz", ""});
  }
}

void check_derivative(int derivative) {
  if (derivative < 0 || derivative > max_derivative) {
    throw Error(Fault{{},
                      "derivative",
                      "must be a whole number in range",
                      std::to_string(derivative),
                      "use 0 to " + std::to_string(max_derivative)});
  }
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

Parameter order_row(int fallback) {
  return {.name = "order",
          .kind = Kind::integer,
          .meaning = "order of the low-pass",
          .fallback = fallback,
          .least = 1,
          .most = max_order};
}

Parameter ripple_row() {
  return {.name = "ripple",
          .kind = Kind::number,
          .meaning = "peak to peak below the cut-off, in dB",
          .fallback = 1.0,
          .least = 0,
          .most = 60,
          .open_below = true};
}

Parameter attenuation_row(std::string_view meaning) {
  return {.name = "attenuation",
          .kind = Kind::number,
          .meaning = meaning,
          .fallback = 40.0,
          .least = 0,
          .most = 300,
          .open_below = true};
}

Parameter cutoff_row(std::string_view meaning) {
  return {.name = "cutoff",
          .kind = Kind::number,
          .dimension = dimension::frequency,
          .meaning = meaning,
          .required = true,
          .least = 0,
          .open_below = true,
          .angular = true};
}

double checked_number(const FilterDesign& design, const std::string& key, double above, double most,
                      std::optional<double> fallback) {
  const auto entry = design.numbers.find(key);
  if (entry == design.numbers.end()) {
    if (fallback) return *fallback;
    throw Error(Fault{{}, key, "missing key", "", "add '" + key + ": ...'"});
  }
  const double value = entry->second;
  if (!(value > above) || !(value <= most) || !std::isfinite(value)) {
    const bool bounded = std::isfinite(most);
    throw Error(Fault{{},
                      key,
                      "is out of range",
                      figure(value),
                      "above " + figure(above) + (bounded ? " and at most " + figure(most) : "")});
  }
  return value;
}

std::string checked_choice(const FilterDesign& design, const std::string& key,
                           const std::vector<std::string>& choices) {
  const auto entry = design.choices.find(key);
  if (entry == design.choices.end()) return choices.front();
  if (std::find(choices.begin(), choices.end(), entry->second) != choices.end()) return entry->second;
  std::string known;
  for (const std::string& choice : choices) known += (known.empty() ? "" : ", ") + choice;
  throw Error(
      Fault{{}, key, "is not one of the choices", "'" + escaped(entry->second) + "'", "use " + known});
}

std::size_t parameter_group(const FilterDesign& design, const std::vector<std::vector<std::string>>& groups) {
  const auto given = [&](const std::string& key) { return design.numbers.contains(key); };
  std::vector<std::string> all, found;
  std::string remedy;
  for (const auto& group : groups) {
    remedy += remedy.empty() ? "give " : ", or ";
    for (std::size_t i = 0; i < group.size(); ++i) {
      remedy += (i == 0 ? "" : i + 1 == group.size() ? " and " : ", ") + group[i];
      if (std::find(all.begin(), all.end(), group[i]) == all.end()) all.push_back(group[i]);
    }
  }
  std::copy_if(all.begin(), all.end(), std::back_inserter(found), given);
  for (std::size_t i = 0; i < groups.size(); ++i) {
    if (groups[i].size() == found.size() && std::all_of(groups[i].begin(), groups[i].end(), given)) return i;
  }
  std::string list;
  for (const std::string& key : found) list += (list.empty() ? "" : ", ") + key;
  throw Error(Fault{{},
                    found.empty() ? groups[0][0] : found.back(),
                    "these parameters do not define a filter",
                    found.empty() ? "none" : list,
                    remedy});
}

void check_derivative(const FilterDesign& design, int most, const std::string& rule) {
  if (design.derivative <= most) return;
  throw Error(
      Fault{{}, "derivative", rule, std::to_string(design.derivative), "use 0 to " + std::to_string(most)});
}

}  // namespace qerr
