#include "bound/proven/chain_bound.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <queue>

#include "core/solve.hpp"

namespace qerr {

namespace {

void add_error(ChainForm& form, const OperationalModel& model, const IndependentError& error) {
  const Eigen::VectorXd of_independent = moved_joints(model.transmission, error);
  DirectedError e;
  e.of_joints.resize(std::ssize(form));
  e.first = e.of_joints.size();
  double scale = 0;
  for (Eigen::Index k = 0; k < e.of_joints.size(); ++k) {
    const ChainJoint& joint = model.chain.joints[k];
    e.of_joints[k] = joint.multiplier * of_independent[joint.coordinate];
    if (e.of_joints[k] == 0) continue;
    if (scale == 0) scale = e.of_joints[k], e.first = k;
    e.last = k;
  }
  if (scale == 0) return;
  e.of_joints /= scale;
  e.half_width = error.half_width * std::abs(scale);
  e.mean = error.mean * scale;
  e.variance = std::pow(error.sigma * scale, 2);
  for (DirectedError& other : form.errors)
    if (other.of_joints == e.of_joints) {
      other.half_width += e.half_width;
      other.mean += e.mean;
      other.variance += e.variance;
      return;
    }
  form.errors.push_back(std::move(e));
}

void add_errors(ChainForm& form, const OperationalModel& model, const std::vector<Eigen::Matrix3d>& axes) {
  for (const IndependentError& e : independent_errors(model)) {
    if (e.where != IndependentError::Where::origin) {
      add_error(form, model, e);
      continue;
    }
    form.origins.push_back({e.link, e.link == 0 ? e.direction : axes[e.link - 1].transpose() * e.direction,
                            e.half_width, e.mean, e.sigma * e.sigma});
  }
}

void add_column(LocalError& e, double factor, bool prismatic, const Eigen::Vector3d& z,
                const Eigen::Vector3d& origin, double reach) {
  if (factor == 0) return;
  if (prismatic) {
    e.constant += factor * z;
    e.size += std::abs(factor);
    return;
  }
  e.axis += factor * z;
  e.constant -= factor * z.cross(origin);  // (u x z) . o = u . (z x o)
  e.size += std::abs(factor) * reach;
  e.moment += std::abs(factor);
}

bool of_neighbours(const DirectedError& e) { return e.last - e.first <= 1; }

/// The column of an error of one joint or of two neighbours, in the moved frame of the first.
LocalError local(const ChainForm& form, const std::vector<double>& reach, const DirectedError& e,
                 double width) {
  LocalError sum;
  sum.width = width;
  for (Eigen::Index k = e.first; k <= e.last; ++k) {
    const auto joint = static_cast<std::size_t>(k);
    const ChainStep& step = form.steps[joint];
    const bool next = k > e.first;
    add_column(sum, e.of_joints[k], step.prismatic,
               next ? Eigen::Vector3d(step.rotation.col(2)) : Eigen::Vector3d::UnitZ(),
               next ? step.translation : Eigen::Vector3d::Zero(), reach[joint + 1]);
  }
  return sum;
}

void add_own_column(const ChainForm& form, const std::vector<double>& reach, std::size_t joint, double factor,
                    LocalError& sum) {
  add_column(sum, factor, form.steps[joint].prismatic, Eigen::Vector3d::UnitZ(), Eigen::Vector3d::Zero(),
             reach[joint + 1]);
}

/// A recursion and the grids on which it is worth its time: the error falls as 1/cells^2.
struct ChainRecursion {
  std::function<double(const ChainForm&, double cells)> bound;
  double coarsest, finest;
};

/// At most so many errors have their signs chosen one by one: 2^6 recursions.
constexpr std::size_t most_distant_errors = 7;

Eigen::Vector3d axis_of(Coordinate c) {
  return Eigen::Vector3d::Unit(static_cast<Eigen::Index>(c) -
                               static_cast<Eigen::Index>(is_position(c) ? Coordinate::x : Coordinate::rx));
}

/// The finest grids for a gap: the error of a grid of `at_one_percent` cells is less than 1 % for most
/// chains.
double finest(double at_one_percent, double gap, double most) {
  return std::min(most, std::ceil(at_one_percent * std::sqrt(0.01 / std::max(gap, 1e-6))));
}

std::optional<ChainRecursion> recursion_of(const OperationalModel& model, Coordinate c, bool worst,
                                           double gap) {
  const bool tip = model.frame == CoordinateFrame::tip;
  if (is_rotation_vector(c) || c == Coordinate::rxyz) {
    std::vector<Eigen::Vector3d> directions;
    if (c != Coordinate::rxyz) directions.push_back(axis_of(c));
    const RotationAxes axes = tip && !directions.empty() ? RotationAxes::tip : RotationAxes::base;
    return ChainRecursion{[=](const ChainForm& form, double cells) {
                            const auto bound = worst ? rotation_worst_case_bound : rotation_sigma_bound;
                            const RotationBound b = bound(form, axes, directions, cells);
                            return directions.empty() ? b.length : b.along[0];
                          },
                          24, finest(60, gap, 400)};
  }
  if (c == Coordinate::xyz && !worst) return ChainRecursion{position_sigma_bound, 12, finest(40, gap, 160)};
  if (worst && (c == Coordinate::xyz || (is_position(c) && !tip))) {
    std::vector<Eigen::Vector3d> directions;
    if (c != Coordinate::xyz) directions.push_back(axis_of(c));
    return ChainRecursion{[=](const ChainForm& form, double cells) {
                            const PositionWorstCase b = position_worst_case_bound(form, directions, cells);
                            return directions.empty() ? b.length : b.along[0];
                          },
                          10, finest(32, gap, 56)};
  }
  if (!worst && is_position(c) && !tip)
    return ChainRecursion{[=](const ChainForm& form, double cells) {
                            return component_sigma_bound(form, {axis_of(c)}, cells)[0];
                          },
                          8, finest(36, gap, 40)};
  if (is_position(c))
    return ChainRecursion{[=](const ChainForm& form, double cells) {
                            const TipFigure own = worst ? TipFigure::worst_case : TipFigure::sigma;
                            return tip_component_bound(form, own, {axis_of(c)}, cells)[0];
                          },
                          10, finest(32, gap, 56)};
  return std::nullopt;
}

/// The figure from the bound of what the recursion covers: adds origins where that has not, and the errors
/// along a motion.
double with_constants(const OperationalModel& model, const ChainForm& form, Coordinate c, bool worst,
                      double bound) {
  double width = 0, variance = 0;
  for (const DirectedOrigin& o : form.origins) {
    width += std::abs(o.mean) + o.half_width;
    variance += o.variance;
  }
  if (c != Coordinate::xyz) width = variance = 0;
  if (model.along_motion) {
    const SignalMoments& tip = model.along_motion->tip;
    double squares = 0;
    for (std::size_t i = 0; i < model.coordinates.size(); ++i) {
      const Coordinate own = model.coordinates[i];
      const bool part =
          own == c || (is_length(c) && !is_euler_angle(own) && is_position(own) == (c == Coordinate::xyz));
      if (!part) continue;
      squares += tip.peak[i] * tip.peak[i];
      variance += tip.covariance(i, i);
    }
    width += std::sqrt(squares);
  }
  return (worst ? bound + width : std::sqrt(bound * bound + variance)) * (1 + 1e-14);
}

/// The bound of a form on finer grids until it is at most `enough`. The next grid is that at which the error
/// would be within, as it falls as 1/cells^2.
double refined(const ChainRecursion& r, const std::function<double(double)>& figure, const ChainForm& form,
               double lower, double enough) {
  double best = INFINITY;
  for (double cells = std::min(r.coarsest, r.finest);;) {
    best = std::min(best, figure(r.bound(form, cells)));
    if (best <= enough || cells >= r.finest) return best;
    const double wanted = enough > lower ? 1.1 * std::sqrt((best - lower) / (enough - lower)) : 4;
    cells = std::min(r.finest, std::ceil(cells * std::clamp(wanted, 1.25, 4.0)));
  }
}

/// Independent joints that move several joints of the chain.
std::vector<std::size_t> masters(const OperationalModel& model) {
  std::vector<std::size_t> moved(model.chain.independent.size()), found;
  for (const ChainJoint& joint : model.chain.joints)
    if (++moved[joint.coordinate] == 2) found.push_back(joint.coordinate);
  return found;
}

/// Within a part of the ranges of the masters, the joints that one of them moves are relaxed to independent
/// ones.
struct Part {
  std::vector<Limits> ranges;
  double bound;
  std::size_t order;  ///< of its making; breaks ties
  int depth;
  bool operator<(const Part& other) const {
    return bound != other.bound ? bound < other.bound : order > other.order;
  }
};

/// Best-first bisection of the widest range of a master. The relaxation's error falls in proportion to the
/// width of a part, that of the grids as 1/cells^2: six bisections for each doubling of the cells leave the
/// grids the smaller error at a coarse start, and keep small parts cheap.
double split_masters(const OperationalModel& model, const std::vector<Limits>& ranges,
                     const std::vector<std::size_t>& dependent, const ChainRecursion& r,
                     const std::function<double(double)>& figure, double enough, std::size_t most_parts) {
  const auto set_bound = [&](Part& part) {
    const double cells = std::min(r.finest, std::ceil(r.coarsest * std::exp2(part.depth / 6.0)));
    part.bound = std::min(part.bound, figure(r.bound(chain_form(model, part.ranges), cells)));
  };
  std::priority_queue<Part> open;
  std::size_t made = 0;
  Part whole{ranges, INFINITY, made++, 0};
  set_bound(whole);
  open.push(whole);
  while (open.top().bound > enough && made < most_parts) {
    const Part part = open.top();
    open.pop();
    const auto width = [&](std::size_t d) { return part.ranges[d].upper - part.ranges[d].lower; };
    const std::size_t widest = *std::ranges::max_element(
        dependent, [&](std::size_t a, std::size_t b) { return width(a) < width(b); });
    for (const bool first : {true, false}) {
      Part half = part;
      const double middle = 0.5 * (part.ranges[widest].lower + part.ranges[widest].upper);
      (first ? half.ranges[widest].upper : half.ranges[widest].lower) = middle;
      half.order = made++;
      ++half.depth;
      set_bound(half);
      open.push(half);
    }
  }
  return open.top().bound;
}

/// Errors that move joints further apart than neighbours.
std::size_t distant_errors(const ChainForm& form) {
  std::size_t distant = 0;
  for (const DirectedError& e : form.errors) distant += e.last - e.first > 1;
  return distant;
}

/// One error and nothing else has the sigma of its coordinate in proportion to its worst case: signs instead
/// of a relaxation.
bool one_error(const ChainForm& form) { return form.errors.size() == 1 && form.origins.empty(); }

ChainForm with_sigma_as_width(ChainForm form) {
  form.errors[0].half_width = std::sqrt(form.errors[0].variance);
  form.errors[0].mean = 0;
  return form;
}

}  // namespace

ChainForm chain_form(const OperationalModel& model, const std::vector<Limits>& ranges) {
  ChainForm form;
  std::vector<Eigen::Matrix3d> axes;
  Eigen::Matrix3d last = Eigen::Matrix3d::Identity();
  for (const ChainJoint& joint : model.chain.joints) {
    axes.push_back(frame_of_axis(joint.axis));
    ChainStep step;
    step.rotation = last.transpose() * joint.origin.linear() * axes.back();
    step.translation = last.transpose() * joint.origin.translation();
    step.prismatic = joint.prismatic;
    step.coordinate = joint.coordinate;
    const double a = joint.multiplier * ranges[joint.coordinate].lower + joint.offset,
                 b = joint.multiplier * ranges[joint.coordinate].upper + joint.offset;
    step.lower = std::min(a, b);
    step.upper = std::max(a, b);
    form.steps.push_back(step);
    last = axes.back();
  }
  form.tip.linear() = last.transpose() * model.chain.tip_offset.linear();
  form.tip.translation() = last.transpose() * model.chain.tip_offset.translation();
  form.tip.makeAffine();
  add_errors(form, model, axes);
  return form;
}

std::vector<std::vector<double>> distant_signs(const ChainForm& form) {
  std::size_t distant = 0;
  bool means = false;
  for (const DirectedError& e : form.errors) distant += e.last - e.first > 1, means = means || e.mean != 0;
  for (const DirectedOrigin& o : form.origins) means = means || o.mean != 0;
  std::vector<std::vector<double>> all;
  for (std::size_t c = 0; c < std::size_t{1} << (distant > 0 && !means ? distant - 1 : distant); ++c) {
    all.emplace_back();
    for (std::size_t i = 0; i < distant; ++i) all.back().push_back(c >> i & 1 ? 1 : -1);
  }
  return all;
}

std::vector<double> ChainForm::reaches() const {
  std::vector<double> reach(size() + 1);
  reach[size()] = tip.translation().norm();
  for (std::size_t k = size(); k-- > 0;) {
    const ChainStep& s = steps[k];
    // The fixed transform and a prismatic motion together; both ends, as the distance is convex.
    double offset = s.translation.norm();
    if (s.prismatic)
      for (const double motion : {s.lower, s.upper})
        offset = std::max(offset, (s.translation + motion * s.rotation.col(2)).norm());
    reach[k] = (offset + reach[k + 1]) * (1 + 1e-14);
  }
  return reach;
}

std::vector<FrameErrors> worst_case_errors(const ChainForm& form, const std::vector<double>& distant_signs) {
  const std::vector<double> reach = form.reaches();
  std::vector<FrameErrors> frames(form.size() + 1);
  std::size_t distant = 0;
  for (const DirectedError& e : form.errors) {
    const bool near = of_neighbours(e);
    const double fixed = e.mean + (near ? 0 : distant_signs[distant++] * e.half_width);
    for (Eigen::Index k = e.first; k <= e.last; ++k) {
      const auto joint = static_cast<std::size_t>(k);
      add_own_column(form, reach, joint, fixed * e.of_joints[k], frames[joint + 1].fixed);
    }
    if (near && e.half_width > 0)
      frames[static_cast<std::size_t>(e.first) + 1].independent.push_back(
          local(form, reach, e, e.half_width));
  }
  return frames;
}

std::vector<FrameErrors> sigma_errors(const ChainForm& form) {
  const std::vector<double> reach = form.reaches();
  std::vector<FrameErrors> frames(form.size() + 1);
  for (const DirectedError& e : form.errors) {
    if (e.variance == 0) continue;
    if (of_neighbours(e)) {
      frames[static_cast<std::size_t>(e.first) + 1].independent.push_back(
          local(form, reach, e, std::sqrt(e.variance)));
      continue;
    }
    double whole = 0;
    std::vector<LocalError> parts(form.size());
    for (Eigen::Index k = e.first; k <= e.last; ++k) {
      const auto joint = static_cast<std::size_t>(k);
      add_own_column(form, reach, joint, e.of_joints[k], parts[joint]);
      whole += parts[joint].size;
    }
    for (std::size_t joint = 0; joint < parts.size(); ++joint) {
      if (parts[joint].size == 0) continue;
      parts[joint].width = std::sqrt(e.variance * whole / parts[joint].size);
      frames[joint + 1].independent.push_back(parts[joint]);
    }
  }
  return frames;
}

std::vector<double> reaches_before_motion(const ChainForm& form) {
  std::vector<double> reach = form.reaches();
  for (std::size_t k = 0; k < form.size(); ++k)
    if (form.steps[k].prismatic)
      reach[k + 1] += std::max(std::abs(form.steps[k].lower), std::abs(form.steps[k].upper));
  return reach;
}

std::optional<double> chain_upper_bound(const OperationalModel& model, const std::vector<Limits>& ranges,
                                        const Figure& wanted, double known_lower, double gap) {
  const Coordinate c = *all_signals(model).at(wanted.signal).coordinate;
  const ChainForm form = chain_form(model, ranges);
  for (const ChainStep& step : form.steps)
    if (!std::isfinite(step.lower) || !std::isfinite(step.upper)) return std::nullopt;
  const std::size_t distant = distant_errors(form);
  const bool as_worst_case = is_sigma(wanted.bound) && distant > 0 && one_error(form);
  const bool relaxed = is_sigma(wanted.bound) && distant > 0 && !as_worst_case;
  std::optional<ChainRecursion> r = recursion_of(model, c, as_worst_case || !is_sigma(wanted.bound), gap);
  if (!r || (!is_sigma(wanted.bound) && distant > most_distant_errors)) return std::nullopt;
  if (as_worst_case)
    r->bound = [own = r->bound](const ChainForm& f, double cells) {
      return own(with_sigma_as_width(f), cells);
    };
  // What the relaxation adds is not reduced by finer grids.
  if (relaxed) r->finest = std::min(r->finest, 2 * r->coarsest);
  const auto figure = [&](double bound) {
    return with_constants(model, form, c, !is_sigma(wanted.bound), bound);
  };
  const std::vector<std::size_t> dependent = masters(model);
  if (dependent.empty()) return refined(*r, figure, form, known_lower, known_lower * (1 + gap));
  return split_masters(model, ranges, dependent, *r, figure, known_lower * (1 + gap), relaxed ? 40 : 400);
}

}  // namespace qerr
