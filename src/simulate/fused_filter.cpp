#include "simulate/fused_filter.hpp"

#include <algorithm>
#include <cmath>

namespace qerr {

namespace {

/// Of what 1 less a factor must be at least, so that 12 digits of it remain.
constexpr double quickest = 0x1p-8;

/// The section of a plan, and what its output is to be multiplied with; none where digits would be lost.
struct Tightened {
  TightSection section;
  double gain;
};
std::optional<Tightened> tightened(const Section& s, bool low) {
  const auto plain = [](auto c) { return static_cast<double>(c); };
  const double a0 = plain(s.a[0]), a01 = a0 + plain(s.a[1]), b0 = plain(s.b[0]), b1 = plain(s.b[1]),
               b2 = plain(s.b[2]);
  const double inverse = 1 / (a01 + plain(s.a[2])), k0 = a0 * inverse, k1 = a01 * inverse;
  const double direct = b0 + b1 + b2;  // from an input to the output at the same sample
  if (!(k1 >= quickest) ||
      !(std::abs(direct) >= 0.125 * std::max({std::abs(b0), std::abs(b1), std::abs(b2)})))
    return {};
  if (plain(s.a[2]) == 0)
    return Tightened{{TightSection::Kind::first, 1 - 2 * k0, 0, (b0 - b1) / direct, 0}, inverse * direct};
  if (!(k0 >= quickest * quickest)) return {};
  const double e = 1 - 2 * k1 + 2 * k0;
  if (low) return Tightened{{TightSection::Kind::low, e, 4 * k0, 0, 0}, 4 * b0 * inverse};
  return Tightened{{TightSection::Kind::second, e, 4 * k0, (b1 - b0 - b2) / direct, 4 * b0 / direct},
                   inverse * direct};
}

bool is_low(const Section& s) { return s.a[2] != 0 && s.b[1] == 0 && s.b[2] == 0; }

/// Whether it is b1 (x[n] - x[n-1])/(2 a0).
bool is_difference(const Section& s) { return s.a[2] == 0 && s.a[0] == s.a[1] && s.b[0] == 0 && s.b[2] == 0; }

}  // namespace

/// Fills the plan. @returns whether the filter has one
bool TalliedFilter::tighten(const Filter& filter) {
  if (!filter.taps.empty()) return false;
  // Sections may change places.
  std::vector<Section> rest;
  gain_ = static_cast<double>(filter.gain);
  for (const Section& s : filter.sections) {
    if (is_difference(s)) {
      ++plan_.differences;
      gain_ *= static_cast<double>(s.b[1] / (2 * s.a[0]));
    } else {
      rest.push_back(s);
    }
  }
  if (rest.empty() || rest.size() > 2) return false;
  std::stable_sort(rest.begin(), rest.end(),
                   [](const Section& a, const Section& b) { return a.a[2] == 0 && b.a[2] != 0; });
  const bool low = rest.size() == 2 && std::all_of(rest.begin(), rest.end(), is_low);
  for (std::size_t i = 0; i < rest.size(); ++i) {
    const std::optional<Tightened> section = tightened(rest[i], low);
    if (!section) return false;
    plan_.sections[i] = section->section;
    gain_ *= section->gain;
  }
  TightSection &one = plan_.sections[0], &two = plan_.sections[1];
  if (one.kind == TightSection::Kind::first && two.kind == TightSection::Kind::first &&
      plan_.differences == 0) {
    if (two.a == -1) std::swap(one, two);
    if (one.a == -1 && two.a == 0) {
      one.kind = TightSection::Kind::rise;
      two.kind = TightSection::Kind::lag;
    }
  }
  return is_tight(plan_.differences, one.kind, two.kind);
}

TalliedFilter::TalliedFilter(const Filter& filter, std::size_t width, InstructionSet set)
    : width_(width), kernels_(select_kernels<SimulationKernels>(set)) {
  if (tighten(filter)) {
    state_ = AlignedNumbers(static_cast<std::size_t>(4 + plan_.differences) * width);
    numbers_ = AlignedNumbers(4 * width);
    double* const n = numbers_.data();
    nowhere_ = {n, n + width, n + 2 * width, n + 3 * width};
  } else {
    slow_.emplace(filter, width, rows_at_once, set);
    numbers_ = AlignedNumbers(rows_at_once * width);
  }
}

void TalliedFilter::settle(const double* row) {
  if (slow_) return slow_->settle(row);
  for (std::size_t c = 0; c < width_; ++c) {
    double x = row[c];
    double* state = state_.data() + c;
    for (int d = 0; d < plan_.differences; ++d, x = 0) state[static_cast<std::size_t>(4 + d) * width_] = x;
    for (const TightSection& s : plan_.sections) {
      if (s.kind == TightSection::Kind::none) break;
      // Nothing changes: s' = s and r' = r.
      const bool second = s.kind == TightSection::Kind::second || s.kind == TightSection::Kind::low;
      const double at_rest = second ? 0 : x / (1 - s.e), r = second ? x / s.k : 0;
      state[0] = at_rest;
      state[width_] = r;
      x = second ? (s.kind == TightSection::Kind::low ? r : s.b * r) : (1 + s.a) * at_rest;
      state += 2 * width_;
    }
  }
}

void TalliedFilter::through_sections(const double* in, std::size_t stride, std::size_t rows,
                                     std::size_t peaks, const RunStatistics::Place& place) {
  kernels_.filter_and_tally(plan_, in, stride, rows, width_, peaks, place.fresh, state_.data(), *place.tally);
}

void TalliedFilter::slowly(const double* in, std::size_t stride, std::size_t rows, std::uint64_t block,
                           RunStatistics* to) {
  for (std::size_t from = 0; from < rows; from += rows_at_once) {
    const std::size_t count = std::min(rows_at_once, rows - from);
    (*slow_)(in + from * stride, stride, count, numbers_.data());
    if (to) to->add(numbers_.data(), width_, count, block);
  }
}

void TalliedFilter::pass(const double* in, std::size_t stride, std::size_t rows) {
  if (slow_) return slowly(in, stride, rows, 0, nullptr);
  through_sections(in, stride, rows, 0, {&nowhere_, false});
}

void TalliedFilter::tally(const double* in, std::size_t stride, std::size_t rows, std::uint64_t block,
                          RunStatistics& to) {
  if (!slow_) return through_sections(in, stride, rows, to.peaks(), to.place_of_rows(rows, block, gain_));
  slowly(in, stride, rows, block, &to);
}

}  // namespace qerr
