#include "residual_statistics.hpp"

#include <algorithm>
#include <cmath>

#include "qerr/core/parallel.hpp"
#include "qerr/filter/filter_bank.hpp"
#include "qerr/filter/norms.hpp"

namespace qerr {

namespace {

constexpr Eigen::Index most_rows = 65536;
constexpr Eigen::Index lanes_at_once = 25;
constexpr int bins = 64;             ///< of the distribution, over two counts about its middle
constexpr double least_left = 0.3;   ///< of a column without its mean: a few rows are no side and no speed
constexpr Eigen::Index smooth = 16;  ///< readings whose mean is the smooth part

/// What the residual is projected on: orthonormal columns over the rows looked at, without their means.
struct Projection {
  std::string name;
  Eigen::ArrayXXd columns;  ///< rows x 1 or 2
  double to_counts = 1;     ///< from the projection to what is reported
};

/// A filter that the record can go through, and of how many rows it has forgotten where it began.
struct Velocity {
  std::string name;
  const Filter* filter;
  Eigen::Index settling;
  double h2;
};

/// What is the same for the record and for every surrogate.
struct Plan {
  const Evidence* e;
  std::vector<Stretch> parts;
  Eigen::Index rows = 0;  ///< of all parts
  std::vector<Projection> projections;
  std::vector<Velocity> velocities;
  Eigen::ArrayXd residual;  ///< of the record [counts]
  Eigen::ArrayXi state;     ///< its counts modulo four
};

Eigen::ArrayXd chosen(const Plan& plan, const Eigen::ArrayXd& column) {
  Eigen::ArrayXd out(plan.rows);
  Eigen::Index at = 0;
  for (const Stretch& s : plan.parts) {
    out.segment(at, s.rows) = column.segment(s.first, s.rows);
    at += s.rows;
  }
  return out;
}

/// Adds a projection on what is left of the columns without their means; none where nothing is left.
void project(Plan& plan, const char* name, Eigen::ArrayXXd columns,
             double (*to_counts)(double n, double norm)) {
  double norm = 0;
  for (Eigen::Index i = 0; i < columns.cols(); ++i) {
    const double size = std::sqrt(columns.col(i).square().sum());
    columns.col(i) -= columns.col(i).mean();
    for (Eigen::Index j = 0; j < i; ++j)
      columns.col(i) -= (columns.col(i) * columns.col(j)).sum() * columns.col(j);
    norm = std::sqrt(columns.col(i).square().sum());
    if (!(norm > least_left * size)) return;
    columns.col(i) /= norm;
  }
  plan.projections.push_back({name, std::move(columns), to_counts(static_cast<double>(plan.rows), norm)});
}

void add_projections(Plan& plan) {
  const Evidence& e = *plan.e;
  const auto rms = [](double n, double) { return 1 / std::sqrt(n); };
  const auto difference = [](double, double norm) { return 1 / norm; };
  if (e.ordered) {
    project(plan, "by_direction", chosen(plan, e.side), [](double, double norm) { return 2 / norm; });
    project(plan, "by_speed", chosen(plan, e.velocity), rms);
    const double middle = 0.5 * (e.time[0] + e.time[e.rows() - 1]);
    project(plan, "by_time", chosen(plan, (e.time > middle).cast<double>()), difference);
  }
  if (e.effort.size() > 0) project(plan, "by_effort", chosen(plan, e.effort), rms);
  const Eigen::ArrayXd angle = chosen(plan, e.encoder.shaft_ratio * e.path);
  Eigen::ArrayXXd wave(plan.rows, 2);
  wave << angle.sin(), angle.cos();
  // Over less than a third of a turn a sine is any slow curve.
  if (angle.maxCoeff() - angle.minCoeff() > 2)
    project(plan, "by_angle", std::move(wave), [](double n, double) { return std::sqrt(2 / n); });
}

void add_velocities(Plan& plan, const std::vector<Filter>& filters) {
  const Evidence& e = *plan.e;
  if (!e.ordered || e.rows() < 64) return;
  const Eigen::ArrayXd intervals = e.time.tail(e.rows() - 1) - e.time.head(e.rows() - 1);
  int number = 0;
  for (const Filter& f : filters) {
    if (f.derivative != 1) continue;
    ++number;
    if ((intervals * f.sample_rate - 1).abs().maxCoeff() > 0.05) continue;
    const double modulus = poles_max_modulus(f);
    const double decay = modulus > 0 ? std::log(1e-3) / std::log(modulus) : 0;
    const auto settling = static_cast<Eigen::Index>(1.5 * decay) +
                          static_cast<Eigen::Index>(2 * f.sections.size() + f.taps.size());
    if (settling > plan.parts.front().rows / 2) continue;
    plan.velocities.push_back({number == 1 ? "velocity_sigma" : "velocity_sigma_" + std::to_string(number),
                               &f, settling, norms(f).h2});
  }
}

Plan plan_of(const Evidence& e, const std::vector<Filter>& filters) {
  Plan plan{&e, stretches(e.rows(), most_rows), 0, {}, {}, {}, {}};
  for (const Stretch& s : plan.parts) plan.rows += s.rows;
  plan.residual = (e.measured - e.reference) / e.step();
  if (!e.encoder.zero_known) plan.residual -= chosen(plan, plan.residual).mean();
  plan.state.resize(e.rows());
  for (Eigen::Index k = 0; k < e.rows(); ++k) {
    const double turned = std::fmod(std::round(e.measured[k] / e.step()), 4.0);
    plan.state[k] = static_cast<int>(turned < 0 ? turned + 4 : turned);
  }
  add_projections(plan);
  add_velocities(plan, filters);
  return plan;
}

/// Sums over the rows, lane by lane.
class Sums {
 public:
  Sums(const Plan& plan, Eigen::Index lanes) : plan_(plan), lanes_(lanes), distribution_(bins, lanes) {
    for (Eigen::ArrayXd* a : {&sum_, &square_, &lagged_, &last_, &block_, &block_sum_, &block_square_,
                              &block_lagged_, &last_block_, &firsts_, &lasts_, &first_blocks_, &last_blocks_})
      *a = Eigen::ArrayXd::Zero(lanes);
    distribution_.setZero();
    by_state_ = in_state_ = Eigen::ArrayXXd::Zero(4, lanes);
    for (const Projection& p : plan.projections)
      projected_.push_back(Eigen::ArrayXXd::Zero(lanes, p.columns.cols()));
    velocity_sum_ = velocity_square_ =
        Eigen::ArrayXXd::Zero(lanes, static_cast<Eigen::Index>(plan.velocities.size()));
  }

