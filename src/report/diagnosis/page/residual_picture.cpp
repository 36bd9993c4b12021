#include "report/diagnosis/page/residual_picture.hpp"

#include <algorithm>
#include <cmath>

#include "core/statistics.hpp"
#include "report/page/envelope.hpp"

namespace qerr {

namespace {

using Points = ResidualPicture::Points;

/// Least and largest residual over time, or over the row if the record has no order.
void draw_in_time(const JointResidual& r, std::size_t intervals, ResidualPicture& p) {
  const Evidence& e = r.evidence;
  const Eigen::Index last = e.rows() - 1;
  page::Envelope before(e.time[0], e.time[last], intervals), after = before;
  for (Eigen::Index k = 0; k <= last; ++k) before.add(e.time[k], r.before[k]);
  for (Eigen::Index k = 0; p.corrected && k <= last; ++k) after.add(e.time[k], r.after[k]);
  p.before = before.points();
  if (p.corrected) p.after = after.points();
}

/// IntervalMeans in equal intervals.
class IntervalMeans {
 public:
  IntervalMeans(double from, double to, std::size_t intervals)
      : from_(from),
        per_unit_(static_cast<double>(intervals) / (to - from)),
        sums_(intervals),
        counts_(intervals) {}

  void add(double x, double y) {
    const auto i = std::min(sums_.size() - 1, static_cast<std::size_t>((x - from_) * per_unit_));
    sums_[i] += y, counts_[i] += 1;
  }
  Points points() const {
    Points all;
    for (std::size_t i = 0; i < sums_.size(); ++i)
      if (counts_[i] > 0)
        all.emplace_back(from_ + (static_cast<double>(i) + 0.5) / per_unit_, sums_[i] / counts_[i]);
    return all;
  }

 private:
  double from_, per_unit_;
  std::vector<double> sums_, counts_;
};

void draw_by_position(const JointResidual& r, std::size_t intervals, ResidualPicture& p) {
  const Evidence& e = r.evidence;
  const double from = e.reference.minCoeff(), to = e.reference.maxCoeff();
  if (!(to > from)) return;
  const page::Envelope none(from, to, intervals);
  std::array before{none, none, none}, after = before;
  const IntervalMeans no_rows(from, to, intervals);
  std::array fit{no_rows, no_rows, no_rows};
  for (Eigen::Index k = 0; k < e.rows(); ++k) {
    const double direction = e.direction.size() > 0 ? e.direction[k] : 0;
    const std::size_t side = direction > 0 ? 0 : direction < 0 ? 1 : 2;
    before[side].add(e.reference[k], r.before[k]);
    if (!p.corrected) continue;
    after[side].add(e.reference[k], r.after[k]);
    fit[side].add(e.reference[k], r.before[k] - r.after[k]);
  }
  for (std::size_t side = 0; side < p.sides.size(); ++side)
    p.sides[side] = {before[side].points(), after[side].points(), fit[side].points()};
}

void draw_by_count(const JointResidual& r, ResidualPicture& p) {
  const Evidence& e = r.evidence;
  if (e.measured.maxCoeff() - e.measured.minCoeff() < count_cycle * p.resolution) return;
  std::array<double, count_cycle> before{}, after{}, readings{};
  for (Eigen::Index k = 0; k < e.rows(); ++k) {
    const double count = std::round(e.measured[k] / p.resolution);
    const auto i = static_cast<std::size_t>(count - count_cycle * std::floor(count / count_cycle));
    before[i] += r.before[k], after[i] += r.after[k], readings[i] += 1;
  }
  for (std::size_t i = 0; i < count_cycle; ++i) {
    if (readings[i] == 0) continue;
    p.by_count_before.emplace_back(i, before[i] / readings[i]);
    if (p.corrected) p.by_count_after.emplace_back(i, after[i] / readings[i]);
  }
}

/// The largest amplitude in each of equal intervals of the order's logarithm.
Points peaks(const std::vector<double>& order, const std::vector<double>& amplitude, std::size_t intervals) {
  const double from = std::log(order.front()),
               width = (std::log(order.back()) - from) / static_cast<double>(intervals);
  Points all;
  double end = -INFINITY;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (std::log(order[i]) >= end) {
      end = from + width * (std::floor((std::log(order[i]) - from) / width) + 1);
      all.emplace_back(order[i], amplitude[i]);
    } else if (amplitude[i] > all.back().second) {
      all.back() = {order[i], amplitude[i]};
    }
  }
  return all;
}

void draw_spectrum(const JointResidual& r, std::size_t intervals, ResidualPicture& p) {
  const PositionSpectrum s = position_spectrum(r);
  if (s.order.empty()) return;
  p.spectrum_before = peaks(s.order, s.before, 2 * intervals);
  if (p.corrected) p.spectrum_after = peaks(s.order, s.after, 2 * intervals);
  // Nothing can be read from amplitudes far below the largest one.
  double largest = 0;
  for (const auto& [order, amplitude] : p.spectrum_before) largest = std::max(largest, amplitude);
  for (Points* points : {&p.spectrum_before, &p.spectrum_after})
    std::erase_if(*points, [&](const auto& point) { return point.second < 1e-4 * largest; });
  p.revolution = s.order.front() / s.encoder_order.front();
}

}  // namespace

ResidualPicture residual_picture(const JointResidual& r, std::size_t intervals) {
  const Evidence& e = r.evidence;
  ResidualPicture p;
  p.joint = e.joint;
  p.prismatic = e.prismatic;
  p.unit = e.prismatic ? "m" : "rad";
  p.resolution = e.encoder.resolution;
  p.in_time = e.ordered;
  p.rows = e.rows();
  p.rms_before = rms(r.before);
  p.rms_after = rms(r.after);
  p.corrected = (r.before != r.after).any();
  draw_in_time(r, intervals, p);
  // At rest the reference's noise is all that moves: it has neither directions nor orders.
  if (e.is_stationary()) return p;
  draw_by_position(r, intervals, p);
  draw_by_count(r, p);
  draw_spectrum(r, intervals, p);
  return p;
}

}  // namespace qerr
