#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "representations.hpp"

namespace qerr {
namespace {

constexpr std::size_t max_sections = 100;
constexpr double half_unit = 0.5 * std::numeric_limits<double>::epsilon();

using Triple = std::array<double, 3>;

double size_of(const Triple& c) { return std::abs(c[0]) + std::abs(c[1]) + std::abs(c[2]); }

/// The larger root modulus of a0 z^2 + a1 z + a2.
double largest_modulus(const Triple& a) {
  const Wide a0 = a[0], a1 = a[1], a2 = a[2];
  const Wide discriminant = a1 * a1 - Wide(4) * a0 * a2;
  if (discriminant < Wide(0)) return std::sqrt(static_cast<double>(a2 / a0));
  return static_cast<double>((abs(a1) + sqrt(discriminant)) / (Wide(2) * abs(a0)));
}

/// Stable beyond the rounding of the coefficients: in w all coefficients have one sign.
bool stable(const Section& s, const Triple& a) {
  const double sign = s.a[0].hi < 0 ? -1 : 1, doubt = half_unit * size_of(a);
  const int order = a[2] != 0 ? 2 : a[1] != 0 ? 1 : 0;
  for (int i = 0; i <= order; ++i) {
    if (!(sign * s.a[static_cast<std::size_t>(i)].hi > doubt)) return false;
  }
  return true;
}

/// 0.1 + 0.2 q - 0.3 q^2 is meant to block 0 Hz.
void put_zeros_at_dc(Section& s, const Triple& b) {
  const double doubt = half_unit * size_of(b);
  if (std::abs(s.b[0].hi) > doubt) return;
  s.b[0] = 0;
  if (std::abs(s.b[1].hi) <= 2 * doubt && s.b[2].hi != 0) s.b[1] = 0;
}

Section section_of(const std::vector<double>& row, const std::string& key) {
  if (row.size() != 6) {
    throw Error(Fault{{},
                      key,
                      "a section has six numbers",
                      "a list of " + std::to_string(row.size()),
                      "write [b0, b1, b2, a0, a1, a2]"});
  }
  const Triple b{row[0], row[1], row[2]}, a{row[3], row[4], row[5]};
  if (a[0] == 0) throw Error(Fault{{}, key, "a0 must not be 0", "0", "write [b0, b1, b2, 1, a1, a2]"});
  // A numerator longer than its denominator: the poles that are missing lie at z = 0.
  Section s = section_in_w(b, a);
  if (!stable(s, a)) throw unstable(key, largest_modulus(a));
  if (b[2] == 0 && a[2] == 0 && b[1] == 0 && a[1] == 0) s = {{b[0], 0, 0}, {a[0], 0, 0}};
  put_zeros_at_dc(s, b);
  return s;
}

Filter build(const std::map<std::string, Rows>& values, double sample_rate, int derivative) {
  return filter_from_sections(values.at("sos"), sample_rate, derivative);
}

}  // namespace

Filter filter_from_sections(const Rows& sos, double sample_rate, int derivative) {
  Filter filter = difference_filter(sample_rate, derivative);  // checks both
  filter.sections.clear();
  filter.gain = 1;
  if (sos.empty() || sos.size() > max_sections) {
    throw Error(Fault{{},
                      "sos",
                      "needs 1 to " + std::to_string(max_sections) + " sections",
                      std::to_string(sos.size()),
                      "write [[b0, b1, b2, a0, a1, a2], ...]"});
  }
  check_finite(sos, "sos");
  for (std::size_t i = 0; i < sos.size(); ++i) {
    Section s = section_of(sos[i], "sos[" + std::to_string(i) + ']');
    if (s.a[1].hi == 0) {  // a number
      filter.gain = filter.gain * s.b[0] / s.a[0];
    } else {
      filter.sections.push_back(s);
    }
  }
  if (filter.sections.empty()) filter.taps = {1};
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
