#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "bound/signals/signals.hpp"
#include "control/control.hpp"
#include "control/loop_response.hpp"
#include "core/text.hpp"
#include "qerr/kinematics/configurations.hpp"
#include "report/analysis/figures.hpp"
#include "report/design/design_solver.hpp"

namespace qerr {

namespace {

/// In place of infinity: an unbounded coordinate exceeds every limit, and times 0 is 0.
constexpr double beyond_all = 1e300;

ChoiceFigure::Over over_of(const Requirement& r) {
  using Over = ChoiceFigure::Over;
  return r.value == &Statistic::min    ? Over::least
         : r.value == &Statistic::mean ? Over::mean
         : r.value == &Statistic::max  ? Over::largest
                                       : Over::percentile;
}

double percentile_of(const Requirement& r) {
  for (const StatisticKind& kind : statistic_kinds())
    if (kind.value == r.value) return kind.percentile;
  return 0;
}

bool vary(const ErrorWeights& a, const ErrorWeights& b, Eigen::Index k) {
  if (a.half_width[k] != b.half_width[k] || a.mean[k] != b.mean[k] || a.variance[k] != b.variance[k])
    return true;
  for (std::size_t f = 0; f < a.filtered.size(); ++f)
    for (const auto member :
         {&ErrorWeights::Filtered::variance, &ErrorWeights::Filtered::variance_in_motion}) {
      const Eigen::VectorXd &x = a.filtered[f].*member, &y = b.filtered[f].*member;
      if (x.size() > 0 && y.size() > 0 && x[k] != y[k]) return true;
    }
  return false;
}

/// Errors along a motion are the same signals with either encoder.
bool same_along_motion(const ErrorWeights& a, const ErrorWeights& b) {
  if (a.added_worst != b.added_worst || a.added_variance != b.added_variance) return false;
  for (std::size_t f = 0; f < a.filtered.size(); ++f)
    if (a.filtered[f].added_worst != b.filtered[f].added_worst ||
        a.filtered[f].added_variance != b.filtered[f].added_variance)
      return false;
  return true;
}

/// Weights of a column in a worst case: half width + sign * mean, behind the requirement's filter.
double worst_weight(const Requirement& r, const ErrorWeights& w, Eigen::Index k, double sign) {
  if (r.filter < 0) return w.half_width[k] + sign * w.mean[k];
  const ErrorWeights::Filtered& f = w.filtered[r.filter];
  return f.l1 * w.half_width[k] + sign * f.dc_gain * w.mean[k];
}

template <class Weight>
void add_column(WeightedSum& sum, std::size_t column, const double* coefficients,
                const OptionWeights& weights, Weight weight) {
  const std::size_t j = weights.owners[column];
  WeightedColumn added{j, coefficients, {}};
  for (const ErrorWeights& w : weights.options[j]) added.weights.push_back(weight(w, column));
  if (std::ranges::any_of(added.weights, [](double w) { return w != 0; }))
    sum.columns.push_back(std::move(added));
}

/// Whether no option gives the column's error a mean.
bool is_symmetric(const OptionWeights& weights, std::size_t column) {
  const auto& options = weights.options[weights.owners[column]];
  return std::ranges::all_of(options, [&](const ErrorWeights& w) { return w.mean[column] == 0; });
}

/// The direction in which the sum of +-g_i is longest, by ascent from each generator: a local maximum, which
/// is the largest one but in rare cases.
Eigen::Vector3d longest_direction(const Eigen::Matrix3Xd& generators) {
  Eigen::Vector3d best = Eigen::Vector3d::UnitX();
  double longest = 0;
  for (Eigen::Index start = 0; start < generators.cols(); ++start) {
    Eigen::Vector3d direction = generators.col(start);
    double length = 0;
    for (int i = 0; i < 8; ++i) {
      Eigen::Vector3d corner = Eigen::Vector3d::Zero();
      for (const auto& g : generators.colwise())
        corner += g.dot(direction) < 0 ? Eigen::Vector3d(-g) : Eigen::Vector3d(g);
      if (!(corner.norm() > length)) break;
      length = corner.norm();
      direction = corner;
    }
    if (length > longest) {
      longest = length;
      best = direction / direction.norm();
    }
  }
  return best;
}

constexpr double never = 1e300;  ///< an unstable loop: beyond every limit, and times 0 it is 0

ControlFigure figure_of(const Requirement& r, const Spec& spec) {
  for (ControlFigure& f : control_figures(*spec.model.control, spec.model.chain))
    if (f.name == r.quantity) return f;
  throw std::logic_error("no figure " + r.quantity);
}

}  // namespace

void find_owners(OptionWeights& weights, const Spec& spec) {
  const std::size_t columns = static_cast<std::size_t>(weights.stated.mean.size());
  weights.owners.assign(columns, 0);
  weights.biased = weights.stated.biased();
  std::vector<bool> owned(columns);
  for (std::size_t j = 0; j < weights.options.size(); ++j)
    for (const ErrorWeights& w : weights.options[j]) {
      weights.biased = weights.biased || w.biased();
      const std::string name = quoted(spec.model.chain.independent[j].name);
      weights.along_motion = weights.along_motion || !same_along_motion(w, weights.stated);
      for (std::size_t k = 0; k < columns; ++k) {
        if (!vary(w, weights.stated, k)) continue;
        if (owned[k] && weights.owners[k] != j)
          throw spec_error(spec, "effects",
                           "the options of joint " + name + " change the errors of another one", "",
                           "choose no encoder for one of them");
        owned[k] = true;
        weights.owners[k] = j;
      }
    }
}

const double* FigureSums::part(std::size_t coordinate, std::size_t column, ColumnPart kind) {
  const double* const from = columns_.column(coordinate, column);
  AlignedNumbers& to = parts_[{coordinate, column, kind}];
  if (to.size() > 0) return to.data();
  to = AlignedNumbers(columns_.configurations());
  for (std::size_t i = 0; i < to.size(); ++i) {
    const double a = std::clamp(from[i], -beyond_all, beyond_all);
    to[i] = kind == ColumnPart::magnitude  ? std::abs(a)
            : kind == ColumnPart::positive ? std::max(a, 0.0)
            : kind == ColumnPart::negative ? std::max(-a, 0.0)
                                           : std::min(a * a, beyond_all);
  }
  return to.data();
}

/// Index of the coordinate that is a component of the requirement's length.
std::size_t FigureSums::component(const Requirement& r, std::size_t axis) const {
  const Coordinate length = *all_signals(spec_.model)[r.signal].coordinate;
  const auto wanted = static_cast<Coordinate>(static_cast<std::size_t>(first_component(length)) + axis);
  const auto& all = spec_.model.coordinates;
  return std::ranges::find(all, wanted) - all.begin();
}

bool FigureSums::is_of_length(const Requirement& r) const {
  return is_length(all_signals(spec_.model)[r.signal]);
}

/// Row of a signal in the columns, which has no lengths.
std::size_t FigureSums::row_of(const Requirement& r) const {
  return r.signal < spec_.model.coordinates.size() ? r.signal : r.signal - spec_.model.lengths.size();
}

const double* FigureSums::squares_of_length(const Requirement& r, std::size_t column) {
  AlignedNumbers& to = squares_of_lengths_[{r.signal, column}];
  if (to.size() > 0) return to.data();
  AlignedNumbers sum(columns_.configurations());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double* const squares = part(component(r, axis), column, ColumnPart::square);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += squares[i];
  }
  return (squares_of_lengths_[{r.signal, column}] = std::move(sum)).data();
}

