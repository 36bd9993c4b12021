#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "qerr/bound/proven_maximum.hpp"
#include "qerr/bound/workspace.hpp"
#include "qerr/core/error.hpp"
#include "qerr/core/quantity.hpp"

namespace qerr {

/// A figure of a filter itself that may be required: `velocity.delay`.
struct FilterFigure {
  std::string_view name;
  std::string_view summary;
  Dimension (*dimension)(const Filter&);
  std::optional<double> (*value)(const Filter&, const Norms&);  ///< empty: the filter has none
  bool norm = false;                                            ///< in 1/s^derivative
};

std::span<const FilterFigure> filter_figures();

/// The figure of a name; null: unknown.
const FilterFigure* find_filter_figure(std::string_view name);

/// Its SI unit: of a norm `1/s`, which `Hz` would hide.
std::string figure_unit(const FilterFigure&, const Filter&);

/// An entry of `requirements:` in a spec: a limit of a statistic of a bound, of a figure of a filter, or of
/// the rate of an encoder's counts.
struct Requirement : Figure {
  std::string quantity;                        ///< as in the spec: `velocity.x.sigma`, `velocity.delay`
  std::string statistic;                       ///< as in the spec: `p99`; "" for a figure of a filter
  const FilterFigure* figure = nullptr;        ///< of `filter`; null: a bound of a coordinate
  std::ptrdiff_t counter = -1;                 ///< index of the encoder whose count rate is limited; -1: none
  bool of_control = false;                     ///< `quantity` is a figure of a loop or of a wall
  double Statistic::*value = &Statistic::max;  ///< member of Statistic for `statistic`, unless `proven`
  bool proven = false;                         ///< `statistic` is the proven maximum
  bool at_least = false;                       ///< the limit is the lowest value; else the highest
  double limit = 0;                            ///< in `unit` [SI]
  std::string unit;
  Place place;

  /// `velocity.x.sigma p99`, `velocity.delay`.
  std::string name() const { return statistic.empty() ? quantity : quantity + ' ' + statistic; }
  std::string_view relation() const { return at_least ? "at_least" : "at_most"; }
  /// Whether it limits an error over the configurations.
  bool limits_error() const { return !figure && counter < 0 && !of_control; }
  /// A value that equals the limit meets it.
  /// An unbounded error, as of an unstable loop, meets no limit.
  bool met_by(double value_of_it) const {
    if (!at_least) return value_of_it <= limit;
    return value_of_it >= limit && !(limits_error() && std::isinf(value_of_it));
  }
};

/// Evaluation of a requirement.
struct RequirementResult {
  double value = 0;  ///< +inf if the quantity is unbounded
  bool met = false;
  Eigen::VectorXd at_max = {};               ///< where the quantity is largest [rad or m]; empty for a filter
  std::optional<ProvenMaximum> proven = {};  ///< of a requirement on the proven maximum

  /// Whether the limit lies between what is reached and what is proven: neither holds nor fails for certain.
  bool undecided = false;
};

/// Compares a statistic over the configurations, or a figure of a filter, with the limit.
/// @param filters, norms  of the spec, in its order
/// @throws Error (input) if the figure is not known: sigma in motion without a motion, the bandwidth of a
/// filter that has none, a proven maximum
RequirementResult evaluate(const Requirement&, const Workspace&, const std::vector<Filter>& filters,
                           const std::vector<Norms>& norms);

/// Compares a value that is known: that of an encoder's count rate.
RequirementResult evaluate(const Requirement&, double value);

/// The figure whose maximum a requirement on the proven maximum limits.
/// @pre r.proven
/// @throws Error (input; key `requirements`) if the figure is not known: sigma behind a filter, with sources
/// of unknown spectrum
Figure proven_figure(const Requirement& r, const OperationalModel&);

/// Compares a proven maximum with the limit. `at_most` is judged by `upper`, which no configuration exceeds,
/// and `at_least` by `lower`, which one reaches: what is met is proven. Where the limit lies between the two
/// the requirement is not met, and undecided.
RequirementResult evaluate(const Requirement&, const ProvenMaximum&);

/// The gap at which the proof of an undecided requirement is repeated: that at which the limit decides, but
/// no less than a tenth of the first one.
double deciding_gap(const Requirement&, const ProvenMaximum&, double gap);

}  // namespace qerr
