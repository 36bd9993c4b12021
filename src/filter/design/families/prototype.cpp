#include "filter/design/families/prototype.hpp"

#include <cmath>
#include <numbers>

namespace qerr {

Section section_of_pole(ComplexDoubleDouble p, double slope) {
  const DoubleDouble scale = slope;
  if (p.im == DoubleDouble(0)) return {{1, 0, 0}, {1, -scale / p.re, 0}};
  const DoubleDouble n = norm(p);
  return {{1, 0, 0}, {1, DoubleDouble(-2) * p.re / n * scale, scale * scale / n}};
}

Filter bilinear_lowpass(const FilterDesign& wanted, const Prototype& prototype) {
  Filter filter = difference_filter(wanted.sample_rate, wanted.derivative);
  filter.designed = true;
  const double slope = 1 / std::tan(std::numbers::pi * checked_cutoff(wanted) / wanted.sample_rate);
  filter.gain *= prototype.gain;
  std::size_t zeros = 0;
  for (const ComplexDoubleDouble& p : prototype.poles) {
    Section section = section_of_pole(p, slope);
    if (section.a[2].hi != 0 && zeros < prototype.zeros.size()) {
      const DoubleDouble over = DoubleDouble(slope) / prototype.zeros[zeros++];
      section.b[2] = over * over;
    }
    filter.sections.push_back(section);
  }
  return filter;
}

}  // namespace qerr
