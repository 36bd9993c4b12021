#include "diagnose/inference/tip/tip_remainder.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>

#include "core/random.hpp"
#include "core/statistics.hpp"
#include "core/text.hpp"
#include "diagnose/inference/tip/tip_weight.hpp"
#include "diagnose/search/peaks.hpp"

namespace qerr {

namespace {

constexpr Eigen::Index fewest_rows_in_time = 24, fewest_draws = 40;
constexpr std::array<std::size_t, 2> widths{16, 160};  // of windows: frequencies are a quarter of 1/T apart
constexpr double beyond_surrogates = 1.5;              // chance has 1 in 40 already without it
constexpr double noticeable = 0.05;  // of the variance: what is less is no error to look for

/// Power by frequency, summed over the coordinates.
std::vector<double> spectrum(const Eigen::MatrixXd& series, const Eigen::ArrayXd& time, double spacing) {
  const auto last = static_cast<Eigen::Index>(2 * series.rows());
  std::vector<double> power(static_cast<std::size_t>(last));
  for (Eigen::Index c = 0; c < series.cols(); ++c) {
    const Eigen::ArrayXd centred = series.col(c).array() - series.col(c).mean();
    const std::vector<float> one = periodogram(centred, time, spacing, 1, last);
    for (std::size_t i = 0; i < power.size(); ++i) power[i] += static_cast<double>(one[i]);
  }
  return power;
}

double sum(const std::vector<double>& power) { return std::accumulate(power.begin(), power.end(), 0.0); }

struct Band {
  std::size_t first = 0;
  double power = 0;
};

Band strongest_band(const std::vector<double>& power, std::size_t width) {
  double inside = 0;
  Band best;
  for (std::size_t i = 0; i < power.size(); ++i) {
    inside += power[i] - (i >= width ? power[i - width] : 0);
    if (inside > best.power) best = {i + 1 >= width ? i + 1 - width : 0, inside};
  }
  return best;
}

/// Mean index of the power in a window.
double centre(const std::vector<double>& power, const Band& w, std::size_t width) {
  double inside = 0, moment = 0;
  for (std::size_t i = w.first; i < std::min(w.first + width, power.size()); ++i) {
    inside += power[i];
    moment += power[i] * static_cast<double>(i + 1);
  }
  return moment / inside;
}

/// What changes at one row and persists, as a target that was knocked.
struct Shift {
  Eigen::Index row = 0;
  Eigen::RowVectorXd by;  ///< of the rows after it from those before [m]
  double share = 0;       ///< of the variance
};

/// Rows on either side: a few at an end are no shift, but where a motion or a play begins.
Eigen::Index fewest_of_shift(Eigen::Index rows) { return std::clamp<Eigen::Index>(rows / 8, 1, 8); }

Shift largest_shift(const Eigen::MatrixXd& left) {
  const Eigen::MatrixXd centred = left.rowwise() - left.colwise().mean();
  const double whole = centred.squaredNorm(), n = static_cast<double>(left.rows());
  Eigen::RowVectorXd before = Eigen::RowVectorXd::Zero(left.cols());
  Shift best{0, Eigen::RowVectorXd::Zero(left.cols()), 0};
  if (!(whole > 0)) return best;
  const Eigen::Index fewest = fewest_of_shift(left.rows());
  for (Eigen::Index k = 1; k <= left.rows() - fewest; ++k) {
    before += centred.row(k - 1);
    if (k < fewest) continue;
    const double rows = static_cast<double>(k), both = rows * (n - rows) / n;
    const double share = before.squaredNorm() / both / whole;
    if (share > best.share) best = {k, -before / both, share};
  }
  return best;
}

Eigen::MatrixXd without(Eigen::MatrixXd left, const Shift& shift) {
  left.bottomRows(left.rows() - shift.row).rowwise() -= shift.by;
  return left;
}

/// The rows' time; poses without stamps are listed in the order in which they were taken.
Eigen::ArrayXd time_of(const TipEvidence& e) {
  if (!e.ordered) return Eigen::ArrayXd::LinSpaced(e.rows(), 0, static_cast<double>(e.rows() - 1));
  return e.encoders.front().time - e.encoders.front().time[0];
}

Unidentified described(const Shift& shift, const TipEvidence& e) {
  Unidentified u{"tip", "a step in time", {}, {}, shift.by.norm(), Shape::step};
  u.figures = {{"size", shift.by.norm()}};
  if (e.ordered)
    u.figures["time"] = e.encoders.front().time[shift.row];
  else
    u.what += ", from pose " + std::to_string(shift.row + 1) + " on";
  u.next = "look whether the target was knocked or the tracker moved then, and record again";
  return u;
}

/// Shares of the variance in the strongest bands and in the largest shift.
struct Shares {
  std::array<Band, widths.size()> bands;
  std::array<double, widths.size()> in_band{};
};

Shares shares(const std::vector<double>& power) {
  Shares s;
  const double whole = sum(power);
  for (std::size_t i = 0; i < widths.size(); ++i) {
    s.bands[i] = strongest_band(power, widths[i]);
    s.in_band[i] = s.bands[i].power / whole;
  }
  return s;
}

/// The first width whose strongest band has more than chance has; none: widths.size().
std::size_t structured(const Shares& s, const std::array<double, widths.size()>& limits) {
  for (std::size_t i = 0; i < widths.size(); ++i)
    if (s.in_band[i] >= beyond_surrogates * limits[i] && s.in_band[i] >= noticeable) return i;
  return widths.size();
}

}  // namespace

std::vector<Unidentified> tip_remainder(const TipModel& m, const Eigen::MatrixXd& left) {
  const TipEvidence& e = m.evidence();
  if (e.rows() < fewest_rows_in_time || !(rms(left.reshaped()) > computed_tip)) return {};
  const Eigen::ArrayXd time = time_of(e);
  const double duration = time[time.size() - 1];
  if (!(duration > 0)) return {};
  const double spacing = std::numbers::pi / (2 * duration);
  std::array<double, widths.size()> limits{};
  double limit_of_shift = 0;
  const std::uint64_t noise = stream_seed(m.seed(), "tip remainder");
  for (Eigen::Index d = 0; d < std::max(fewest_draws, m.surrogates().cols()); ++d) {
    Eigen::VectorXd drawn = Eigen::VectorXd::Zero(m.entries().size());
    if (d < m.surrogates().cols()) drawn = m.surrogates().col(d);
    // Uniform numbers: the power of a frequency is a sum over all rows.
    for (Eigen::Index k = 0; k < drawn.size(); ++k)
      drawn[k] +=
          m.solution().sigma * std::sqrt(12.0) *
          (unit_interval(random_bits(noise, static_cast<std::uint64_t>(k), static_cast<std::uint64_t>(d))) -
           0.5);
    const Eigen::MatrixXd by_chance = m.in_base(drawn);
    const Shares s = shares(spectrum(by_chance, time, spacing));
    for (std::size_t i = 0; i < widths.size(); ++i) limits[i] = std::max(limits[i], s.in_band[i]);
    limit_of_shift = std::max(limit_of_shift, largest_shift(by_chance).share);
  }
  const std::vector<double> power = spectrum(left, time, spacing);
  const Shares found = shares(power);
  const std::size_t i = structured(found, limits);
  const Shift shift = largest_shift(left);
  const bool shifted = shift.share >= beyond_surrogates * limit_of_shift && shift.share >= noticeable;
  if (shifted && structured(shares(spectrum(without(left, shift), time, spacing)), limits) == widths.size())
    return {described(shift, e)};
  if (i == widths.size()) return {};  // also of an exact fit
  const double frequency = centre(power, found.bands[i], widths[i]) * spacing / (2 * std::numbers::pi);
  // Of the variance of all coordinates, which is that of a line of this amplitude along one of them.
  const double variance = left.squaredNorm() / static_cast<double>(left.rows());
  Unidentified u{"tip", "changes slowly in time", {}, {}, std::sqrt(2 * found.in_band[i] * variance)};
  if (frequency * duration > 3 && e.ordered) {
    u.what = "vibrates";
    u.frequency = frequency;
    u.shape = Shape::line;
    u.figures = {{"frequency", frequency}};
  } else if (!e.ordered) {
    u.what = "changes from pose to pose in their order, slowly";
  }
  return {u};
}

namespace {

TipTerm displacement_in_time(TipTerm::Kind kind, Eigen::ArrayXXd columns, std::size_t where,
                             std::string text) {
  TipTerm t{kind, {}, where};
  t.term.effect.joint = "tip";
  t.term.columns = std::move(columns);
  t.term.unnamed = std::move(text);
  return t;
}

TipTerm tracker_term(const TipEvidence& e, TipTerm::Kind kind, Eigen::ArrayXXd columns, Eigen::Index row) {
  TipTerm t = displacement_in_time(kind, std::move(columns), static_cast<std::size_t>(row),
                                   row > 0 ? "a step in time" : "changes slowly in time");
  t.term.fill = [](Effect& x, const Eigen::VectorXd& c) { x.numbers["amplitude"] = c.norm(); };
  t.directions = Eigen::Matrix3d::Identity()(Eigen::all, e.axes);
  return t;
}

/// One in a row and all after it.
Eigen::ArrayXXd from_row(const TipEvidence& e, Eigen::Index row) {
  Eigen::ArrayXXd after = Eigen::ArrayXXd::Zero(e.rows(), 1);
  after.bottomRows(e.rows() - row).setOnes();
  return after;
}

/// Chebyshev's polynomials in time.
TipTerm wander(const TipEvidence& e, Eigen::Index count) {
  const Eigen::ArrayXd time = time_of(e);
  const Eigen::ArrayXd angle = (2 * time / time.maxCoeff() - 1).acos();
  Eigen::ArrayXXd columns(e.rows(), count);
  for (Eigen::Index i = 0; i < count; ++i) columns.col(i) = (static_cast<double>(i) * angle).cos();
  return tracker_term(e, TipTerm::Kind::tracker, std::move(columns), 0);
}

/// A knocked target: a displacement in the axes of the tip from one row on, beside one of all rows, by least
/// squares at the row where it explains most of what a fit leaves.
std::optional<TipTerm> knocked_target(const TipModel& m, const Eigen::MatrixXd& left) {
  constexpr double unseen = 1e-9;  // of the squares: rounding errors
  const TipEvidence& e = m.evidence();
  Eigen::Matrix3d all = Eigen::Matrix3d::Zero();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  std::vector<Eigen::Matrix3d> squares_to;
  std::vector<Eigen::Vector3d> sum_to;
  for (Eigen::Index k = 0; k < e.rows(); ++k) {
    squares_to.push_back(all);
    sum_to.push_back(sum);
    const Eigen::MatrixXd axes = m.pose(k).tool(e.axes, Eigen::all);
    all += axes.transpose() * axes;
    sum += axes.transpose() * left.row(k).transpose();
  }
  const auto explained = [&](const Eigen::Matrix3d& of, const Eigen::Vector3d& by) {
    const Eigen::Matrix3d regular = of + unseen * all.trace() * Eigen::Matrix3d::Identity();
    return by.dot(regular.inverse() * by);
  };
  double most = 0;
  Eigen::Index row = 0;
  const Eigen::Index fewest = fewest_of_shift(e.rows());
  for (Eigen::Index k = fewest; k <= e.rows() - fewest; ++k) {
    const auto at = static_cast<std::size_t>(k);
    const double here =
        explained(squares_to[at], sum_to[at]) + explained(all - squares_to[at], sum - sum_to[at]);
    if (here > most) most = here, row = k;
  }
  std::vector<Eigen::Index> seen;  // of a plane its axis is not
  for (Eigen::Index i = 0; i < 3; ++i)
    if (all(i, i) > unseen * all.trace()) seen.push_back(i);
  if (row == 0 || seen.empty()) return std::nullopt;
  TipTerm t = tracker_term(e, TipTerm::Kind::target, from_row(e, row), row);
  t.directions = Eigen::Matrix3d::Identity()(Eigen::all, seen);
  return t;
}

/// The largest shift of what a fit leaves, of the tracker or of the target.
std::optional<TipTerm> knock(const TipModel& m, TipTerm::Kind kind, const Eigen::MatrixXd& left) {
  if (kind == TipTerm::Kind::target) return knocked_target(m, left);
  const Shift shift = largest_shift(left);
  if (shift.row == 0) return std::nullopt;
  return tracker_term(m.evidence(), kind, from_row(m.evidence(), shift.row), shift.row);
}

/// 1 - exp(-t/time_constant) from the start of the record on, whose first rows are not judged: of a machine
/// or of a mount that becomes warm.
Term approach(const RecordSignals& s, double time_constant) {
  constexpr double shortest = 0.1;  // of the record: of a shorter one this is a constant, as a frame's
  time_constant = std::max(time_constant, shortest * s.time[s.rows() - 1]);
  Term t;
  t.columns = 1 - (-s.time / time_constant).exp();
  t.effect.numbers["time_constant"] = t.shape = time_constant;
  t.half_width = 0.7 * time_constant;
  t.reshaped = [](const RecordSignals& record, const Term& before, double shape) {
    Term other = approach(record, shape);
    other.effect.joint = before.effect.joint;
    other.unnamed = before.unnamed;
    other.fill = before.fill;
    return other;
  };
  return t;
}

/// A displacement by an exponential approach, at the time constant that explains most.
TipTerm best_approach(const TipModel& m, TipTerm t) {
  const RecordSignals& record = m.evidence().encoders.front();
  const auto coordinates = static_cast<Eigen::Index>(m.evidence().axes.size());
  const Term plain = t.term;
  t.term.columns = Eigen::ArrayXXd::Ones(record.rows(), 1);
  const Eigen::MatrixXd unit = m.columns(t);
  double best = 0, most = -1;
  const auto try_constant = [&](double wanted) {
    const double constant = approach(record, wanted).shape;
    Eigen::MatrixXd columns = unit;
    for (Eigen::Index k = 0; k < record.rows(); ++k)
      columns.middleRows(k * coordinates, coordinates) *= 1 - std::exp(-record.time[k] / constant);
    if (const double gain = m.gain(columns); gain > most) most = gain, best = constant;
  };
  for (const double part : {0.1, 0.3, 1.0}) try_constant(part * record.time[record.rows() - 1]);
  // Between these, or beyond: polynomials must not win by a better resolution.
  for (double factor = std::sqrt(3.0); factor > 1.05; factor = std::sqrt(factor))
    for (const double by : {1 / factor, factor}) try_constant(by * best);
  t.term = approach(record, best).reshaped(record, plain, best);
  return t;
}

/// Links that become longer, as those that become warm do.
std::vector<TipTerm> growths(const TipModel& m) {
  constexpr double shortest_link = 0.03;  // [m] (convention): 30 K on aluminium are 20 um
  const Chain& chain = m.nominal();
  std::vector<TipTerm> terms;
  for (std::size_t j = 0; j <= chain.joints.size(); ++j) {
    const bool last = j == chain.joints.size();
    const Eigen::Vector3d along = (last ? chain.tip_offset : chain.joints[j].origin).translation();
    if (along.norm() < shortest_link) continue;
    TipTerm t = displacement_in_time(
        TipTerm::Kind::growth, {}, j,
        "the link before " + (last ? "the tip" : chain.joints[j].name) + " grows with time");
    t.term.fill = [](Effect& x, const Eigen::VectorXd& c) { x.numbers["amplitude"] = c[0]; };
    t.directions = along.normalized();
    terms.push_back(best_approach(m, std::move(t)));
  }
  return terms;
}

}  // namespace

std::vector<TipTerm> tracker_terms(const TipModel& m) {
  if (m.evidence().rows() < fewest_rows_in_time) return {};
  std::vector<TipTerm> terms;
  for (Eigen::Index degree = 1; degree < most_polynomials; degree *= 2)
    if (degree == 1 || degree < m.evidence().rows() / 16) terms.push_back(wander(m.evidence(), degree + 1));
  terms.push_back(best_approach(m, tracker_term(m.evidence(), TipTerm::Kind::tracker, {}, 0)));
  const Eigen::MatrixXd left = m.in_base(m.solution().residual);
  for (const TipTerm::Kind kind : {TipTerm::Kind::tracker, TipTerm::Kind::target})
    if (auto step = knock(m, kind, left)) terms.push_back(std::move(*step));
  for (TipTerm& t : growths(m)) terms.push_back(std::move(t));
  return terms;
}

void settle_knocks(TipModel& m) {
  std::size_t moves = m.terms().size();  // a term that is moved becomes the last one, and is seen again
  for (std::size_t i = 0; i < m.terms().size();) {
    const TipTerm& t = m.terms()[i];
    std::optional<TipTerm> other;
    if (t.of_record() && t.kind != TipTerm::Kind::growth && t.where > 0)
      other = knock(m, t.kind, m.in_base(m.trial({i}, {}).residual));
    TipSolution s;
    if (other && other->where != t.where) s = m.trial({i}, m.columns(*other));
    if (s.theta.size() == 0 || s.log_likelihood <= m.solution().log_likelihood || moves == 0) {
      ++i;
      continue;
    }
    --moves;
    const Eigen::VectorXd theta = s.theta.tail(other->size());
    m.exchange(i, std::move(*other), theta);
    m.fit();
  }
}

Unidentified tracker_finding(const TipModel& m, std::size_t term) {
  const TipTerm& t = m.terms()[term];
  const TipEvidence& e = m.evidence();
  const Eigen::VectorXd c = m.coefficients(term);
  if (t.kind == TipTerm::Kind::growth) {
    const double by = c[0] * t.term.columns(e.rows() - 1, 0);
    Unidentified u{"tip", t.term.unnamed, {}, {}, std::abs(by)};
    u.next = "let the robot warm up before it is measured, or measure its temperature beside";
    return u;
  }
  if (t.where > 0) return described({static_cast<Eigen::Index>(t.where), c.transpose(), 0}, e);
  const Eigen::MatrixXd moved = m.in_base(m.columns(term) * c);
  const double variance =
      (moved.rowwise() - moved.colwise().mean()).squaredNorm() / static_cast<double>(moved.rows());
  Unidentified u{"tip", t.term.unnamed, {}, {}, std::sqrt(2 * variance)};
  if (!e.ordered) u.what = "changes from pose to pose in their order, slowly";
  u.next =
      "look whether the tracker warms up or its mount gives way: track a point that rests beside the tip";
  return u;
}

}  // namespace qerr