  void start() {
    lasts_ += last_;
    last_blocks_ += last_block_;
    in_stretch_ = 0;
    blocks_in_stretch_ = 0;
    block_.setZero();
    banks_.clear();
    for (const Velocity& v : plan_.velocities) banks_.emplace_back(*v.filter, lanes_);
  }

  void add(const Eigen::ArrayXd& r, const Eigen::ArrayXi& state) {
    sum_ += r;
    square_ += r.square();
    if (in_stretch_ > 0)
      lagged_ += r * last_;
    else
      firsts_ += r;
    last_ = r;
    for (std::size_t p = 0; p < projected_.size(); ++p)
      for (Eigen::Index c = 0; c < projected_[p].cols(); ++c)
        projected_[p].col(c) += plan_.projections[p].columns(row_, c) * r;
    const double middle = plan_.e->encoder.rounding == Rounding::down ? -0.5 : 0.0;
    for (Eigen::Index i = 0; i < lanes_; ++i) {
      const double place = (r[i] - middle + 1) * (0.5 * bins);
      ++distribution_(static_cast<int>(std::clamp(place, 0.0, bins - 0.5)), i);
      by_state_(state[i], i) += r[i];
      in_state_(state[i], i) += 1;
    }
    add_block(r);
    for (std::size_t f = 0; f < banks_.size(); ++f) {
      filtered_ = r;
      banks_[f].step(filtered_);
      if (in_stretch_ < plan_.velocities[f].settling) continue;
      velocity_sum_.col(static_cast<Eigen::Index>(f)) += filtered_;
      velocity_square_.col(static_cast<Eigen::Index>(f)) += filtered_.square();
    }
    ++in_stretch_, ++row_;
  }

  std::vector<Statistic> statistics() const;

 private:
  void add_block(const Eigen::ArrayXd& r) {
    block_ += r;
    if ((in_stretch_ + 1) % smooth != 0) return;
    block_ /= static_cast<double>(smooth);
    block_sum_ += block_;
    block_square_ += block_.square();
    if (blocks_in_stretch_ > 0)
      block_lagged_ += block_ * last_block_;
    else
      first_blocks_ += block_;
    last_block_ = block_;
    block_.setZero();
    ++blocks_in_stretch_, ++blocks_;
  }

