#include "filter/design/families/prototype.hpp"

namespace qerr {

Section section_of_pole(ComplexDoubleDouble p, DoubleDouble scale) {
  if (p.im == DoubleDouble(0)) return {{1, 0, 0}, {1, -scale / p.re, 0}};
  const DoubleDouble n = norm(p);
  return {{1, 0, 0}, {1, DoubleDouble(-2) * p.re / n * scale, scale * scale / n}};
}

DoubleDouble prewarped_slope(double cutoff, double rate) {
  const Real x = pi256() * cutoff / rate;
  return to_double_double(cos(x) / sin(x));
}

DoubleDouble attenuated(double decibels) { return to_double_double(exp(-log(Real(10)) * decibels / 20)); }

Real asinh(const Real& x) { return log(x + sqrt(x * x + 1)); }

Filter bilinear_lowpass(const FilterDesign& wanted, const Prototype& prototype) {
  Filter filter = difference_filter(wanted.sample_rate, wanted.derivative);
  filter.designed = true;
  const DoubleDouble slope = prewarped_slope(checked_cutoff(wanted), wanted.sample_rate);
  filter.gain *= prototype.gain;
  std::size_t zeros = 0;
  for (const ComplexDoubleDouble& p : prototype.poles) {
    Section section = section_of_pole(p, slope);
    if (section.a[2].hi != 0 && zeros < prototype.zeros.size()) {
      const DoubleDouble over = slope / prototype.zeros[zeros++];
      section.b[2] = over * over;
    }
    filter.sections.push_back(section);
  }
  return filter;
}

}  // namespace qerr
