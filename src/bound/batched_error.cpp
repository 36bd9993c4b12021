#include "bound/batched_error.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "bound/signal_errors.hpp"
#include "qerr/bound/independent_error.hpp"
#include "qerr/bound/workspace.hpp"

namespace qerr {
struct BatchedError::Plan {
  PlannedError error;
  const BoundKernels& kernels;
  OperationalModel model;
  ErrorFigures requested;
  InstructionSet set;
};

namespace {

/// Adds the error along a motion to the figures of a batch.
class AlongMotion {
 public:
  AlongMotion(const FigureLayout& layout, double* figures) : layout_(layout), figures_(figures) {}

  void add(const ErrorAlongMotion& error, const ErrorPlan& plan) {
    const std::size_t m = layout_.coordinates;
    for (std::size_t c = 0; c < plan.coordinates; ++c) {
      widen(layout_.worst_case + c, error.tip.peak[c]);
      if (plan.rigorous) widen(layout_.rigorous + c, error.tip.peak[c]);
      if (!plan.keep_covariance) scatter(layout_.sigma + c, error.tip.covariance(c, c));
      for (std::size_t f = 0; f < plan.filters; ++f) {
        const SignalMoments& behind = error.filtered[f];
        widen(layout_.filtered_worst + f * m + c, behind.peak[c]);
        scatter(layout_.filtered_sigma + f * m + c, behind.covariance(c, c));
        if (layout_.in_motion < layout_.trace)
          scatter(layout_.in_motion + f * m + c, behind.covariance(c, c));
      }
    }
  }

 private:
  void widen(std::size_t figure, double by) {
    for (std::size_t i = 0; i < batch_size; ++i) figures_[figure * batch_size + i] += by;
  }
  void scatter(std::size_t figure, double variance) {
    for (std::size_t i = 0; i < batch_size; ++i) {
      double& sigma = figures_[figure * batch_size + i];
      sigma = std::sqrt(sigma * sigma + variance);
    }
  }

  const FigureLayout& layout_;
  double* figures_;
};

bool any_of_kind(const std::vector<Coordinate>& coordinates, bool (*kind)(Coordinate)) {
  return std::ranges::any_of(coordinates, kind);
}

/// x y z, or x y z rx ry rz.
bool are_leading(const std::vector<Coordinate>& coordinates) {
  for (std::size_t i = 0; i < coordinates.size(); ++i)
    if (coordinates[i] != static_cast<Coordinate>(i)) return false;
  return coordinates.size() == 3 || coordinates.size() == 6;
}

}  // namespace

struct BatchedError::Work {
  AlignedNumbers scratch, sums;
  std::optional<LengthErrors> lengths;
  std::optional<SignalErrors> signals;

