#include "qerr/bound/operational_error.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>
#include <numbers>

#include "bound/error_columns.hpp"

namespace qerr {

namespace {

double rigorous_bound(Coordinate c, double linear, const LinearizationRemainder& r,
                      double position_remainder) {
  if (is_position(c)) return linear + position_remainder;
  if (is_rotation_vector(c)) return std::min(linear + r.rotation, r.rotation_angle);
  return std::numeric_limits<double>::infinity();
}

void add_sources(const OperationalModel& model, const Eigen::VectorXd& q, const Eigen::Matrix3d& tip_rotation,
                 const Eigen::MatrixXd& joint_rows, const Eigen::MatrixXd& encoder_rows,
                 OperationalError& e) {
  e.added_sigma.resize(joint_rows.rows(), std::ssize(model.sources));
  e.added_worst.resizeLike(e.added_sigma);
  for (Eigen::Index i = 0; i < e.added_sigma.cols(); ++i) {
    const IndependentError& s = model.sources[i];
    const Eigen::VectorXd column = error_column(s, model, q, tip_rotation, joint_rows, encoder_rows);
    e.mean += column * s.mean;
    e.half_width += column.cwiseAbs() * s.half_width;
    e.added_sigma.col(i) = column * s.sigma;
    e.added_worst.col(i) = column.cwiseAbs() * (std::abs(s.mean) + s.half_width);
  }
}

}  // namespace

std::string tips_of(const OperationalModel& model) {
  if (!model.tips) return model.chain.tip;
  std::string all;
  for (const NamedTip& tip : *model.tips)
    if (tip.name.find('-') == std::string::npos)  // of one relative to another
      all += (all.empty() ? "" : ", ") + tip.chain.tip;
  return all;
}

std::vector<Signal> all_signals(const OperationalModel& model) {
  std::vector<Signal> all;
  for (const Coordinate c : model.coordinates) all.push_back(signal_of(c));
  for (const Coordinate c : model.lengths) all.push_back(signal_of(c));
  all.insert(all.end(), model.signals.begin(), model.signals.end());
  return all;
}

std::vector<IndependentError> independent_errors(const OperationalModel& model) {
  return independent_errors(model.transmission, model.sources);
}

JointError joint_error(const OperationalModel& model) {
  return joint_error(model.transmission, model.sources,
                     model.along_motion ? &model.along_motion->joints : nullptr);
}

OperationalError operational_error(const OperationalModel& model, const Eigen::VectorXd& q) {
  Eigen::Isometry3d pose;
  const Jacobian joints = joint_jacobian(model.chain, q, &pose);
  Eigen::MatrixXd rows = coordinate_rows(model.coordinates, joints, pose.linear(), model.frame);
  // At the gimbal lock roll and yaw are unbounded; infinity is assigned last because its products could be
  // NaN.
  const Eigen::Array<bool, Eigen::Dynamic, 1> unbounded = !rows.array().isFinite().rowwise().all();
  for (Eigen::Index i = 0; i < rows.rows(); ++i)
    if (unbounded[i]) rows.row(i).setZero();
  const Eigen::MatrixXd joint_rows = to_independent(model.chain, rows);
  const Eigen::MatrixXd encoder_rows = joint_rows * model.transmission.coupling;

  OperationalError e;
  e.cosine_of_pitch = cosine_of_pitch(pose.linear());
  e.weighted = encoder_rows * resolutions(model.transmission).asDiagonal();
  e.mean = encoder_rows * mean_errors(model.transmission);
  e.half_width = 0.5 * e.weighted.cwiseAbs().rowwise().sum();
  e.sigma = e.weighted.rowwise().norm() / std::sqrt(12.0);
  if (!model.sources.empty()) {
    add_sources(model, q, pose.linear(), joint_rows, encoder_rows, e);
    e.sigma = (e.sigma.array().square() + e.added_sigma.rowwise().squaredNorm().array()).sqrt();
  }
  e.worst_case = e.half_width + e.mean.cwiseAbs();

  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < rows.rows(); ++i)
    if (unbounded[i])
      e.half_width[i] = e.worst_case[i] = e.sigma[i] = infinity, e.weighted.row(i).setConstant(infinity);

