#include "filter/norms/direct_sum.hpp"

#include <algorithm>
#include <cmath>

#include "filter/design/rational.hpp"
#include "filter/norms/ball.hpp"
#include "filter/norms/lifted_norm.hpp"

namespace qerr {
namespace {

/// ||.||_1 <= (sum r^2k)^(1/2) ||lifted||_2, r = 1/(1 + lift).
double l1_bound(const Filter& filter, double lift) {
  return lifted_norm(filter, lift) * (1 + lift) / std::sqrt(lift * (2 + lift)) * (1 + 0x1p-40);
}

/// The filter that leads from a disturbance of a stage to the output: numerator n over the stage's
/// denominator, times the stages behind it.
Filter path(const Filter& filter, std::size_t stage, const std::array<DoubleDouble, 3>& n) {
  Filter p{{filter.sections.begin() + static_cast<std::ptrdiff_t>(stage), filter.sections.end()}, 1, 1, 0};
  p.sections.front().b = n;
  return p;
}

/// (1 - w)/2 times c0 + c1 w.
std::array<DoubleDouble, 3> halved(DoubleDouble c0, DoubleDouble c1) {
  const DoubleDouble half(0.5);
  return {c0 * half, (c1 - c0) * half, -c1 * half};
}

/// Small for a section with a slow pole.
double slow_share(const Section& s) {
  return std::abs(s.a[0].hi) / (std::abs(s.a[0].hi) + std::abs(s.a[1].hi) + std::abs(s.a[2].hi));
}

double size(const DoubleDouble& x) { return std::abs(x.hi); }

}  // namespace

// A stage solves a2 high + a1 band + a0 low = x with band = high + s1, low = band + s2 and moves its states
// to s1 + 2 high, s2 + 2 band (BasicCascade). With w-transforms, a disturbance e1 of s1 is an extra (1 -
// w)/(2w) e1 in band = high/w, one of s2 the same in low = band/w. Solved for y = b0 low + b1 band + b2 high:
//   e1:  (1 - w)/2 [b0 a2 + b1 a2 w - b2 (a0 + a1 w)]/a,   e2:  (1 - w)/2 [b0 (a1 + a2 w) - (b1 + b2 w)
//   a0]/a,
// and a disturbance e of `high` is one of x by (a0 + a1 + a2) e. First order is the same with a single state:
// a1 high + a0 low = x, low = high + s1, which gives (1 - w)/2 [b0 a1 - b1 a0]/a.
DirectSum::DirectSum(const Filter& given, double lift)
    : gain_(given.gain), lift_(lift), lifted_(lifted_norm(given, lift)) {
  // Low-passes first: differences first would pass on the rounding of numbers that the low-passes then
  // reduce.
  Filter filter = given;
  std::stable_sort(filter.sections.begin(), filter.sections.end(),
                   [](const Section& x, const Section& y) { return slow_share(x) < slow_share(y); });
  for (std::size_t i = 0; i < filter.sections.size(); ++i) {
    const Section& s = filter.sections[i];
    Stage t;
    t.second = order_of(s) == 2;
    t.b0 = s.b[0], t.b1 = s.b[1], t.b2 = s.b[2], t.a0 = s.a[0], t.a01 = s.a[0] + s.a[1];
    const DoubleDouble all = t.a01 + s.a[2];
    t.inverse = DoubleDouble(1) / all;
    t.from_input = l1_bound(path(filter, i, s.b), lift);
    t.from_output =
        i + 1 < filter.sections.size() ? l1_bound(path(filter, i + 1, filter.sections[i + 1].b), lift) : 1;
    if (t.second) {
      t.from_first = l1_bound(
          path(filter, i, halved(s.b[0] * s.a[2] - s.b[2] * s.a[0], s.b[1] * s.a[2] - s.b[2] * s.a[1])),
          lift);
      t.from_second = l1_bound(
          path(filter, i, halved(s.b[0] * s.a[1] - s.b[1] * s.a[0], s.b[0] * s.a[2] - s.b[2] * s.a[0])),
          lift);
    } else {
      const DoubleDouble c = (s.b[0] * s.a[1] - s.b[1] * s.a[0]) * DoubleDouble(0.5);
      t.from_first = l1_bound(path(filter, i, {c, -c, 0}), lift);
    }
    stages_.push_back(t);
  }
}

double DirectSum::tail(std::int64_t from) const {
  return lifted_ * (1 + lift_) / std::sqrt(lift_ * (2 + lift_)) *
         std::exp(-std::log1p(lift_) * (1 - 1e-14) * static_cast<double>(from)) * 1.0001;
}

/// Every rounding is charged with `unit` times its result, summed over the run and sent to the output by the
/// bounds above. Coefficients are rounded too, so a product is charged twice. Of `high`, counted as input:
/// two products, two sums, and the inverse with its product, 6 (|x| + |u| + |v|) at most. The rounding of
/// band goes to the first state once and to the second twice, to the output by b0 and b1; that of low to the
/// second state and to the output by b0. The output takes up to 5 of each product.
PartialSum DirectSum::sum(std::int64_t count) const {
  constexpr double unit = Rounding<DoubleDouble>::unit;
  struct State {
    bool second;
    DoubleDouble b0, b1, b2, a0, a01, inverse, s1{}, s2{};
    double high_size = 0, first_size = 0, second_size = 0, output_size = 0;
  };
  std::vector<State> states;
  for (const Stage& t : stages_) states.push_back({t.second, t.b0, t.b1, t.b2, t.a0, t.a01, t.inverse});
  DoubleDouble total{}, x = gain_;
  double total_size = 0;
  for (std::int64_t k = 0; k < count; ++k) {
    for (State& s : states) {
      if (s.second) {
        const DoubleDouble u = s.a01 * s.s1, v = s.a0 * s.s2;
        const DoubleDouble high = (x - u - v) * s.inverse;
        s.high_size += size(x) + size(u) + size(v);
        const DoubleDouble band = high + s.s1, low = band + s.s2;
        s.s1 = band + high;
        s.s2 = low + band;
        s.first_size += size(band) + size(s.s1);
        s.second_size += 2 * size(band) + size(low) + size(s.s2);
        const DoubleDouble y0 = s.b0 * low, y1 = s.b1 * band, y2 = s.b2 * high;
        s.output_size += size(y0) + size(y1) + size(y2) + size(s.b0) * size(band);
        x = y0 + y1 + y2;
      } else {
        const DoubleDouble u = s.a0 * s.s1;
        const DoubleDouble high = (x - u) * s.inverse, low = high + s.s1;
        s.high_size += size(x) + size(u);
        s.s1 = low + high;
        s.first_size += size(low) + size(s.s1);
        const DoubleDouble y0 = s.b0 * low, y1 = s.b1 * high;
        s.output_size += size(y0) + size(y1);
        x = y0 + y1;
      }
    }
    total += abs(x);
    total_size += size(total);
    x = DoubleDouble(0);
  }
  double error = total_size;
  for (std::size_t i = 0; i < states.size(); ++i) {
    const State& s = states[i];
    const Stage& t = stages_[i];
    error += 8 * s.high_size * t.from_input + s.first_size * t.from_first + s.second_size * t.from_second +
             5 * s.output_size * t.from_output;
  }
  const auto rounded = static_cast<double>(total);
  return {rounded, unit * error * 1.01 + (unit + 0x1p-53) * rounded + 1e-290};
}

}  // namespace qerr
