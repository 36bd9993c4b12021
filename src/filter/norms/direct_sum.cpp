#include "filter/norms/direct_sum.hpp"

#include <algorithm>
#include <cmath>

#include "filter/norms/ball.hpp"
#include "filter/norms/lifted_norm.hpp"
#include "filter/norms/rational.hpp"

namespace qerr {
namespace {

/// ||.||_1 <= (sum r^2k)^(1/2) ||lifted||_2, r = 1/(1 + lift).
double l1_bound(const Filter& filter, double lift) {
  return lifted_norm(filter, lift) * (1 + lift) / std::sqrt(lift * (2 + lift)) * (1 + 0x1p-40);
}

/// From a disturbance of section i to the output: `numerator` over the section's denominator, times the
/// sections after it.
Filter path(const Filter& filter, std::size_t i, const std::array<DoubleDouble, 3>& numerator) {
  Filter p{{filter.sections.begin() + static_cast<std::ptrdiff_t>(i), filter.sections.end()}, 1, 1, 0};
  p.sections.front().b = numerator;
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

/// The filter with its sections ordered by speed: after differences, low-passes would reduce numbers whose
/// rounding has been passed on already.
Filter low_passes_first(Filter filter) {
  std::stable_sort(filter.sections.begin(), filter.sections.end(),
                   [](const Section& x, const Section& y) { return slow_share(x) < slow_share(y); });
  return filter;
}

double size(const DoubleDouble& x) { return std::abs(x.hi); }

}  // namespace

// With the signals times S = a0 + a1 + a2, as a NormalizedSection has them, and B = b S of its output factors
// b, a section solves a2 high + a1 band + a0 low = S x with band = high + s1, low = band + s2, and moves its
// states to s1 + 2 high, s2 + 2 band. With w-transforms, a disturbance e1 of s1 adds (1 - w)/(2w) e1 to band
// = high/w, one of s2 the same to low = band/w. Solved for y = b0 low + b1 band + b2 high:
//   e1:  (1 - w)/2 [B0 a2 + B1 a2 w - B2 (a0 + a1 w)]/(a S)
//   e2:  (1 - w)/2 [B0 (a1 + a2 w) - (B1 + B2 w) a0]/(a S),
// and a disturbance of `high` is one of x. First order is the same with a single state: a1 high + a0 low = S
// x, low = high + s1, which gives (1 - w)/2 [B0 a1 - B1 a0]/(a S).
DirectSum::DirectSum(const Filter& given, double lift) : lift_(lift), lifted_(lifted_norm(given, lift)) {
  Filter filter = low_passes_first(given);
  plan_ = filter_plan<DoubleDouble>(filter);
  filter.gain = 1;
  std::vector<double> scale;  // 1/S
  for (std::size_t i = 0; i < filter.sections.size(); ++i) {
    Section& s = filter.sections[i];
    const NormalizedSection<DoubleDouble>& n = plan_.sections[i];
    const DoubleDouble all = s.a[0] + s.a[1] + s.a[2];
    s.b = {n.b0 * all, n.b1 * all, n.b2 * all};
    scale.push_back((1 + 0x1p-40) / std::abs(all.hi));
  }
  for (std::size_t i = 0; i < filter.sections.size(); ++i) {
    const Section& s = filter.sections[i];
    Sensitivity& t = sensitivity_.emplace_back();
    const auto bound = [&](const std::array<DoubleDouble, 3>& n) {
      return l1_bound(path(filter, i, n), lift);
    };
    t.input = bound(s.b);
    t.output =
        i + 1 < filter.sections.size() ? l1_bound(path(filter, i + 1, filter.sections[i + 1].b), lift) : 1;
    if (order_of(s) == 2) {
      t.first_state =
          scale[i] * bound(halved(s.b[0] * s.a[2] - s.b[2] * s.a[0], s.b[1] * s.a[2] - s.b[2] * s.a[1]));
      t.second_state =
          scale[i] * bound(halved(s.b[0] * s.a[1] - s.b[1] * s.a[0], s.b[0] * s.a[2] - s.b[2] * s.a[0]));
    } else {
      const DoubleDouble c = (s.b[0] * s.a[1] - s.b[1] * s.a[0]) * DoubleDouble(0.5);
      t.first_state = scale[i] * bound({c, -c, 0});
    }
  }
}

double DirectSum::tail(std::int64_t from) const {
  return lifted_ * (1 + lift_) / std::sqrt(lift_ * (2 + lift_)) *
         std::exp(-std::log1p(lift_) * (1 - 1e-14) * static_cast<double>(from)) * 1.0001;
}

/// Each rounding is charged with `unit` times its result, summed over the run and carried to the output by
/// the sensitivities. `unit` is 1.6 times the error of an operation. Of `high`, counted as input: 5
/// operations in the coefficient k1, 4 in k0, 2 products and 2 sums are at most 8 operations of |x| + |u| +
/// |v|. The rounding of band goes to the second state twice and to the output by b0 and b1; that of low to
/// the second state and to the output by b0. The output takes up to 5 of each product. The gain that the last
/// section carries is made by at most 6 operations per section.
PartialSum DirectSum::sum(std::int64_t count) const {
  constexpr double unit = RoundingErrors<DoubleDouble>::unit;
  struct Run {
    SectionState<DoubleDouble> state;
    double high = 0, first_state = 0, second_state = 0, output = 0;  // sums of sizes
  };
  std::vector<Run> runs(plan_.sections.size());
  DoubleDouble total{}, x = 1;
  double total_size = 0;
  for (std::int64_t k = 0; k < count; ++k) {
    for (std::size_t i = 0; i < runs.size(); ++i) {
      const NormalizedSection<DoubleDouble>& s = plan_.sections[i];
      Run& r = runs[i];
      r.high += size(x);
      if (s.second) {
        r.high += size(s.k1) * size(r.state.s1) + size(s.k0) * size(r.state.s2);
        const auto u = advance<true>(s.k0, s.k1, x, r.state);
        r.first_state += size(u.band) + size(r.state.s1);
        r.second_state += 2 * size(u.band) + size(u.low) + size(r.state.s2);
        r.output +=
            size(s.b0) * (size(u.low) + size(u.band)) + size(s.b1) * size(u.band) + size(s.b2) * size(u.high);
        x = output<true>(s.b0, s.b1, s.b2, u);
      } else {
        r.high += size(s.k0) * size(r.state.s1);
        const auto u = advance<false>(s.k0, s.k1, x, r.state);
        r.first_state += size(u.low) + size(r.state.s1);
        r.output += size(s.b0) * size(u.low) + size(s.b1) * size(u.high);
        x = output<false>(s.b0, s.b1, s.b2, u);
      }
    }
    total += abs(x);
    total_size += size(total);
    x = DoubleDouble(0);
  }
  const auto rounded = static_cast<double>(total);
  double error = total_size + 6 * static_cast<double>(runs.size()) * rounded;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const Sensitivity& t = sensitivity_[i];
    error += 8 * runs[i].high * t.input + runs[i].first_state * t.first_state +
             runs[i].second_state * t.second_state + 5 * runs[i].output * t.output;
  }
  return {rounded, unit * error * 1.01 + (unit + 0x1p-53) * rounded + 1e-290};
}

}  // namespace qerr