WeightedSum FigureSums::sigma_sum(const Requirement& r, const OptionWeights& weights) {
  const bool length = is_of_length(r);
  const auto f = static_cast<std::size_t>(std::max<std::ptrdiff_t>(r.filter, 0));
  const bool in_motion = r.bound == Bound::sigma_in_motion;
  const bool alone = r.bound == Bound::sigma_quantization;
  const auto unknown = [&](const ErrorWeights& w) {
    const ErrorWeights::Filtered& behind = w.filtered[f];
    return !alone && (in_motion ? behind.variance_in_motion : behind.variance).size() == 0;
  };
  bool any_unknown = r.filter >= 0 && unknown(weights.stated);
  for (const auto& of_joint : weights.options)
    for (const ErrorWeights& w : of_joint) any_unknown = any_unknown || (r.filter >= 0 && unknown(w));
  if (any_unknown)
    throw requirement_error(
        r,
        "sigma behind a filter is not known: what an effect, or an error within an encoder's "
        "accuracy, adds to it depends on the motion",
        "add `motion:`, or velocity to the <limit> of the joints in the URDF; or require the "
        "worst case or sigma_quantization");
  const Eigen::VectorXd& added =
      r.filter < 0 ? weights.stated.added_variance : weights.stated.filtered[f].added_variance;
  WeightedSum sum;
  for (std::size_t axis = 0; axis < (length ? 3 : 1) && !alone && !weights.along_motion; ++axis)
    sum.added += added[length ? component(r, axis) : row_of(r)];
  for (std::size_t k = 0; k < columns_.columns(); ++k)
    add_column(sum, k, length ? squares_of_length(r, k) : part(row_of(r), k, ColumnPart::square), weights,
               [&](const ErrorWeights& w, Eigen::Index column) {
                 return r.filter < 0 ? w.variance[column]
                        : alone      ? w.filtered[f].variance_of_quantization[column]
                        : in_motion  ? w.filtered[f].variance_in_motion[column]
                                     : w.filtered[f].variance[column];
               });
  return sum;
}

