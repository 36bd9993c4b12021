#include "bound/error_plan.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bound/linearization_remainder.hpp"
#include "qerr/bound/joint_error.hpp"

namespace qerr {

namespace {

bool any_of_kind(const std::vector<Coordinate>& coordinates, bool (*kind)(Coordinate)) {
  return std::any_of(coordinates.begin(), coordinates.end(), kind);
}

/// x y z, or x y z rx ry rz.
bool are_leading(const std::vector<Coordinate>& coordinates) {
  for (std::size_t i = 0; i < coordinates.size(); ++i)
    if (coordinates[i] != static_cast<Coordinate>(i)) return false;
  return coordinates.size() == 3 || coordinates.size() == 6;
}

}  // namespace

PlannedError::PlannedError(const OperationalModel& model, const ErrorFigures& requested)
    : chain_(fold(model.chain,
                  any_of_kind(model.coordinates, is_euler_angle) || model.frame == CoordinateFrame::tip)) {
  for (const FoldedJoint& joint : chain_.joints) column_scale_.push_back(joint.sign);
  set_coordinates(model);
  add_encoders(model);
  for (const ErrorSource& source : model.sources) add_source(model, source);
  plan_.plain = model.sources.empty() && mean_errors(model.transmission).isZero(0);
  set_direct();
  set_remainder(model);
  plan_.column_scale = column_scale_.data();
  if (plan_.direct) share_scale();
  plan_.chain = path_of(chain_);
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    parts_[p].begin = weights_[p].data();
    parts_[p].end = weights_[p].data() + weights_[p].size();
  }
  plan_.part = parts_.data();
  plan_.parts = parts_.size();
  // A tip on the last joint's axis does not move with that joint.
  const bool tip_on_axis = plan_.direct && !chain_.joints.back().rotates && !chain_.joints.back().prismatic;
  plan_.moving_parts = parts_.size() - (tip_on_axis ? 1 : 0);
  plan_.arm = arm_.data();
  set_filters(model, requested);
  set_layout(requested, requested.covariance ? 0 : model.lengths.size());
}

void PlannedError::set_coordinates(const OperationalModel& model) {
  for (const Coordinate c : model.coordinates) coordinate_.push_back(static_cast<int>(c));
  plan_.coordinates = coordinate_.size();
  plan_.coordinate = coordinate_.data();
  plan_.tip_frame = model.frame == CoordinateFrame::tip;
  plan_.positions_first = are_leading(model.coordinates) && !plan_.tip_frame;
  plan_.any_euler = any_of_kind(model.coordinates, is_euler_angle);
  plan_.any_position = any_of_kind(model.coordinates, is_position);
}

void PlannedError::add_encoders(const OperationalModel& model) {
  const Eigen::VectorXd delta = resolutions(model.transmission), mean = mean_errors(model.transmission);
  plan_.encoders = static_cast<std::size_t>(delta.size());
  for (Eigen::Index j = 0; j < delta.size(); ++j) {
    const double sigma = delta[j] / std::sqrt(12.0);
    std::vector<JointWeight>& weights = weights_.emplace_back();
    for (std::size_t k = 0; k < model.chain.joints.size(); ++k) {
      const ChainJoint& joint = model.chain.joints[k];
      const double weight =
          joint.multiplier * model.transmission.coupling(static_cast<Eigen::Index>(joint.coordinate), j);
      if (weight != 0) weights.push_back({k, weight * sigma});
    }
    parts_.push_back({.sigma = 1,
                      .half_width = half_width_of_sigma,
                      .mean = mean[j] / sigma,
                      .width = half_width_of_sigma,
                      .owner = static_cast<std::size_t>(j)});
    arm_.push_back(1 / sigma);
  }
}

void PlannedError::add_source(const OperationalModel& model, const ErrorSource& source) {
  const double largest = std::max({source.sigma, source.half_width, std::abs(source.mean)});
  const double scale = largest > 0 ? largest : 1;
  std::vector<JointWeight>& weights = weights_.emplace_back();
  ErrorPart part{.sigma = source.sigma / scale,
                 .half_width = source.half_width / scale,
                 .mean = source.mean / scale,
                 .width = (std::abs(source.mean) + source.half_width) / scale,
                 .owner = source.owner,
                 .source = true};
  if (source.where == ErrorSource::Where::origin) {
    const Eigen::Vector3d along = scale * (model.chain.joints[source.link].parent_axes * source.direction);
    const Eigen::Vector3d direction =
        source.link == 0 ? along : Eigen::Vector3d(chain_.link_axes[source.link - 1] * along);
    part.link = source.link;
    std::copy(direction.begin(), direction.end(), part.direction);
  } else {
    for (std::size_t k = 0; k < model.chain.joints.size(); ++k) {
      const ChainJoint& joint = model.chain.joints[k];
      const double coupling = source.where == ErrorSource::Where::joint
                                  ? static_cast<double>(joint.coordinate == source.owner)
                                  : model.transmission.coupling(static_cast<Eigen::Index>(joint.coordinate),
                                                                static_cast<Eigen::Index>(source.owner));
      if (coupling != 0) weights.push_back({k, joint.multiplier * coupling * scale});
    }
  }
  parts_.push_back(part);
}

