#include "diagnose/record/encoder_columns.hpp"

#include <algorithm>
#include <cmath>

#include "core/solve.hpp"

namespace qerr {

namespace {

constexpr double nothing = 1e-12;  ///< of a joint's part in what an encoder feels

/// What the encoder feels of every joint, per unit of it.
Eigen::RowVectorXd parts_of_joints(const OperationalModel& model, Eigen::Index encoder) {
  return inverse(model.transmission.coupling).row(encoder);
}

}  // namespace

bool depends_on_one_joint(const OperationalModel& model, Eigen::Index encoder) {
  return (parts_of_joints(model, encoder).array().abs() > nothing).count() == 1;
}

EncoderReference encoder_reference(const OperationalModel& model, const Log& log, Eigen::Index encoder) {
  const Eigen::RowVectorXd parts = parts_of_joints(model, encoder);
  EncoderReference r{Eigen::ArrayXd::Zero(log.values.rows())};
  for (Eigen::Index j = 0; j < parts.size(); ++j) {
    if (std::abs(parts[j]) < nothing) continue;
    const auto column = log.find(LogSignal::reference, static_cast<std::size_t>(j));
    if (!column) return {};
    r.position += parts[j] * log.values.col(*column);
    r.log_resolution = std::max(r.log_resolution,
                                std::abs(parts[j]) * log.columns[static_cast<std::size_t>(*column)].step());
  }
  return r;
}

Eigen::ArrayXd encoder_measured(const OperationalModel& model, const Log& log, Eigen::Index encoder) {
  const Eigen::RowVectorXd parts = parts_of_joints(model, encoder);
  Eigen::ArrayXd x = Eigen::ArrayXd::Zero(log.values.rows());
  for (Eigen::Index j = 0; j < parts.size(); ++j) {
    if (std::abs(parts[j]) < nothing) continue;
    const auto joint = measured_joint(log, log.values, model.transmission, static_cast<std::size_t>(j));
    if (!joint) return {};
    x += parts[j] * *joint;
  }
  return x;
}

}  // namespace qerr
