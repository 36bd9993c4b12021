#include <cmath>
#include <numbers>

#include "report/csv_text.hpp"
#include "report/diagnosis/extended_reading.hpp"
#include "report/diagnosis/parts.hpp"

namespace qerr {

namespace {

constexpr Eigen::Index bins = 4096;
std::vector<Effect> effects_of(const DiagnosisReport& r, const std::string& joint) {
  std::vector<Effect> list;
  for (const Cause& c : r.diagnosis.causes)
    if (c.effect.joint == joint) list.push_back(c.effect);
  return list;
}

/// Means over equal intervals of the range, minus the overall mean; NaN in an interval without samples.
Eigen::ArrayXd binned(const Eigen::ArrayXd& position, const Eigen::ArrayXd& residual) {
  const double from = position.minCoeff(), span = position.maxCoeff() - from;
  Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(bins), count = Eigen::ArrayXd::Zero(bins);
  for (Eigen::Index k = 0; k < position.size(); ++k) {
    const auto bin =
        std::min<Eigen::Index>(bins - 1, static_cast<Eigen::Index>(bins * (position[k] - from) / span));
    sum[bin] += residual[k];
    count[bin] += 1;
  }
  const double mean = residual.mean();
  return (count > 0).select(sum / count.max(1) - mean, std::nan(""));
}

/// Amplitude of the sine of each order, about `steps` of them up to half the bins.
Eigen::ArrayXd spectrum(const Eigen::ArrayXd& means, Eigen::Index steps) {
  Eigen::ArrayXd amplitude(steps);
  const double filled = static_cast<double>((means == means).count());
  for (Eigen::Index i = 0; i < steps; ++i) {
    // Half a wave over the range per step.
    const double phase = std::numbers::pi * static_cast<double>(i + 1) / static_cast<double>(bins);
    double sine = 0, cosine = 0;
    for (Eigen::Index b = 0; b < bins; ++b) {
      if (std::isnan(means[b])) continue;
      sine += means[b] * std::sin(phase * static_cast<double>(b));
      cosine += means[b] * std::cos(phase * static_cast<double>(b));
    }
    amplitude[i] = 2 * std::hypot(sine, cosine) / filled;
  }
  return amplitude;
}

}  // namespace

ResidualCurves residual_curves(const DiagnosisReport& r) {
  ResidualCurves out;
  for (const Evidence& e : evidence(r.spec.model, r.log, all_encoders(r.spec.model))) {
    const Eigen::ArrayXd before = e.measured - e.reference;
    const Eigen::ArrayXd after = before - explained(e, effects_of(r, e.joint));
    const std::string joint = csv_cell(e.joint) + ',', unit = e.prismatic ? ",m\r\n" : ",rad\r\n";
    for (Eigen::Index k = 0; k < e.rows(); ++k)
      out.residual += joint + (e.ordered ? shortest(e.time[k]) : "") + ',' + shortest(e.reference[k]) + ',' +
                      shortest(e.direction.size() ? e.direction[k] : 0) + ',' + shortest(before[k]) + ',' +
                      shortest(after[k]) + unit;
    const double span = e.reference.maxCoeff() - e.reference.minCoeff();
    if (!(span > 0)) continue;
    const Eigen::Index steps = bins / 2;
    const Eigen::ArrayXd was = spectrum(binned(e.reference, before), steps),
                         is = spectrum(binned(e.reference, after), steps);
    for (Eigen::Index i = 0; i < steps; ++i) {
      const double waves = 0.5 * static_cast<double>(i + 1) / span;  // per rad or m
      const double order = e.prismatic ? waves : 2 * std::numbers::pi * waves;
      out.spectrum += joint + shortest(order) + ',' +
                      shortest(2 * std::numbers::pi * waves / std::abs(e.encoder.shaft_ratio)) + ',' +
                      shortest(was[i]) + ',' + shortest(is[i]) + unit;
    }
  }
  if (!out.residual.empty())
    out.residual.insert(0, "joint,time [s],reference,direction,before,after,unit\r\n");
  if (!out.spectrum.empty()) out.spectrum.insert(0, "joint,order,encoder_order,before,after,unit\r\n");
  return out;
}

}  // namespace qerr
