#include "report/design/control_sums.hpp"

#include <algorithm>
#include <cmath>

#include "control/figures.hpp"
#include "control/loop_response.hpp"
#include "control/walls.hpp"
#include "core/text.hpp"
#include "qerr/kinematics/configurations.hpp"

namespace qerr {

namespace {

constexpr double never = 1e300;  ///< an unstable loop: beyond every limit, and times 0 it is 0

ControlFigure figure_of(const Requirement& r, const Spec& spec) {
  for (ControlFigure& f : control_figures(*spec.model.control, spec.model.chain))
    if (f.name == r.quantity) return f;
  throw std::logic_error("no figure " + r.quantity);
}

}  // namespace

double ratio_limit(const Requirement& r, double limit) {
  if (std::isinf(limit)) return limit;
  return r.at_least ? r.limit / limit : limit / r.limit;
}

void require_limit_of_control(const Requirement& r, const Spec& spec) {
  using Kind = ControlFigure::Kind;
  const Kind kind = figure_of(r, spec).kind;
  if (kind == Kind::largest_kd)
    throw Error(Fault{r.place, "requirements", "the largest kd is no figure to choose encoders by",
                      quoted(r.name()), "require the joint's torque itself, or vary kd in design.gains"});
  const bool one_way = kind == Kind::wall_stiffness || kind == Kind::limit_cycle;
  if (one_way && r.at_least != (kind == Kind::wall_stiffness))
    throw Error(Fault{r.place, "requirements",
                      "is no limit of a design: finer encoders only move away from it", quoted(r.name()),
                      "write " + std::string(r.at_least ? "at_most" : "at_least")});
  if (!(r.limit > 0))
    throw Error(Fault{r.place, "requirements", "the limit of a loop or a wall must be above 0 in a design",
                      quoted(r.name()), "leave it to `qerr check`"});
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
  const auto errors = static_cast<Eigen::Index>(spec_.model.transmission.encoders.size());
  if (weights.biased || weights.along_motion || weights.stated.mean.size() != errors ||
      spec_.model.along_motion || (!worst && r.bound != Bound::sigma))
    return {};
  // Of an accuracy the whole passes by ||G||_1 in sigma, too.
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
      columns[static_cast<std::size_t>(e)][i] = std::isfinite(norm) ? norm : never;
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
      column.weights.push_back((worst ? w.half_width : w.variance)[static_cast<Eigen::Index>(e)]);
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
    const Eigen::VectorXd g =
        felt_by(spec_.model.chain, control.walls[index], drawn_.col(static_cast<Eigen::Index>(i)));
    double largest = 0;
    for (Eigen::Index j = 0; j < g.size(); ++j)
      if (g[j] != 0)
        largest = std::max(
            largest, std::abs(g[j]) / (2 * control.joints[static_cast<std::size_t>(j)].friction.value()));
    const Eigen::VectorXd counted = (coupling.transpose() * g).cwiseAbs();
    for (std::size_t e = 0; e < count; ++e)
      columns[e][i] = std::min(r.limit * largest * counted[static_cast<Eigen::Index>(e)], never);
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
  const Eigen::RowVectorXd parts = t.coupling.row(static_cast<Eigen::Index>(loop.joint)).cwiseAbs();
  const double of_width = loop.cycle.bound / parts.dot(widths_at_rest(*spec_.model.control, resolutions(t)));
  ChoiceFigure figure;
  figure.sums = {{}};
  for (Eigen::Index e = 0; e < parts.size(); ++e) {
    if (parts[e] == 0) continue;
    double* const column = new_column();
    std::fill_n(column, configurations_, of_width * parts[e] / r.limit);
    figure.sums[0].columns.push_back(
        {static_cast<std::size_t>(e), column, widths_[static_cast<std::size_t>(e)]});
  }
  return figure;
}

}  // namespace qerr