  const LinearizationRemainder r = linearization_remainder(model.chain, joint_error(model).worst_case);
  const double position_remainder = r.position + joints.topRows<3>().colwise().norm() * r.per_column;
  e.rigorous.resize(e.sigma.size());
  for (Eigen::Index i = 0; i < e.rigorous.size(); ++i)
    e.rigorous[i] = rigorous_bound(model.coordinates[i], e.worst_case[i], r, position_remainder);
  if (model.along_motion) {
    const SignalMoments& tip = model.along_motion->tip;
    const Eigen::Index m = e.sigma.size();
    e.worst_case += tip.peak.head(m);
    e.rigorous += tip.peak.head(m);
    e.sigma = (e.sigma.array().square() + tip.covariance.diagonal().head(m).array()).sqrt();
  }
  return e;
}

Eigen::MatrixXd covariance(const OperationalError& e) {
  return covariance(e, 1, Eigen::VectorXd::Ones(e.added_sigma.cols()));
}

Eigen::MatrixXd covariance(const OperationalError& e, double h2, const Eigen::VectorXd& ratios) {
  Eigen::MatrixXd sum = e.weighted * e.weighted.transpose() / 12.0;
  sum *= h2 * h2;
  if (ratios.size() > 0) {
    const Eigen::MatrixXd added = e.added_sigma * ratios.asDiagonal();
    sum += added * added.transpose();
  }
  return sum;
}

Bounds derivative_error(double half_width, double mean, double sigma, const Norms& norms) {
  return {norms.l1.upper * half_width + std::abs(norms.dc_gain) * std::abs(mean), norms.h2 * sigma};
}

Bounds derivative_error(const OperationalError& e, Eigen::Index i, const Norms& norms,
                        const Eigen::VectorXd& ratios) {
  Bounds b = derivative_error(e.half_width[i], e.mean[i], e.sigma[i], norms);
  if (ratios.size() == 0 || !std::isfinite(e.sigma[i])) return b;
  const double quantization = norms.h2 * e.weighted.row(i).norm() / std::sqrt(12.0);
  b.sigma = std::hypot(quantization, e.added_sigma.row(i).cwiseProduct(ratios.transpose()).norm());
  return b;
}

ErrorEllipsoid error_ellipsoid(const Eigen::Matrix3d& covariance) {
  // Scaled, since the iteration compares with absolute thresholds.
  const double scale = covariance.cwiseAbs().maxCoeff();
  if (!(scale > 0) || !std::isfinite(scale))
    return {Eigen::Vector3d::Constant(scale), Eigen::Matrix3d::Identity()};
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance / scale);
  ErrorEllipsoid e;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const Eigen::Vector3d direction = solver.eigenvectors().col(2 - i);  // eigenvalues ascend
    Eigen::Index largest = 0;
    direction.cwiseAbs().maxCoeff(&largest);
    e.directions.col(i) = direction[largest] < 0 ? (-direction).eval() : direction;
    e.semi_axes[i] = std::sqrt(scale * std::max(solver.eigenvalues()[2 - i], 0.0));
  }
  return e;
}

LinearizationRemainder linearization_remainder(const Chain& chain, const Eigen::VectorXd& largest) {
  LinearizationRemainder r;
  r.per_column = Eigen::VectorXd::Zero(std::ssize(chain.joints));
  double before = 0;   // S_{k-1}
  double carried = 0;  // sum_{i<k} per_column_i: R_i grows by h_k (R_k or 1)
  double axes = 0;     // sum_k h_k S_{k-1} / 2
  for (Eigen::Index k = 0; k < r.per_column.size(); ++k) {
    const ChainJoint& joint = chain.joints[k];
    const double h = std::abs(joint.multiplier) * largest[joint.coordinate];
    if (joint.prismatic) {
      r.position += (before + carried) * h;
      continue;
    }
    r.per_column[k] = h * (before + 0.5 * h + carried);
    carried += r.per_column[k];
    axes += 0.5 * h * before;
    before += h;
  }
  r.rotation_angle = before;
  r.rotation = before <= std::numbers::pi ? axes + before * before * (0.25 + 0.034 * before)
                                          : std::numeric_limits<double>::infinity();
  return r;
}

}  // namespace qerr