/// The worst case of a coordinate: |A| h, or the larger of two sums where errors have a mean (ChoiceFigure).
std::vector<WeightedSum> FigureSums::worst_sums(const Requirement& r, const OptionWeights& weights,
                                                std::size_t coordinate) {
  const auto f = static_cast<std::size_t>(std::max<std::ptrdiff_t>(r.filter, 0));
  const Eigen::VectorXd& added =
      r.filter < 0 ? weights.stated.added_worst : weights.stated.filtered[f].added_worst;
  std::vector<WeightedSum> sums(weights.biased ? 2 : 1);
  for (std::size_t s = 0; s < sums.size(); ++s) {
    sums[s].added = weights.along_motion ? 0 : added[coordinate];
    const auto add = [&](std::size_t k, ColumnPart kind, double sign) {
      add_column(
          sums[s], k, part(coordinate, k, kind), weights,
          [&](const ErrorWeights& w, Eigen::Index column) { return worst_weight(r, w, column, sign); });
    };
    for (std::size_t k = 0; k < columns_.columns(); ++k) {
      const double sign = s == 0 ? 1 : -1;
      if (is_symmetric(weights, k)) {
        add(k, ColumnPart::magnitude, 0);
      } else {
        add(k, ColumnPart::positive, sign);
        add(k, ColumnPart::negative, -sign);
      }
    }
  }
  return sums;
}

/// The component of a length in the direction of its largest for the reference, with either sign.
std::vector<WeightedSum> FigureSums::length_sums(const Requirement& r, const OptionWeights& weights,
                                                 const OptionChoice& reference) {
  const std::size_t n = columns_.configurations(), count = columns_.columns();
  std::vector<AlignedNumbers> positive, negative;
  for (std::size_t k = 0; k < count; ++k) {
    positive.emplace_back(n);
    negative.emplace_back(n);
  }
  std::vector<double> half_widths;
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t j = weights.owners[k];
    half_widths.push_back(worst_weight(r, weights.options[j][reference[j]], k, 0));
  }
  Eigen::Matrix3Xd columns(3, count);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < count; ++k)
      for (std::size_t axis = 0; axis < 3; ++axis)
        columns(axis, k) = columns_.column(component(r, axis), k)[i];
    const Eigen::Map<const Eigen::VectorXd> widths(half_widths.data(), count);
    const Eigen::Vector3d direction = longest_direction(columns * widths.asDiagonal());
    for (std::size_t k = 0; k < count; ++k) {
      const double along = direction.dot(columns.col(k));
      positive[k][i] = std::max(along, 0.0);
      negative[k][i] = std::max(-along, 0.0);
    }
  }
  std::vector<WeightedSum> sums(weights.biased ? 2 : 1);
  for (std::size_t s = 0; s < sums.size(); ++s)
    for (std::size_t k = 0; k < count; ++k)
      for (const bool forward : {true, false}) {
        const double sign = is_symmetric(weights, k) ? 0 : forward == (s == 0) ? 1 : -1;
        add_column(
            sums[s], k, (forward ? positive : negative)[k].data(), weights,
            [&](const ErrorWeights& w, Eigen::Index column) { return worst_weight(r, w, column, sign); });
      }
  for (auto* parts : {&positive, &negative})
    for (AlignedNumbers& numbers : *parts) along_.push_back(std::move(numbers));
  return sums;
}

