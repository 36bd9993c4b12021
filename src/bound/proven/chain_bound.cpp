#include "bound/proven/chain_bound.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <queue>

#include "bound/proven/chain_recursions.hpp"

namespace qerr {

namespace {

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
      const auto row = static_cast<Eigen::Index>(i);
      squares += tip.peak[row] * tip.peak[row];
      variance += tip.covariance(row, row);
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
    const std::size_t widest =
        *std::max_element(dependent.begin(), dependent.end(),
                          [&](std::size_t a, std::size_t b) { return width(a) < width(b); });
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
