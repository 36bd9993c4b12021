#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/text.hpp"
#include "qerr/bound/operational_error.hpp"
#include "report/analysis/tables.hpp"
#include "report/page/page.hpp"
#include "report/rows.hpp"

namespace qerr {

namespace {

/// Origins of the base, of the moved joint frames and of the tip, in the base frame [m].
std::vector<Eigen::Vector3d> skeleton(const Chain& chain, const Eigen::VectorXd& q) {
  std::vector<Eigen::Vector3d> points{Eigen::Vector3d::Zero()};
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
  for (const ChainJoint& joint : chain.joints) {
    const double value = joint.multiplier * q[joint.coordinate] + joint.offset;
    frame = frame * joint.origin;
    points.emplace_back(frame.translation());
    if (joint.prismatic)
      frame.translate(value * joint.axis);
    else
      frame.rotate(Eigen::AngleAxisd(value, joint.axis));
    points.emplace_back(frame.translation());
  }
  points.emplace_back((frame * chain.tip_offset).translation());
  return points;
}

/// The largest of 1, 2, 5 times a power of ten by which the error spans at most a sixth of the reach.
double magnification(double reach, double error) {
  if (!(reach > 0 && error > 0)) return 1;
  const double most = reach / 6 / error, power = std::pow(10, std::floor(std::log10(most)));
  return power * (most >= 5 * power ? 5 : most >= 2 * power ? 2 : 1);
}

/// What is drawn of a configuration, in the axes of the base [m].
struct DrawnPose {
  std::string name;
  std::vector<Eigen::Vector3d> points;
  Eigen::Matrix3d covariance;
  Eigen::Matrix3d box;  ///< columns: half edges of the worst case
};

OperationalModel of_position(OperationalModel model) {
  model.coordinates = {Coordinate::x, Coordinate::y, Coordinate::z};
  model.lengths.clear();
  model.signals.clear();
  return model;
}

DrawnPose drawn_pose(const OperationalModel& model, const std::string& name, const Eigen::VectorXd& q) {
  const auto& all = model.coordinates;
  std::array<Eigen::Index, 3> at{};
  for (std::size_t i = 0; i < 3; ++i)
    at[i] = std::ranges::find(all, std::array{Coordinate::x, Coordinate::y, Coordinate::z}[i]) - all.begin();
  const OperationalError error = operational_error(model, q);
  Eigen::MatrixXd sigma = covariance(error);
  if (model.along_motion) sigma += model.along_motion->tip.covariance;
  const Eigen::Matrix3d axes = model.frame == CoordinateFrame::tip
                                   ? Eigen::Matrix3d(forward_kinematics(model.chain, q).linear())
                                   : Eigen::Matrix3d::Identity();
  return {name, skeleton(model.chain, q), axes * sigma(at, at) * axes.transpose(),
          axes * error.worst_case(at).asDiagonal()};
}

/// The outline of the ellipsoid's projection: C = L L^T has the outline L (cos t, sin t) of its block of two
/// rows.
page::Series outline(const DrawnPose& pose, std::array<int, 2> rows, double factor) {
  const Eigen::Matrix3d& c = pose.covariance;
  const double first = std::sqrt(std::max(0.0, c(rows[0], rows[0])));
  const double second = first > 0 ? c(rows[0], rows[1]) / first : 0;  // Cholesky
  const double last = std::sqrt(std::max(0.0, c(rows[1], rows[1]) - second * second));
  page::Series s{"one sigma, " + significant(factor, 6) + " times larger", {}};
  constexpr int points = 36;
  const Eigen::Vector3d& tip = pose.points.back();
  for (int i = 0; i <= points; ++i) {
    const double t = 2 * std::numbers::pi * i / points;
    s.points.emplace_back(tip[rows[0]] + factor * first * std::cos(t),
                          tip[rows[1]] + factor * (second * std::cos(t) + last * std::sin(t)));
  }
  return s;
}

page::Series edges(const DrawnPose& pose, std::array<int, 2> rows, double factor) {
  page::Series s{"worst case, " + significant(factor, 6) + " times larger", {}};
  // A path along all twelve edges of a cube; bit k of a corner is the side along axis k.
  for (const int corner : {0, 1, 3, 2, 0, 4, 5, 1, 5, 7, 3, 7, 6, 2, 6, 4}) {
    Eigen::Vector3d side;
    for (int k = 0; k < 3; ++k) side[k] = (corner >> k & 1) != 0 ? 1 : -1;
    const Eigen::Vector3d at = pose.points.back() + factor * (pose.box * side);
    s.points.emplace_back(at[rows[0]], at[rows[1]]);
  }
  return s;
}

std::string views(const DrawnPose& pose, double factor) {
  const Eigen::Vector3d semi_axes = error_ellipsoid(pose.covariance).semi_axes;
  std::string out = "<p>Configuration of the " + pose.name +
                    " of the position. Semi-axes of one sigma: " + readable(semi_axes[0], "m") + ", " +
                    readable(semi_axes[1], "m") + ", " + readable(semi_axes[2], "m") +
                    ".</p><div class=\"figures\">";
  constexpr std::array<const char*, 3> axes{"x", "y", "z"};
  for (const std::array<int, 2> rows : {std::array{0, 1}, {0, 2}, {1, 2}}) {
    const std::string x = axes[rows[0]], y = axes[rows[1]];
    page::Series robot{"robot", {}, true};
    for (const Eigen::Vector3d& p : pose.points) robot.points.emplace_back(p[rows[0]], p[rows[1]]);
    page::Plot plot{"View " + x + y + ", " + pose.name,
                    "The robot in the base frame, with the ellipsoid of one sigma and the box of the worst "
                    "case at its tip.",
                    {x, "m", false, false},
                    {y, "m", false, false},
                    {robot, outline(pose, rows, factor), edges(pose, rows, factor)}};
    plot.equal_scales = true;
    out += figure(plot);
  }
  return out + "</div>";
}

const Eigen::VectorXd& median_configuration(const ConfigurationSample& sample) {
  std::vector<std::size_t> order(sample.trace.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto middle = order.begin() + static_cast<std::ptrdiff_t>((order.size() - 1) / 2);
  std::nth_element(order.begin(), middle, order.end(), [&](std::size_t a, std::size_t b) {
    return std::pair(sample.trace[a], a) < std::pair(sample.trace[b], b);
  });
  return sample.q[*middle];
}

Json numbers(std::vector<double> all, int digits) {
  for (double& v : all) v = rounded_to(v, digits);
  return all;
}

/// Rows of [R p] of a transform.
Json transform_rows(const Eigen::Isometry3d& t) {
  std::vector<double> all;
  for (Eigen::Index r = 0; r < 3; ++r)
    for (Eigen::Index c = 0; c < 4; ++c) all.push_back(t.matrix()(r, c));
  return numbers(all, 9);
}

Json joint_of(const ChainJoint& j, const Chain& chain) {
  return {{"name", j.name},
          {"origin", transform_rows(j.origin)},
          {"axis", numbers(std::vector<double>(j.axis.data(), j.axis.data() + 3), 9)},
          {"prismatic", j.prismatic},
          {"coordinate", j.coordinate},
          {"multiplier", j.multiplier},
          {"added", j.offset},
          {"driven", chain.independent[j.coordinate].name}};
}

/// Joint values, half edges of the box (by columns), covariance xx xy xz yy yz zz.
Json pose_of(const DrawnPose& pose, const Eigen::VectorXd& q) {
  std::vector<double> box(pose.box.data(), pose.box.data() + 9), covariance;
  for (Eigen::Index r = 0; r < 3; ++r)
    for (Eigen::Index c = r; c < 3; ++c) covariance.push_back(pose.covariance(r, c));
  // In the axes of the base the box has three numbers.
  const bool aligned = pose.box.isDiagonal();
  if (aligned) box = {pose.box(0, 0), pose.box(1, 1), pose.box(2, 2)};
  std::vector<double> all(q.data(), q.data() + q.size());
  all.insert(all.end(), box.begin(), box.end());
  all.insert(all.end(), covariance.begin(), covariance.end());
  return numbers(std::move(all), 6);
}

/// What the script draws in three dimensions: the chain, and the errors at the configuration of the largest
/// and of the median variance, then at others of the sample, as many as make a cloud.
std::string scene(const OperationalModel& model, const ConfigurationSample& sample,
                  const std::array<DrawnPose, 2>& poses, const std::array<const Eigen::VectorXd*, 2>& at,
                  double factor) {
  constexpr std::size_t cloud = 700;
  Json joints = Json::array(), all = Json::array(), colours = Json::array(), names = Json::array();
  for (const ChainJoint& j : model.chain.joints) joints.push_back(joint_of(j, model.chain));
  // The row of --per-configuration, from 1; 0 where the sample has not all of them.
  Json rows = Json::array();
  for (std::size_t i = 0; i < 2; ++i) {
    all.push_back(pose_of(poses[i], *at[i]));
    const auto same = std::ranges::find(sample.q, *at[i]) - sample.q.begin();
    rows.push_back(sample.complete() && same < std::ssize(sample.q) ? same + 1 : 0);
  }
  const std::size_t count = std::min(cloud, sample.q.size());
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t row = i * sample.q.size() / count;
    const Eigen::VectorXd& q = sample.q[row];
    rows.push_back(sample.complete() ? row + 1 : 0);
    all.push_back(pose_of(drawn_pose(model, "", q), q));
  }
  for (const page::Colour& c : page::cividis) colours.push_back(Json(c));
  for (const IndependentJoint& j : model.chain.independent)
    names.push_back(Json{{"name", j.name}, {"prismatic", j.prismatic()}});
  const Json data{{"joints", joints},  {"tip", transform_rows(model.chain.tip_offset)},
                  {"encoders", names}, {"poses", all},
                  {"factor", factor},  {"colours", colours},
                  {"of", sample.of},   {"rows", rows}};
  return "<div class=\"scene\" hidden=\"hidden\">" + page::json_script(line(data)) + "</div>\n";
}

}  // namespace

std::string robot_figures(const Analysis& a, const ConfigurationSample& sample) {
  if (sample.q.empty()) return "<p>Without a configuration there is no robot to draw.</p>";
  OperationalModel model = a.spec.model;
  const bool complete = std::ranges::count_if(model.coordinates, is_position) == 3;
  if (!complete && model.along_motion)
    return "<p>Errors along a motion are known of the spec's coordinates alone: without x, y and z among "
           "them "
           "there is no ellipsoid.</p>";
  if (!complete) model = of_position(model);
  const std::array<const Eigen::VectorXd*, 2> at{&a.workspace.largest_at, &median_configuration(sample)};
  const std::array poses{drawn_pose(model, "largest variance", *at[0]),
                         drawn_pose(model, "median variance", *at[1])};
  double reach = 0, error = 0;
  for (const Eigen::Vector3d& p : poses[0].points) reach = std::max(reach, p.norm());
  for (const DrawnPose& p : poses) error = std::max(error, p.box.colwise().norm().maxCoeff());
  const double factor = magnification(reach, std::isfinite(error) ? error : 0);
  return scene(model, sample, poses, at, factor) + "<div class=\"views\">" + views(poses[0], factor) +
         views(poses[1], factor) + "</div>";
}

}  // namespace qerr