ChoiceFigure FigureSums::figure(const Requirement& r, const OptionWeights& weights,
                                const OptionChoice& reference) {
  ChoiceFigure figure;
  if (!r.limits_error()) return figure;
  // What is proven over the joint ranges is at least what is sampled in them.
  const bool proven = r.statistic == "proven_max";
  figure.over = proven ? ChoiceFigure::Over::largest : over_of(r);
  figure.percentile = proven ? 0 : std::max(0.0, percentile_of(r));
  // Beyond the limit of exact percentiles those of a report are counted in bins, right to 1e-3.
  if (figure.over == ChoiceFigure::Over::percentile && columns_.configurations() > exact_percentiles_limit)
    figure.tolerance = 2e-3;
  // Errors along a motion do not add by joints: without them the sums are a lower bound, and dearer options
  // may have less of them.
  const bool follows = weights.along_motion && r.bound != Bound::sigma_quantization;
  figure.monotone = !follows;
  if (r.bound != Bound::worst_case && r.bound != Bound::worst_case_rigorous) {
    figure.root = true;
    figure.bound = proven || follows;
    figure.sums = {sigma_sum(r, weights)};
    return figure;
  }
  const bool length = is_of_length(r);
  figure.bound = proven || length || follows || r.bound == Bound::worst_case_rigorous;
  if (!length) {
    figure.sums = worst_sums(r, weights, row_of(r));
    return figure;
  }
  figure.sums = length_sums(r, weights, reference);
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (WeightedSum& sum : worst_sums(r, weights, component(r, axis))) figure.sums.push_back(std::move(sum));
  return figure;
}

double ratio_limit(const Requirement& r, double limit) {
  if (std::isinf(limit)) return limit;
  return r.at_least ? r.limit / limit : limit / r.limit;
}

void require_limit_of_control(const Requirement& r, const Spec& spec) {
  using Kind = ControlFigure::Kind;
  const Kind kind = figure_of(r, spec).kind;
  if (kind == Kind::largest_kd)
    throw requirement_error(r, "the largest kd is no figure to choose encoders by",
                            "require the joint's torque itself, or vary kd in design.gains", r.name());
  const bool one_way = kind == Kind::wall_stiffness || kind == Kind::limit_cycle;
  if (one_way && r.at_least != (kind == Kind::wall_stiffness))
    throw requirement_error(r, "is no limit of a design: finer encoders only move away from it",
                            "write " + std::string(r.at_least ? "at_most" : "at_least"), r.name());
  if (!(r.limit > 0))
    throw requirement_error(r, "the limit of a loop or a wall must be above 0 in a design",
                            "leave it to `qerr check`", r.name());
}

ControlSums::ControlSums(const Spec& spec, std::size_t configurations,
                         std::vector<std::vector<double>> resolutions)
    : spec_(spec), configurations_(configurations), widths_(std::move(resolutions)) {
  for (std::size_t j = 0; spec_.model.control && j < widths_.size(); ++j)
    for (double& width : widths_[j]) width = 2 * spec_.model.control->joints[j].reading.half_width(width);
  drawn_ = draw(spec_.configurations, 0, configurations_);
  if (any_of_control(spec_)) report_ = control_report(spec_, true);
}

double* ControlSums::new_column() { return columns_.emplace_back(AlignedNumbers(configurations_)).data(); }

ChoiceFigure ControlSums::figure(const Requirement& r, const OptionWeights& weights) {
  if (!r.of_control) return closed(r, weights);
  const ControlFigure f = figure_of(r, spec_);
  if (f.kind == ControlFigure::Kind::wall_stiffness) return wall(r, f.index);
  for (const WorstLoop& loop : report_->loops)
    if (loop.joint == f.index && loop.stable && f.kind == ControlFigure::Kind::limit_cycle)
      return limit_cycle(r, loop);
  const double value = control_value(r, spec_, *report_),
               ratio = r.at_least ? r.limit / value : value / r.limit;
  ChoiceFigure figure;
  figure.sums = {{{},
                  std::isfinite(ratio) && value > 0 ? ratio
                  : r.at_least && std::isinf(value) ? 0
                                                    : never}};
  return figure;
}