  const Plan& plan_;
  Eigen::Index lanes_, row_ = 0, in_stretch_ = 0, blocks_in_stretch_ = 0, blocks_ = 0;
  Eigen::ArrayXd sum_, square_, lagged_, last_, block_, block_sum_, block_square_, block_lagged_, last_block_,
      firsts_, lasts_, first_blocks_, last_blocks_;
  Eigen::ArrayXd filtered_;
  Eigen::ArrayXXi distribution_;
  Eigen::ArrayXXd by_state_, in_state_, velocity_sum_, velocity_square_;
  std::vector<Eigen::ArrayXXd> projected_;
  std::vector<FilterBank> banks_;
};

/// Correlation of neighbours, from sums over `pairs`: of the products, of all values and their squares, of
/// the values that are nobody's left neighbour and of those that are nobody's right one.
Eigen::ArrayXd correlation(const Eigen::ArrayXd& lagged, double pairs, const Eigen::ArrayXd& sum,
                           const Eigen::ArrayXd& square, const Eigen::ArrayXd& last,
                           const Eigen::ArrayXd& first, double n) {
  const Eigen::ArrayXd variance = square / n - (sum / n).square();
  return (lagged / pairs - (sum - last) / pairs * ((sum - first) / pairs)) / variance.max(1e-6);
}

std::vector<Statistic> Sums::statistics() const {
  std::vector<Statistic> all;
  const auto n = static_cast<double>(row_), parts = static_cast<double>(plan_.parts.size());
  const Eigen::ArrayXd mean = sum_ / n;
  if (plan_.e->encoder.zero_known) all.push_back({"mean", Tail::both_sides, 1, 0.01, mean});
  all.push_back(
      {"sigma_ratio", Tail::both_sides, 1, 0.01, (12 * (square_ / n - mean.square())).max(0.0).sqrt()});
  Eigen::ArrayXd farthest(lanes_);
  for (Eigen::Index i = 0; i < lanes_; ++i) {
    double below = 0, most = 0;
    for (int b = 0; b < bins; ++b) {
      below += distribution_(b, i);
      const double uniform = std::clamp((b + 1) / (0.5 * bins) - 0.5, 0.0, 1.0);
      most = std::max(most, std::abs(below / n - uniform));
    }
    farthest[i] = most;
  }
  all.push_back({"uniformity", Tail::both_sides, 1, 0.01, farthest});
  if (plan_.e->ordered) {
    all.push_back({"autocorrelation", Tail::both_sides, 1, 0.01,
                   correlation(lagged_, n - parts, sum_, square_, lasts_ + last_, firsts_, n)});
    const auto blocks = static_cast<double>(blocks_);
    if (blocks_ > 24 + static_cast<Eigen::Index>(parts))
      all.push_back({"autocorrelation_smooth", Tail::both_sides, 1, 0.1,
                     correlation(block_lagged_, blocks - parts, block_sum_, block_square_,
                                 last_blocks_ + last_block_, first_blocks_, blocks)});
  }
  for (std::size_t p = 0; p < projected_.size(); ++p) {
    const Projection& one = plan_.projections[p];
    if (one.columns.cols() == 1)
      all.push_back({one.name, Tail::both_sides, 1, 0.01, one.to_counts * projected_[p].col(0)});
    else
      all.push_back({one.name, Tail::chi_squared, 2, 0.01,
                     one.to_counts * projected_[p].square().rowwise().sum().sqrt()});
  }
  const Eigen::ArrayXXd off = by_state_ / in_state_.max(1.0) - mean.transpose().replicate(4, 1);
  all.push_back(
      {"by_count", Tail::chi_squared, 3, 0.01, (off.square() * in_state_ / n).colwise().sum().sqrt()});
  for (std::size_t f = 0; f < plan_.velocities.size(); ++f) {
    const Velocity& v = plan_.velocities[f];
    const double used = n - parts * static_cast<double>(v.settling);
    const auto column = static_cast<Eigen::Index>(f);
    const Eigen::ArrayXd variance =
        velocity_square_.col(column) / used - (velocity_sum_.col(column) / used).square();
    all.push_back({v.name, Tail::both_sides, 1, 0.05, (12 * variance).max(0.0).sqrt() / v.h2});
  }
  return all;
}

/// Lanes first .. first + lanes of all; lane 0 is the record itself.
std::vector<Statistic> run(const Plan& plan, std::uint64_t seed, Eigen::Index first, Eigen::Index lanes) {
  Surrogate surrogate(*plan.e, seed, static_cast<std::uint64_t>(first), lanes);
  Sums sums(plan, lanes);
  Eigen::ArrayXd residual(lanes);
  Eigen::ArrayXi state(lanes);
  for (const Stretch& s : plan.parts) {
    surrogate.start();
    sums.start();
    for (Eigen::Index k = s.first; k < s.first + s.rows; ++k) {
      surrogate.read(k, residual, state);
      if (first == 0) residual[0] = plan.residual[k], state[0] = plan.state[k];
      sums.add(residual, state);
    }
  }
  return sums.statistics();
}

}  // namespace

std::vector<Statistic> residual_statistics(const Evidence& e, const std::vector<Filter>& filters,
                                           Eigen::Index surrogates, std::uint64_t seed, unsigned threads) {
  const Plan plan = plan_of(e, filters);
  const Eigen::Index all = surrogates + 1;
  std::vector<std::vector<Statistic>> batches(
      static_cast<std::size_t>((all + lanes_at_once - 1) / lanes_at_once));
  parallel_for(batches.size(), threads, [&](std::size_t i) {
    const Eigen::Index first = static_cast<Eigen::Index>(i) * lanes_at_once;
    batches[i] = run(plan, seed, first, std::min(lanes_at_once, all - first));
  });
  std::vector<Statistic> joined = batches.front();
  for (std::size_t s = 0; s < joined.size(); ++s) {
    Eigen::ArrayXd values(all);
    Eigen::Index at = 0;
    for (const auto& batch : batches) {
      values.segment(at, batch[s].values.size()) = batch[s].values;
      at += batch[s].values.size();
    }
    joined[s].values = std::move(values);
  }
  return joined;
}

}  // namespace qerr
