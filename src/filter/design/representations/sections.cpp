#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "filter/design/families/families.hpp"
#include "filter/design/representations/representations.hpp"

namespace qerr {
namespace {

constexpr std::size_t max_sections = 50;
constexpr double half_unit = 0.5 * std::numeric_limits<double>::epsilon();

using Triple = std::array<double, 3>;

double size_of(const Triple& c) { return std::abs(c[0]) + std::abs(c[1]) + std::abs(c[2]); }

/// The larger root modulus of a0 z^2 + a1 z + a2.
double largest_modulus(const Triple& a) {
  const DoubleDouble a0 = a[0], a1 = a[1], a2 = a[2];
  const DoubleDouble discriminant = a1 * a1 - DoubleDouble(4) * a0 * a2;
  if (discriminant < DoubleDouble(0)) return std::sqrt(static_cast<double>(a2 / a0));
  return static_cast<double>((abs(a1) + sqrt(discriminant)) / (DoubleDouble(2) * abs(a0)));
}

/// Whether all coefficients in w have the same sign by more than the rounding of `a`.
bool stable(const Section& s, const Triple& a) {
  const double sign = s.a[0].hi < 0 ? -1 : 1, rounding = half_unit * size_of(a);
  const int order = a[2] != 0 ? 2 : a[1] != 0 ? 1 : 0;
  for (int i = 0; i <= order; ++i) {
    if (!(sign * s.a[i].hi > rounding)) return false;
  }
  return true;
}

/// Moves zeros within the rounding of b of z = 1 to z = 1 (see divide_out_dc_zeros).
void move_zeros_to_dc(Section& s, const Triple& b) {
  const double rounding = half_unit * size_of(b);
  if (std::abs(s.b[0].hi) > rounding) return;
  s.b[0] = 0;
  if (std::abs(s.b[1].hi) <= 2 * rounding && s.b[2].hi != 0) s.b[1] = 0;
}

/// Whether the section in w equals the specified one without rounding.
bool exact(const std::array<DoubleDouble, 3>& c, const Triple& specified, bool second) {
  const Binary1024 c0 = specified[0], c1 = specified[1], c2 = specified[2];
  if (!second) return to_binary1024(c[0]) == c0 + c1 && to_binary1024(c[1]) == c0 - c1;
  return to_binary1024(c[0]) == c0 + c1 + c2 && to_binary1024(c[1]) == 2 * (c0 - c2) &&
         to_binary1024(c[2]) == c0 - c1 + c2;
}

struct SpecifiedSection {
  Triple b, a;
};

SpecifiedSection section_of(const std::vector<double>& row, const std::string& key) {
  if (row.size() != 6) {
    throw Error(key, "a section has six numbers", "a list of " + std::to_string(row.size()),
                "write [b0, b1, b2, a0, a1, a2]");
  }
  const Triple b{row[0], row[1], row[2]}, a{row[3], row[4], row[5]};
  if (a[0] == 0) throw Error(key, "a0 must not be 0", "0", "write [b0, b1, b2, 1, a1, a2]");
  if (!stable(section_in_w(b, a), a)) throw unstable(key, largest_modulus(a));
  return {b, a};
}

/// The product of the sections.
/// @param is_exact  set to whether no coefficient was rounded
Filter cascade(const std::vector<SpecifiedSection>& specified, double sample_rate, int derivative,
               bool zeros_at_dc, bool& is_exact) {
  Filter filter{{}, 1, sample_rate, derivative};
  is_exact = true;
  for (const auto& [b, a] : specified) {
    if (b[1] == 0 && b[2] == 0 && a[1] == 0 && a[2] == 0) {  // a constant factor
      filter.gain = filter.gain * DoubleDouble(b[0]) / DoubleDouble(a[0]);
      is_exact = false;
      continue;
    }
    Section s = section_in_w(b, a);
    if (zeros_at_dc) move_zeros_to_dc(s, b);
    const bool second = b[2] != 0 || a[2] != 0;
    is_exact = is_exact && exact(s.b, b, second) && exact(s.a, a, second);
    filter.sections.push_back(s);
  }
  if (filter.sections.empty()) filter.taps = {1};
  return filter;
}

Filter build(const std::map<std::string, Rows>& values, double sample_rate, int derivative) {
  return filter_from_sections(values.at("sos"), sample_rate, derivative);
}

}  // namespace

Filter filter_from_sections(const Rows& sos, double sample_rate, int derivative) {
  check_sample_rate(sample_rate);
  check_derivative(derivative);
  if (sos.empty() || sos.size() > max_sections) {
    throw Error("sos", "needs 1 to " + std::to_string(max_sections) + " sections", std::to_string(sos.size()),
                "write [[b0, b1, b2, a0, a1, a2], ...]");
  }
  check_finite(sos, "sos");
  std::vector<SpecifiedSection> specified;
  std::vector<Binary1024> b{1}, a{1};
  double modulus = 0;
  for (std::size_t i = 0; i < sos.size(); ++i) {
    specified.push_back(section_of(sos[i], "sos[" + std::to_string(i) + ']'));
    b = times(b, {specified[i].b.begin(), specified[i].b.end()});
    a = times(a, {specified[i].a.begin(), specified[i].a.end()});
    modulus = std::max(modulus, largest_modulus(specified[i].a));
  }
  // A filter that blocks 0 Hz up to the rounding of its coefficients is taken to block it, unless that
  // changes its norm.
  Filter filter;
  for (const bool zeros_at_dc : {true, false}) {
    bool is_exact = false;
    filter = cascade(specified, sample_rate, derivative, zeros_at_dc, is_exact);
    if (is_exact || set_deviation(filter, b, a, modulus, "sos")) break;
  }
  return filter;
}

FilterRepresentation sections_representation() {
  return {
      "second_order_sections",
      "in place of lowpass: sections as scipy.signal.sosfilt takes them",
      {.name = "sos", .kind = Kind::matrix, .meaning = "rows [b0, b1, b2, a0, a1, a2], ascending in z^-1"},
      {},
      {},
      build};
}

}  // namespace qerr
