#include "report/diagnosis/joint_residual.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/parallel.hpp"
#include "qerr/core/quantity.hpp"
#include "report/csv_text.hpp"
#include "report/diagnosis/extended_reading.hpp"
#include "report/fourier.hpp"

namespace qerr {

namespace {

constexpr Eigen::Index position_bins = 4096;

std::vector<Effect> effects_of(const DiagnosisReport& r, const std::string& joint) {
  std::vector<Effect> list;
  for (const Cause& c : r.diagnosis.causes)
    if (c.effect.joint == joint) list.push_back(c.effect);
  return list;
}

JointResidual residual_of(const DiagnosisReport& r, Evidence e) {
  const std::vector<Effect> effects = effects_of(r, e.joint);
  JointResidual out{std::move(e), {}, {}};
  out.before = out.evidence.measured - out.evidence.reference;
  out.after = out.before;
  if (!effects.empty()) out.after -= explained(out.evidence, effects);
  return out;
}

/// Means over equal intervals of the range, minus the overall mean; NaN in an interval without samples.
Eigen::ArrayXd means_by_position(const Eigen::ArrayXd& position, const Eigen::ArrayXd& residual) {
  const double from = position.minCoeff(), span = position.maxCoeff() - from;
  Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(position_bins), count = Eigen::ArrayXd::Zero(position_bins);
  for (Eigen::Index k = 0; k < position.size(); ++k) {
    const auto bin = std::min<Eigen::Index>(
        position_bins - 1, static_cast<Eigen::Index>(position_bins * (position[k] - from) / span));
    sum[bin] += residual[k];
    count[bin] += 1;
  }
  const double mean = residual.mean();
  return (count > 0).select(sum / count.max(1) - mean, std::nan(""));
}

/// Amplitudes of half a wave over the range, of two halves, ... up to half the intervals.
std::vector<double> amplitudes(const Eigen::ArrayXd& means) {
  std::vector<double> padded(2 * position_bins, 0.0);
  double filled = 0;
  for (Eigen::Index b = 0; b < position_bins; ++b)
    if (!std::isnan(means[b])) padded[static_cast<std::size_t>(b)] = means[b], ++filled;
  const auto spectrum = half_spectrum(padded);
  std::vector<double> amplitude;
  for (std::size_t n = 1; n <= position_bins / 2; ++n)
    amplitude.push_back(2 * std::abs(spectrum[n]) / filled);
  return amplitude;
}

}  // namespace

void for_each_residual(const DiagnosisReport& r, const std::function<void(const JointResidual&)>& task) {
  constexpr std::size_t rows_at_once = 1 << 21;
  if (r.log.values.size() == 0) return;
  const std::vector<std::size_t> encoders = all_encoders(r.spec.model);
  const std::size_t rows = std::max<std::size_t>(1, static_cast<std::size_t>(r.log.values.rows()));
  const std::size_t at_once = std::max<std::size_t>(1, rows_at_once / rows);
  for (std::size_t first = 0; first < encoders.size(); first += at_once) {
    const std::size_t end = std::min(first + at_once, encoders.size());
    std::vector<Evidence> some = evidence(r.spec.model, r.log,
                                          {encoders.begin() + static_cast<std::ptrdiff_t>(first),
                                           encoders.begin() + static_cast<std::ptrdiff_t>(end)});
    parallel_for(some.size(), 0, [&](std::size_t i) { task(residual_of(r, std::move(some[i]))); });
  }
}

PositionSpectrum position_spectrum(const JointResidual& residual) {
  const Evidence& e = residual.evidence;
  const double span = e.reference.maxCoeff() - e.reference.minCoeff();
  if (!(span > 0)) return {};
  PositionSpectrum s{{}, {}, amplitudes(means_by_position(e.reference, residual.before)), {}};
  s.after = (residual.before == residual.after).all()
                ? s.before
                : amplitudes(means_by_position(e.reference, residual.after));
  for (std::size_t i = 0; i < s.before.size(); ++i) {
    const double waves = 0.5 * static_cast<double>(i + 1) / span;  // per rad or m
    s.order.push_back(e.prismatic ? waves : 2 * std::numbers::pi * waves);
    s.encoder_order.push_back(2 * std::numbers::pi * waves / std::abs(e.encoder.shaft_ratio));
  }
  return s;
}

namespace {

std::string residual_rows(const JointResidual& residual) {
  const Evidence& e = residual.evidence;
  const std::string joint = csv_cell(e.joint) + ',', unit = e.prismatic ? ",m\r\n" : ",rad\r\n";
  std::string out;
  for (Eigen::Index k = 0; k < e.rows(); ++k)
    out += joint + (e.ordered ? shortest(e.time[k]) : "") + ',' + shortest(e.reference[k]) + ',' +
           shortest(e.direction.size() ? e.direction[k] : 0) + ',' + shortest(residual.before[k]) + ',' +
           shortest(residual.after[k]) + unit;
  return out;
}

std::string spectrum_rows(const JointResidual& residual) {
  const Evidence& e = residual.evidence;
  const std::string joint = csv_cell(e.joint) + ',', unit = e.prismatic ? ",m\r\n" : ",rad\r\n";
  const PositionSpectrum s = position_spectrum(residual);
  std::string out;
  for (std::size_t i = 0; i < s.order.size(); ++i)
    out += joint + shortest(s.order[i]) + ',' + shortest(s.encoder_order[i]) + ',' + shortest(s.before[i]) +
           ',' + shortest(s.after[i]) + unit;
  return out;
}

}  // namespace

ResidualCurves residual_curves(const DiagnosisReport& r) {
  std::vector<ResidualCurves> of_encoder(r.spec.model.transmission.encoders.size());
  for_each_residual(r, [&](const JointResidual& residual) {
    of_encoder[static_cast<std::size_t>(residual.evidence.number)] = {residual_rows(residual),
                                                                      spectrum_rows(residual)};
  });
  ResidualCurves out;
  for (const ResidualCurves& one : of_encoder) out.residual += one.residual, out.spectrum += one.spectrum;
  if (!out.residual.empty())
    out.residual.insert(0, "joint,time [s],reference,direction,before,after,unit\r\n");
  if (!out.spectrum.empty()) out.spectrum.insert(0, "joint,order,encoder_order,before,after,unit\r\n");
  return out;
}

}  // namespace qerr
