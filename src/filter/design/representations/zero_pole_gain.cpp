#include <algorithm>
#include <cmath>
#include <limits>

#include "filter/design/families/families.hpp"
#include "filter/design/representations/representations.hpp"

namespace qerr {
namespace {

constexpr std::size_t max_poles = 100;
constexpr double unit = std::numeric_limits<double>::epsilon();

using Root = std::array<double, 2>;

Root root_of(const std::vector<double>& row, const std::string& key) {
  if (row.size() == 1) return {row[0], 0};
  if (row.size() == 2) return {row[0], row[1]};
  throw Error(key, "must be a number, or a pair for a complex number",
              "a list of " + std::to_string(row.size()), "write 0.9 or [0.9, 0.1]");
}

/// Real roots and, of each conjugate pair, the upper one.
std::vector<Root> paired(const Rows& rows, const std::string& key) {
  std::vector<Root> all, result;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    all.push_back(root_of(rows[i], key + '[' + std::to_string(i) + ']'));
  }
  std::vector<bool> used(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto [re, im] = all[i];
    if (im == 0) result.push_back(all[i]);
    if (im == 0 || used[i]) continue;
    const double near = 100 * unit * std::hypot(re, im);  // as scipy.signal.cplxpair
    std::size_t j = i + 1;
    while (j < all.size() && (used[j] || std::hypot(all[j][0] - re, all[j][1] + im) > near)) ++j;
    if (j == all.size()) {
      throw Error(key + '[' + std::to_string(i) + ']', "the conjugate of a complex number is missing",
                  "[" + figure(re) + ", " + figure(im) + "]",
                  "add [" + figure(re) + ", " + figure(-im) + "]");
    }
    used[j] = true;
    result.push_back({0.5 * (re + all[j][0]), 0.5 * std::abs(im - all[j][1])});
  }
  return result;
}

/// z - r over 1/(1 - w): (1 - r) + (1 + r) w.
LinearFactor factor_of(const Root& r) {
  return {{Binary1024(1) - r[0], Binary1024(-r[1])}, {Binary1024(1) + r[0], Binary1024(r[1])}};
}

/// The roots, with those that are within rounding of 1 at 1.
std::vector<Root> rounded_to_dc(std::vector<Root> roots) {
  for (Root& r : roots)
    if (std::hypot(r[0] - 1, r[1]) <= unit) r = {1, 0};
  return roots;
}

DoubleDouble distance_from_circle(const Root& r) {  // 1 - |r|^2
  return DoubleDouble(1) - DoubleDouble(r[0]) * DoubleDouble(r[0]) - DoubleDouble(r[1]) * DoubleDouble(r[1]);
}

/// prod(1 - r z^-1), ascending.
std::vector<Binary1024> expanded(const std::vector<Root>& roots) {
  std::vector<Binary1024> p{1};
  for (const auto& [re, im] : roots) {
    const Binary1024 x = re, y = im;
    p = times(p,
              im == 0 ? std::vector<Binary1024>{1, -x} : std::vector<Binary1024>{1, -2 * x, x * x + y * y});
  }
  return p;
}

/// @returns the largest modulus
/// @throws Error (input; key `poles[index]`) when a pole is not inside the unit circle
double check_stable(const Rows& poles) {
  double largest = 0;
  std::size_t worst = 0;
  bool bad = false;
  for (std::size_t i = 0; i < poles.size(); ++i) {
    const Root r = root_of(poles[i], "poles[" + std::to_string(i) + ']');
    const double modulus = std::hypot(r[0], r[1]);
    if (!(distance_from_circle(r).hi > 2 * unit)) bad = true;
    if (modulus > largest) worst = i;
    largest = std::max(largest, modulus);
  }
  if (bad) throw unstable("poles[" + std::to_string(worst) + ']', largest);
  return largest;
}

Filter build(const std::map<std::string, Rows>& values, double sample_rate, int derivative) {
  const auto rows = [&](const char* key) { return values.contains(key) ? values.at(key) : Rows{}; };
  const double gain = values.contains("gain") ? values.at("gain")[0][0] : 1.0;
  return filter_from_zeros_and_poles(rows("zeros"), rows("poles"), gain, sample_rate, derivative);
}

}  // namespace

Filter filter_from_zeros_and_poles(const Rows& zeros, const Rows& poles, double gain, double sample_rate,
                                   int derivative) {
  check_sample_rate(sample_rate);
  check_derivative(derivative);
  check_finite(zeros, "zeros");
  check_finite(poles, "poles");
  check_finite({{gain}}, "gain");
  if (zeros.size() > poles.size() || poles.size() > max_poles) {
    const bool many = poles.size() > max_poles;
    throw Error(many ? "poles" : "zeros",
                many ? "too many poles" : "a causal filter has no more zeros than poles",
                std::to_string(zeros.size()) + " zeros, " + std::to_string(poles.size()) + " poles",
                many ? "use at most " + std::to_string(max_poles) : "poles at z = 0 are written as 0");
  }
  const double largest = check_stable(poles);
  if (gain == 0) return {{}, 1, sample_rate, derivative, {0}};
  const std::vector<Root> pole_roots = paired(poles, "poles"), exact_zeros = paired(zeros, "zeros");
  std::vector<LinearFactor> below;
  for (const Root& r : pole_roots) below.push_back(factor_of(r));
  std::vector<Binary1024> delay(poles.size() - zeros.size() + 1);
  delay.back() = gain;
  const std::vector<Binary1024> numerator = times(delay, expanded(exact_zeros)),
                                denominator = expanded(pole_roots);
  // A zero within its rounding of z = 1 is taken to be there, unless that changes the filter's norm.
  Filter filter;
  for (const std::vector<Root>& zero_roots : {rounded_to_dc(exact_zeros), exact_zeros}) {
    std::vector<LinearFactor> above;
    for (const Root& r : zero_roots) above.push_back(factor_of(r));
    // Fewer zeros than poles: the others are at z = infinity, z^-1 = (1 - w)/(1 + w).
    for (std::size_t i = zeros.size(); i < poles.size(); ++i) above.push_back({1.0, -1.0});
    filter = filter_from_factors(gain, above, below, sample_rate, derivative);
    if (set_deviation(filter, numerator, denominator, largest, "poles")) break;
  }
  return filter;
}

FilterRepresentation zero_pole_gain_representation() {
  return {"zero_pole_gain",
          "in place of lowpass: gain prod(z - zero)/prod(z - pole), as scipy.signal.zpk2sos takes them",
          key::object("zpk", "zeros, poles and gain in the z plane"),
          {{.name = "zeros", .kind = Kind::matrix, .meaning = "numbers, or pairs [re, im] for complex ones"},
           {.name = "poles", .kind = Kind::matrix, .meaning = "numbers, or pairs [re, im] for complex ones"},
           key::number("gain", "factor of the transfer function").otherwise(1.0)},
          {},
          build};
}

}  // namespace qerr