/// The norms at each configuration, where only symmetric errors of the counts are in the figure.
ChoiceFigure ControlSums::closed(const Requirement& r, const OptionWeights& weights) {
  const bool worst = r.bound == Bound::worst_case;
  const auto errors = std::ssize(spec_.model.transmission.encoders);
  if (weights.biased || weights.along_motion || weights.stated.mean.size() != errors ||
      spec_.model.along_motion || (!worst && r.bound != Bound::sigma))
    return {};
  // What passes of an accuracy depends on the speed of its shaft.
  for (const auto& of_joint : weights.options)
    for (const ErrorWeights& w : of_joint)
      if (!(w.variance * 3).isApprox(w.half_width.cwiseAbs2(), 1e-9)) return {};
  const Signal signal = all_signals(spec_.model)[r.signal];
  const Eigen::MatrixXd moved = spec_.model.transmission.coupling.dense();
  std::vector<double*> columns;
  for (Eigen::Index e = 0; e < errors; ++e) columns.push_back(new_column());
  LoopsOfBatch batch(spec_.model.control, spec_.model.chain);
  constexpr auto in_a_batch = static_cast<Eigen::Index>(batch_size);
  for (std::size_t i = 0; i < configurations_; ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    if (at % in_a_batch == 0) batch.move_to(drawn_.middleCols(at, std::min(in_a_batch, drawn_.cols() - at)));
    const SignalNorms n =
        signal.kind->norms(spec_.model, signal.index, drawn_.col(at), moved, {&batch, at % in_a_batch});
    for (Eigen::Index e = 0; e < errors; ++e) {
      const double norm = worst ? n.l1[e] : n.h2[e] * n.h2[e];
      columns[e][i] = std::isfinite(norm) ? norm : never;
    }
  }
  ChoiceFigure figure;
  figure.over = r.value == &Statistic::min    ? ChoiceFigure::Over::least
                : r.value == &Statistic::mean ? ChoiceFigure::Over::mean
                                              : ChoiceFigure::Over::largest;
  if (figure.over == ChoiceFigure::Over::largest && r.value != &Statistic::max) return {};
  figure.root = !worst;
  WeightedSum sum;
  for (std::size_t e = 0; e < columns.size(); ++e) {
    WeightedColumn column{weights.owners[e], columns[e], {}};
    for (const ErrorWeights& w : weights.options[column.joint])
      column.weights.push_back((worst ? w.half_width : w.variance)[e]);
    sum.columns.push_back(std::move(column));
  }
  figure.sums = {std::move(sum)};
  return figure;
}

ChoiceFigure ControlSums::wall(const Requirement& r, std::size_t index) {
  const Control& control = *spec_.model.control;
  control_value(r, spec_, *report_);  // says what is missing, and refuses a wall that no joint feels
  const Eigen::MatrixXd coupling = spec_.model.transmission.coupling.dense();
  const auto count = static_cast<std::size_t>(coupling.cols());
  std::vector<double*> columns;
  for (std::size_t e = 0; e < count; ++e) columns.push_back(new_column());
  for (std::size_t i = 0; i < std::min(configurations_, configurations_of_control); ++i) {
    const Eigen::VectorXd g = felt_by(spec_.model.chain, control.walls[index], drawn_.col(i));
    double largest = 0;
    for (Eigen::Index j = 0; j < g.size(); ++j)
      if (g[j] != 0) largest = std::max(largest, std::abs(g[j]) / (2 * control.joints[j].friction.value()));
    const Eigen::VectorXd counted = (coupling.transpose() * g).cwiseAbs();
    for (std::size_t e = 0; e < count; ++e) columns[e][i] = std::min(r.limit * largest * counted[e], never);
  }
  ChoiceFigure figure;
  const double rate = report_->walls[index].sampling;
  figure.sums = {{{}, rate > 0 ? r.limit / rate : never}, {}};
  for (std::size_t e = 0; e < count; ++e) figure.sums[1].columns.push_back({e, columns[e], widths_[e]});
  return figure;
}

ChoiceFigure ControlSums::limit_cycle(const Requirement& r, const WorstLoop& loop) {
  if (spec_.model.control->joints[loop.joint].reading.of_position > 0) return {};  // no sum over the counts
  const Transmission& t = spec_.model.transmission;
  const Eigen::RowVectorXd parts = t.coupling.row(loop.joint).cwiseAbs();
  const double of_width = loop.cycle.bound / parts.dot(widths_at_rest(*spec_.model.control, resolutions(t)));
  ChoiceFigure figure;
  figure.sums = {{}};
  for (Eigen::Index e = 0; e < parts.size(); ++e) {
    if (parts[e] == 0) continue;
    double* const column = new_column();
    std::fill_n(column, configurations_, of_width * parts[e] / r.limit);
    figure.sums[0].columns.push_back({static_cast<std::size_t>(e), column, widths_[e]});
  }
  return figure;
}

}  // namespace qerr
