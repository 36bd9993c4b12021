#include "simulate/effects_along_motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "bound/signal_errors.hpp"
#include "filter/run/row_filter.hpp"
#include "simulate/path_errors.hpp"
#include "simulate/unrounded_record.hpp"

namespace qerr {

namespace {

/// Sums over samples, about the first one to avoid cancellation.
class MomentSums {
 public:
  void add(const Eigen::Ref<const Eigen::VectorXd>& sample) {
    if (count_ == 0) {
      shift_ = peak_ = sample;
      peak_.setZero();
      sum_.setZero(sample.size());
      squares_.setZero(sample.size(), sample.size());
    }
    deviation_ = sample - shift_;
    sum_ += deviation_;
    squares_.noalias() += deviation_ * deviation_.transpose();
    peak_ = peak_.cwiseMax(sample.cwiseAbs());
    count_ += 1;
  }

  SignalMoments moments() const {
    const Eigen::VectorXd mean = sum_ / count_;
    return {shift_ + mean, peak_, squares_ / count_ - mean * mean.transpose()};
  }

 private:
  double count_ = 0;
  Eigen::VectorXd shift_, sum_, peak_, deviation_;
  Eigen::MatrixXd squares_;
};

/// Moments of the errors of the model's coordinates and of its signals of other kinds, c(q) times the
/// joints', behind a filter; null: of the errors themselves, and of the joints'.
SignalMoments moments_of_tip(const OperationalModel& model, const std::vector<Effect>& effects,
                             const UnroundedRecord& record, const Filter* filter, SignalMoments* of_joints) {
  const auto m = static_cast<Eigen::Index>(model.coordinates.size());
  const auto n = static_cast<Eigen::Index>(model.transmission.encoders.size());
  constexpr std::size_t lanes = 8;
  const std::size_t signals = model.coordinates.size() + model.signals.size();
  const std::size_t width = (signals + lanes - 1) / lanes * lanes;
  PathErrors errors(model, as_built(model.chain, effects), Eigen::VectorXd::Zero(m));
  AlignedNumbers rows(width * batch_size), filtered(width * batch_size);
  std::unique_ptr<RowFilter> run;
  if (filter) run = std::make_unique<RowFilter>(*filter, width, batch_size);
  MomentSums tip, joints;
  Eigen::VectorXd joint(n), q(n);
  const auto joints_at = [&](const SensedBatch& batch, std::size_t sample) {
    for (Eigen::Index j = 0; j < n; ++j) {
      const std::size_t at = static_cast<std::size_t>(j) * batch_size + sample;
      q[j] = batch.joint[at];
      joint[j] = batch.estimate[at] - batch.joint[at];
    }
  };
  bool first = true;
  record.read(model, effects, [&](const SensedBatch& batch, const std::vector<std::size_t>& used) {
    errors(batch);
    for (std::size_t k = 0; k < used.size(); ++k) {
      std::copy_n(errors.rows() + used[k] * errors.width(), m, rows.data() + k * width);
      if (model.signals.empty()) continue;
      joints_at(batch, used[k]);
      Eigen::Map<Eigen::VectorXd>(rows.data() + k * width + m, static_cast<Eigen::Index>(signals) - m) =
          signal_rows(model, q) * joint;
    }
    if (run && first) run->settle(rows.data());
    if (run) (*run)(rows.data(), width, used.size(), filtered.data());
    first = false;
    const double* const out = run ? filtered.data() : rows.data();
    for (std::size_t k = 0; k < used.size(); ++k) {
      if (!record.is_after_settling(batch.first + used[k])) continue;
      tip.add(Eigen::Map<const Eigen::VectorXd>(out + k * width, static_cast<Eigen::Index>(signals)));
      if (!of_joints) continue;
      joints_at(batch, used[k]);
      joints.add(joint);
    }
  });
  if (of_joints) *of_joints = joints.moments();
  return tip.moments();
}

}  // namespace

ErrorAlongMotion effects_along_motion(const OperationalModel& model, const std::vector<Effect>& effects,
                                      const Motion& motion, const std::vector<Filter>& filters,
                                      double settling) {
  ErrorAlongMotion error;
  error.tip = moments_of_tip(model, effects, UnroundedRecord(motion, motion.sample_rate, settling), nullptr,
                             &error.joints);
  for (const Filter& filter : filters)
    error.filtered.push_back(moments_of_tip(
        model, effects, UnroundedRecord(motion, filter.sample_rate, settling), &filter, nullptr));
  return error;
}

SignalMoments effect_along_motion(const OperationalModel& model, const Effect& effect, const Motion& motion,
                                  double settling) {
  const std::size_t row = independent_index(model.chain, effect.joint) * batch_size;
  const UnroundedRecord record(motion, motion.sample_rate, settling);
  MomentSums sums;
  record.read(model, {effect}, [&](const SensedBatch& batch, const std::vector<std::size_t>& used) {
    for (const std::size_t i : used)
      if (record.is_after_settling(batch.first + i))
        sums.add(Eigen::VectorXd::Constant(1, batch.measured[row + i] - batch.encoder[row + i]));
  });
  return sums.moments();
}

double change_with_zero(const OperationalModel& model, const std::vector<Effect>& effects,
                        std::size_t encoder, const Motion& motion, double settling) {
  const UnroundedRecord record(motion, motion.sample_rate, settling);
  const Eigen::VectorXd steps = resolutions(model.transmission);
  double largest_position = 0;
  const auto errors = [&](const Eigen::VectorXd& displacement) {
    std::vector<double> all;
    record.read(model, effects, displacement,
                [&](const SensedBatch& batch, const std::vector<std::size_t>& used) {
                  for (const std::size_t i : used) {
                    if (!record.is_after_settling(batch.first + i)) continue;
                    const double measured = batch.measured[encoder * batch_size + i];
                    largest_position = std::max(largest_position, std::abs(measured));
                    all.push_back(measured - batch.encoder[encoder * batch_size + i]);
                  }
                });
    return all;
  };
  const std::vector<double> before = errors(Eigen::VectorXd::Zero(steps.size()));
  double sum = 0;
  for (Eigen::Index e = 0; e < steps.size(); ++e) {
    // Another encoder displaces this one's joint through a coupling, or changes its load.
    const auto row = static_cast<Eigen::Index>(encoder);
    if (e != row && model.transmission.coupling(row, e) == 0 && !needs_effort(effects)) continue;
    double largest = 0;
    for (const double half : {-0.5, 0.5}) {
      const std::vector<double> after = errors(half * steps[e] * Eigen::VectorXd::Unit(steps.size(), e));
      for (std::size_t k = 0; k < before.size(); ++k)
        largest = std::max(largest, std::abs(after[k] - before[k]));
    }
    sum += largest;
  }
  constexpr double rounding = 8 * std::numeric_limits<double>::epsilon();  // of the positions
  return sum > rounding * largest_position ? sum : 0;
}

}  // namespace qerr