/// Direct models: each joint has one encoder, whose scale is a factor of the joint's column.
void PlannedError::set_direct() {
  plan_.direct = plan_.plain && plan_.positions_first && parts_.size() == chain_.joints.size();
  std::vector<std::size_t> part_of(chain_.joints.size(), parts_.size());
  for (std::size_t p = 0; p < parts_.size() && plan_.direct; ++p) {
    if (weights_[p].size() == 1) part_of[weights_[p].front().joint] = p;
    plan_.direct = weights_[p].size() == 1;
  }
  plan_.direct = plan_.direct && std::count(part_of.begin(), part_of.end(), parts_.size()) == 0;
  if (!plan_.direct) return;
  std::vector<ErrorPart> parts;
  std::vector<std::vector<JointWeight>> weights;
  for (std::size_t k = 0; k < part_of.size(); ++k) {
    column_scale_[k] *= weights_[part_of[k]].front().weight;
    parts.push_back(parts_[part_of[k]]);
    weights.push_back(weights_[part_of[k]]);
  }
  parts_ = std::move(parts);
  weights_ = std::move(weights);
}

/// Equal scales of all columns become the length of the chain's axes. Signs do not matter: no error has a
/// mean.
void PlannedError::share_scale() {
  const double scale = std::abs(column_scale_.front());
  for (const double of_joint : column_scale_)
    if (std::abs(of_joint) != scale) return;
  scale_axes(chain_, scale);
  plan_.column_scale = nullptr;
}

void PlannedError::set_remainder(const OperationalModel& model) {
  const LinearizationRemainder r = linearization_remainder(model.chain, joint_error(model).worst_case);
  plan_.remainder = r.position;
  plan_.angle_remainder = r.rotation;
  plan_.angle = r.rotation_angle;
  for (std::size_t k = 0; k < column_scale_.size(); ++k) {
    const double scale = std::abs(column_scale_[k]);
    per_column_.push_back(scale > 0 ? r.per_column[static_cast<Eigen::Index>(k)] / scale : 0);
  }
  plan_.per_column = per_column_.data();
}

void PlannedError::set_filters(const OperationalModel& model, const ErrorFigures& requested) {
  const auto& sources = model.sources;
  const bool biased = !mean_errors(model.transmission).isZero(0);
  for (std::size_t f = 0; f < requested.filters.size(); ++f) {
    const Norms& norms = requested.filters[f];
    const Eigen::VectorXd ratios = sigma_ratios(sources, f, norms.h2),
                          in_motion = sigma_ratios(sources, f, norms.h2, true);
    const bool known = f < requested.noise_in_motion.size() && requested.noise_in_motion[f].size() > 0;
    l1_.push_back(norms.l1.upper);
    dc_gain_.push_back(std::abs(norms.dc_gain));
    Eigen::Index source = 0;
    for (const ErrorPart& part : parts_) {
      double square = norms.h2 * norms.h2, motion_square = -1;
      if (part.source) {
        square = std::pow(part.sigma * ratios[source], 2);
        if (known) motion_square = std::pow(part.sigma * in_motion[source], 2);
        ++source;
      } else if (known) {
        // noise_in_motion is in quantization intervals, sigma is 1/sqrt(12) of one.
        motion_square = 12 * std::pow(requested.noise_in_motion[f][static_cast<Eigen::Index>(part.owner)], 2);
      }
      ratio_squares_.push_back(square);
      motion_squares_.push_back(motion_square);
    }
  }
  plan_.filters = requested.filters.size();
  plan_.filtered_worst = biased || !sources.empty() || model.along_motion;
  plan_.filtered_sigma = !sources.empty() || model.along_motion;
  plan_.l1 = l1_.data();
  plan_.dc_gain = dc_gain_.data();
  plan_.ratio_squares = ratio_squares_.data();
  plan_.motion_squares = motion_squares_.data();
}

void PlannedError::set_layout(const ErrorFigures& requested, std::size_t lengths) {
  plan_.keep_covariance = requested.covariance;
  plan_.shares = requested.shares;
  plan_.rigorous = requested.rigorous;
  plan_.keep_columns = requested.shares || requested.rigorous || plan_.filters > 0;
  const std::size_t m = plan_.coordinates, all = m + lengths, entries = m * (m + 1) / 2, f = plan_.filters;
  const auto place = [](std::size_t& total, bool wanted, std::size_t count) {
    const std::size_t first = total;
    if (wanted) total += count;
    return first;
  };
  FigureLayout& figures = plan_.figures;
  figures.coordinates = all;
  figures.worst_case = place(figures.count, true, all);
  figures.sigma = place(figures.count, !requested.covariance, all);
  figures.rigorous = place(figures.count, requested.rigorous, all);
  figures.filtered_worst = place(figures.count, plan_.filtered_worst, f * all);
  figures.filtered_sigma = place(figures.count, plan_.filtered_sigma, f * all);
  figures.in_motion = place(figures.count, !requested.noise_in_motion.empty(), f * all);
  figures.trace = place(figures.count, requested.shares, 1);
  figures.covariance = place(figures.count, requested.covariance, entries);
  SumLayout& sums = plan_.sums;
  sums.covariance = place(sums.count, !requested.covariance, entries);
  sums.filtered = place(sums.count, plan_.filtered_sigma, f * entries);
  sums.variance_parts = place(sums.count, requested.shares, m * plan_.encoders);
  sums.share = place(sums.count, requested.shares, m * plan_.encoders);
  sums.worst_share = place(sums.count, requested.shares, m * plan_.encoders);
  plan_.quantization_parts = requested.shares && !plan_.plain;
  sums.quantization_parts = place(sums.count, plan_.quantization_parts, m * plan_.encoders);
  sums.arms = place(sums.count, requested.shares, plan_.encoders);
  sums.pitch = place(sums.count, plan_.any_euler, 1);
}

}  // namespace qerr
