#include "simulate/fused_filter.hpp"

#include <algorithm>
#include <cmath>

namespace qerr {

namespace {

/// Least k1, the decay of s per sample: 1 - 2 k1 keeps 12 digits of it or more.
constexpr double least_decay = 0x1p-8;

/// A section of a plan, and the gain of its output; empty where it would lose digits.
struct ScaledSection {
  FusedSection section;
  double gain;
};
std::optional<ScaledSection> fused(const Section& s, bool low) {
  const auto plain = [](auto c) { return static_cast<double>(c); };
  const double a0 = plain(s.a[0]), a01 = a0 + plain(s.a[1]), b0 = plain(s.b[0]), b1 = plain(s.b[1]),
               b2 = plain(s.b[2]);
  const double inverse = 1 / (a01 + plain(s.a[2])), k0 = a0 * inverse, k1 = a01 * inverse;
  const double direct = b0 + b1 + b2;  // from an input to the output at the same sample
  if (!(k1 >= least_decay) ||
      !(std::abs(direct) >= 0.125 * std::max({std::abs(b0), std::abs(b1), std::abs(b2)})))
    return {};
  if (plain(s.a[2]) == 0)
    return ScaledSection{{FusedSection::Kind::first, 1 - 2 * k0, 0, (b0 - b1) / direct, 0}, inverse * direct};
  if (!(k0 >= least_decay * least_decay)) return {};
  const double e = 1 - 2 * k1 + 2 * k0;
  if (low) return ScaledSection{{FusedSection::Kind::low, e, 4 * k0, 0, 0}, 4 * b0 * inverse};
  return ScaledSection{{FusedSection::Kind::second, e, 4 * k0, (b1 - b0 - b2) / direct, 4 * b0 / direct},
                       inverse * direct};
}

bool is_low(const Section& s) { return s.a[2] != 0 && s.b[1] == 0 && s.b[2] == 0; }

/// Whether it is b1 (x[n] - x[n-1])/(2 a0).
bool is_difference(const Section& s) { return s.a[2] == 0 && s.a[0] == s.a[1] && s.b[0] == 0 && s.b[2] == 0; }

}  // namespace

/// Fills the plan. @returns whether the filter is fusible
bool FusedFilter::fuse(const Filter& filter) {
  if (!filter.taps.empty()) return false;
  // The order of sections is free.
  std::vector<Section> sections;
  gain_ = static_cast<double>(filter.gain);
  for (const Section& s : filter.sections) {
    if (is_difference(s)) {
      ++plan_.differences;
      gain_ *= static_cast<double>(s.b[1] / (2 * s.a[0]));
    } else {
      sections.push_back(s);
    }
  }
  if (sections.empty() || sections.size() > 2) return false;
  std::stable_sort(sections.begin(), sections.end(),
                   [](const Section& a, const Section& b) { return a.a[2] == 0 && b.a[2] != 0; });
  const bool low = sections.size() == 2 && std::all_of(sections.begin(), sections.end(), is_low);
  for (std::size_t i = 0; i < sections.size(); ++i) {
    const std::optional<ScaledSection> section = fused(sections[i], low);
    if (!section) return false;
    plan_.sections[i] = section->section;
    gain_ *= section->gain;
  }
  FusedSection &one = plan_.sections[0], &two = plan_.sections[1];
  if (one.kind == FusedSection::Kind::first && two.kind == FusedSection::Kind::first &&
      plan_.differences == 0) {
    if (two.a == -1) std::swap(one, two);
    if (one.a == -1 && two.a == 0) {
      one.kind = FusedSection::Kind::rise;
      two.kind = FusedSection::Kind::lag;
    }
  }
  return is_fusible(plan_.differences, one.kind, two.kind);
}

FusedFilter::FusedFilter(const Filter& filter, std::size_t width, InstructionSet set)
    : width_(width), kernels_(select_kernels<SimulationKernels>(set)) {
  if (fuse(filter)) {
    state_ = AlignedNumbers(static_cast<std::size_t>(4 + plan_.differences) * width);
    buffer_ = AlignedNumbers(4 * width);
    double* const n = buffer_.data();
    dropped_ = {n, n + width, n + 2 * width, n + 3 * width};
  } else {
    rows_.emplace(filter, width, rows_at_once, set);
    buffer_ = AlignedNumbers(rows_at_once * width);
  }
}

void FusedFilter::settle(const double* row) {
  if (rows_) return rows_->settle(row);
  for (std::size_t c = 0; c < width_; ++c) {
    double x = row[c];
    double* state = state_.data() + c;
    for (int d = 0; d < plan_.differences; ++d, x = 0) state[static_cast<std::size_t>(4 + d) * width_] = x;
    for (const FusedSection& s : plan_.sections) {
      if (s.kind == FusedSection::Kind::none) break;
      // Steady state: s' = s and r' = r.
      const bool second = s.kind == FusedSection::Kind::second || s.kind == FusedSection::Kind::low;
      const double steady = second ? 0 : x / (1 - s.e), r = second ? x / s.k : 0;
      state[0] = steady;
      state[width_] = r;
      x = second ? (s.kind == FusedSection::Kind::low ? r : s.b * r) : (1 + s.a) * steady;
      state += 2 * width_;
    }
  }
}

void FusedFilter::run_fused(const double* in, std::size_t stride, std::size_t rows, std::size_t peaks,
                            const RunStatistics::Place& place) {
  kernels_.filter_and_tally(plan_, in, stride, rows, width_, peaks, place.fresh, state_.data(), *place.tally);
}

void FusedFilter::run_rows(const double* in, std::size_t stride, std::size_t rows, std::uint64_t block,
                           RunStatistics* to) {
  for (std::size_t from = 0; from < rows; from += rows_at_once) {
    const std::size_t count = std::min(rows_at_once, rows - from);
    (*rows_)(in + from * stride, stride, count, buffer_.data());
    if (to) to->add(buffer_.data(), width_, count, block);
  }
}

void FusedFilter::pass(const double* in, std::size_t stride, std::size_t rows) {
  if (rows_) return run_rows(in, stride, rows, 0, nullptr);
  run_fused(in, stride, rows, 0, {&dropped_, false});
}

void FusedFilter::tally(const double* in, std::size_t stride, std::size_t rows, std::uint64_t block,
                        RunStatistics& to) {
  if (!rows_) return run_fused(in, stride, rows, to.peaks(), to.place_of_rows(rows, block, gain_));
  run_rows(in, stride, rows, block, &to);
}

}  // namespace qerr
