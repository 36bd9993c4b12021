#include "diagnose/record/encoder_columns.hpp"

#include <algorithm>
#include <cmath>

namespace qerr {

namespace {

constexpr double negligible_weight = 1e-12;  ///< by rounding errors

/// Change of the encoder's coordinate per unit of every joint.
Eigen::RowVectorXd joint_weights(const OperationalModel& model, Eigen::Index encoder) {
  return model.transmission.coupling.inverse().row(encoder);
}

}  // namespace

bool depends_on_one_joint(const OperationalModel& model, Eigen::Index encoder) {
  return (joint_weights(model, encoder).array().abs() > negligible_weight).count() == 1;
}

EncoderReference encoder_reference(const OperationalModel& model, const Log& log, Eigen::Index encoder) {
  const Eigen::RowVectorXd weights = joint_weights(model, encoder);
  EncoderReference r{Eigen::ArrayXd::Zero(log.values.rows())};
  for (Eigen::Index j = 0; j < weights.size(); ++j) {
    if (std::abs(weights[j]) < negligible_weight) continue;
    const auto column = log.find(LogSignal::reference, static_cast<std::size_t>(j));
    if (!column) return {};
    r.position += weights[j] * log.values.col(*column);
    r.log_resolution = std::max(r.log_resolution,
                                std::abs(weights[j]) * log.columns[static_cast<std::size_t>(*column)].step());
  }
  return r;
}

Eigen::ArrayXd encoder_measured(const OperationalModel& model, const Log& log, Eigen::Index encoder) {
  const Eigen::RowVectorXd weights = joint_weights(model, encoder);
  Eigen::ArrayXd x = Eigen::ArrayXd::Zero(log.values.rows());
  for (Eigen::Index j = 0; j < weights.size(); ++j) {
    if (std::abs(weights[j]) < negligible_weight) continue;
    const auto joint = measured_joint(log, log.values, model.transmission, static_cast<std::size_t>(j));
    if (!joint) return {};
    x += weights[j] * *joint;
  }
  return x;
}

}  // namespace qerr