  explicit Work(const Plan& p)
      : scratch(p.kernels.scratch(p.error.plan())), sums(p.error.plan().sums.count * p.kernels.lanes) {
    const FigureLayout& layout = p.error.plan().figures;
    if (layout.coordinates == p.error.plan().coordinates) return;
    if (!p.model.lengths.empty()) lengths.emplace(p.model, p.requested, layout, p.set);
    if (!p.model.signals.empty()) signals.emplace(p.model, p.requested, layout);
  }
};

BatchedError::BatchedError(const OperationalModel& model, const ErrorFigures& requested, InstructionSet set)
    : plan_(new Plan{{model, requested}, select_kernels<BoundKernels>(set), model, requested, set}),
      work_(std::make_unique<Work>(*plan_)) {}

BatchedError::BatchedError(const BatchedError& other)
    : plan_(other.plan_), work_(std::make_unique<Work>(*plan_)) {}

BatchedError::~BatchedError() = default;

const FigureLayout& BatchedError::figures() const { return plan_->error.plan().figures; }
const SumLayout& BatchedError::sums() const { return plan_->error.plan().sums; }
bool BatchedError::own_worst_case() const { return plan_->error.plan().filtered_worst; }
bool BatchedError::has_sources() const { return plan_->error.plan().quantization_parts; }
bool BatchedError::own_sigma() const { return plan_->error.plan().filtered_sigma; }

void BatchedError::operator()(const double* q, double* figures) {
  plan_->kernels.errors(plan_->error.plan(), q, figures, work_->sums.data(), work_->scratch.data());
  if (plan_->model.along_motion)
    AlongMotion(this->figures(), figures).add(*plan_->model.along_motion, plan_->error.plan());
  if (work_->lengths) (*work_->lengths)(q, figures);
  if (work_->signals) (*work_->signals)(q, figures);
}

std::vector<double> BatchedError::take_sums() {
  const std::size_t lanes = plan_->kernels.lanes;
  std::vector<double> sums(this->sums().count);
  for (std::size_t s = 0; s < sums.size(); ++s)
    for (std::size_t i = 0; i < lanes; ++i) {
      double& lane = work_->sums[s * lanes + i];
      sums[s] = s < this->sums().arms ? sums[s] + lane : std::max(sums[s], lane);
      lane = 0;
    }
  return sums;
}

PlannedError::PlannedError(const OperationalModel& model, const ErrorFigures& requested)
    : chain_(fold(model.chain,
                  any_of_kind(model.coordinates, is_euler_angle) || model.frame == CoordinateFrame::tip)) {
  for (const FoldedJoint& joint : chain_.joints) column_scale_.push_back(joint.sign);
  set_coordinates(model);
  add_errors(model);
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
  set_layout(requested, requested.covariance ? 0 : model.lengths.size() + model.signals.size());
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

void PlannedError::add_errors(const OperationalModel& model) {
  plan_.encoders = model.transmission.encoders.size();
  const std::vector<IndependentError> errors = independent_errors(model);
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const IndependentError& e = errors[i];
    const bool source = i >= plan_.encoders;
    const double largest = source ? std::max({e.sigma, e.half_width, std::abs(e.mean)}) : e.sigma;
    add_error(model, e, source, largest > 0 ? largest : 1);
    if (!source) arm_.push_back(1 / e.sigma);
  }
}

void PlannedError::add_error(const OperationalModel& model, const IndependentError& e, bool source,
                             double scale) {
  std::vector<JointWeight>& weights = weights_.emplace_back();
  ErrorPart part{.sigma = e.sigma / scale,
                 .half_width = source ? e.half_width / scale : half_width_of_sigma,
                 .mean = e.mean / scale,
                 .width = source ? (std::abs(e.mean) + e.half_width) / scale : half_width_of_sigma,
                 .owner = e.owner,
                 .source = source};
  if (e.where == IndependentError::Where::origin) {
    const Eigen::Vector3d along = scale * e.direction;
    const Eigen::Vector3d direction =
        e.link == 0 ? along : Eigen::Vector3d(chain_.link_axes[e.link - 1] * along);
    part.link = e.link;
    std::ranges::copy(direction, part.direction);
  } else {
    const Eigen::VectorXd moved = scale * moved_joints(model.transmission, e);
    for (std::size_t k = 0; k < model.chain.joints.size(); ++k) {
      const ChainJoint& joint = model.chain.joints[k];
      const double weight = joint.multiplier * moved[joint.coordinate];
      if (weight != 0) weights.push_back({k, weight});
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
  plan_.direct = plan_.direct && std::ranges::count(part_of, parts_.size()) == 0;
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
    per_column_.push_back(scale > 0 ? r.per_column[k] / scale : 0);
  }
  plan_.per_column = per_column_.data();
}

void PlannedError::set_filters(const OperationalModel& model, const ErrorFigures& requested) {
  const std::vector<IndependentError> errors = independent_errors(model);
  const bool biased = !mean_errors(model.transmission).isZero(0);
  for (std::size_t f = 0; f < requested.filters.size(); ++f) {
    const Norms& norms = requested.filters[f];
    const Eigen::VectorXd ratios = sigma_ratios(errors, f, norms.h2),
                          beside = sigma_ratios(errors, f, norms.h2, true);
    const bool known = is_known(requested.noise_in_motion, f);
    l1_.push_back(norms.l1.upper);
    dc_gain_.push_back(std::abs(norms.dc_gain));
    Eigen::Index source = static_cast<Eigen::Index>(plan_.encoders);
    for (const ErrorPart& part : parts_) {  // of direct models in the order of the joints
      const Eigen::Index i = part.source ? source++ : static_cast<Eigen::Index>(part.owner);
      ratio_squares_.push_back(std::pow(part.sigma * ratios[i], 2));
      // noise_in_motion is in quantization intervals, sigma is 1/sqrt(12) of one.
      motion_squares_.push_back(!known        ? -1
                                : part.source ? std::pow(part.sigma * beside[i], 2)
                                              : 12 * std::pow(requested.noise_in_motion[f][i], 2));
    }
  }
  const bool others = !model.sources.empty() || model.along_motion;
  plan_.filters = requested.filters.size();
  plan_.filtered_worst = biased || others;
  plan_.filtered_sigma = others;
  plan_.l1 = l1_.data();
  plan_.dc_gain = dc_gain_.data();
  plan_.ratio_squares = ratio_squares_.data();
  plan_.motion_squares = motion_squares_.data();
}

void PlannedError::set_layout(const ErrorFigures& requested, std::size_t others) {
  plan_.keep_covariance = requested.covariance;
  plan_.shares = requested.shares;
  plan_.rigorous = requested.rigorous;
  const std::size_t m = plan_.coordinates, all = m + others, entries = m * (m + 1) / 2, f = plan_.filters;
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
