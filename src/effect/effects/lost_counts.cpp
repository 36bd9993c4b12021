#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "core/statistics.hpp"
#include "effect/effects/effects.hpp"

namespace qerr {

namespace {

constexpr double least_share = 0.05;  // of the travel on either side of a speed that can be told (convention)

/// What a loss leaves of an error: a part of it, or of a count (conventions).
constexpr double part_left = 0.1, counts_left = 0.6;

/// Way at more than a speed, from the first row to each [rad or m].
Eigen::ArrayXd way_above(const Eigen::ArrayXd& time, const Eigen::ArrayXd& path, double speed) {
  Eigen::ArrayXd way = Eigen::ArrayXd::Zero(path.size());
  for (Eigen::Index k = 1; k < path.size(); ++k) {
    const double moved = path[k] - path[k - 1];
    way[k] = way[k - 1] + (std::abs(moved) > speed * (time[k] - time[k - 1]) ? moved : 0);
  }
  return way;
}

/// Some rows of a record, in which the speed is seen that divides lossless motion from that with losses.
class LossScan {
 public:
  explicit LossScan(const RecordSignals& s) {
    constexpr Eigen::Index most = 1 << 16, fitted = 1024;
    step_ = s.step();
    const auto some = Eigen::seq(0, Eigen::last, (s.rows() + most - 1) / most);
    const Eigen::ArrayXd time = s.time(some), all = s.path(some), speed = s.velocity(some).abs();
    for (const double v : speed) speeds_.push_back({v, v});
    add_up(speeds_.begin(), speeds_.end());
    stride_ = (all.size() + fitted - 1) / fitted;
    add_ways(time, all);
    const Eigen::ArrayXd path = every(all), shaft = s.encoder.shaft_ratio * path;
    error_ = every((s.measured - s.path)(some)).matrix();
    beside_.resize(path.size(), 4);
    beside_ << Eigen::VectorXd::Ones(path.size()), path - path.mean(), shaft.sin(), shaft.cos();
    for (Eigen::Index i = 0; i < beside_.cols(); ++i) {
      const double size = beside_.col(i).norm(), own = project(beside_.col(i), i);
      beside_.col(i) *= own > 1e-9 * size ? 1 / own : 0;
    }
  }

  /// The speed above which a loss leaves least. None where all speeds or none are above: what is lost at all
  /// of them is a wrong scale. None where more is left than a loss leaves: it would be a part of any curve.
  /// @param beside  columns beside it: 1, a constant; 4, a scale and an eccentricity, too
  std::optional<double> best(Eigen::Index beside) const {
    constexpr int coarse = 40, fine = 16;
    const double fastest = speeds_.front().speed;
    double least = std::numeric_limits<double>::infinity(), best = 0;
    const auto attempt = [&](double at) {
      if (const double left = left_by(at, beside); left < least) best = at, least = left;
    };
    for (int i = 1; i < coarse; ++i) attempt(fastest * i / coarse);
    for (double step = fastest / (coarse * fine); step > fastest / 1e5; step /= fine) {
      const double about = best;
      for (int i = -fine; i <= fine; ++i) attempt(about + step * i);
    }
    const auto rows = static_cast<double>(error_.size());
    const double all = standard_deviation(error_.array()), left = std::sqrt(std::max(0.0, least) / rows);
    return best > 0 && left < std::max(part_left * all, counts_left * step_) ? std::optional(best)
                                                                             : std::nullopt;
  }

 private:
  Eigen::ArrayXd every(const Eigen::ArrayXd& x) const { return x(Eigen::seq(0, Eigen::last, stride_)); }

  double left_by(double speed, Eigen::Index beside) const {
    const double above = way_of_faster(speeds_.begin(), speeds_.end(), speed), travel = speeds_.back().way;
    if (above < least_share * travel || above > (1 - least_share) * travel)
      return std::numeric_limits<double>::infinity();
    Eigen::VectorXd way = every_way_above(speed), error = error_;
    const double size = way.norm(), own = project(way, beside), left = std::pow(project(error, beside), 2);
    return own > 1e-9 * size ? left - std::pow(way.dot(error) / own, 2) : left;
  }

  /// A motion, and the way of all that are as fast and faster.
  struct Motion {
    double speed, way;
  };
  using Motions = std::vector<Motion>;

  /// Sorts motions, whose ways are their own, from the fastest, and adds the ways up.
  static void add_up(Motions::iterator first, Motions::iterator end) {
    std::sort(first, end, [](const Motion& a, const Motion& b) { return a.speed > b.speed; });
    for (double way = 0; first != end; ++first) way += first->way, first->way = way;
  }

  static double way_of_faster(Motions::const_iterator first, Motions::const_iterator end, double speed) {
    const auto slower = std::partition_point(first, end, [&](const Motion& m) { return m.speed > speed; });
    return slower == first ? 0 : std::prev(slower)->way;
  }

  void add_ways(const Eigen::ArrayXd& time, const Eigen::ArrayXd& path) {
    for (Eigen::Index k = 1; k < path.size(); ++k) {
      const double moved = path[k] - path[k - 1];
      steps_.push_back({moved == 0 ? 0 : std::abs(moved) / (time[k] - time[k - 1]), moved});
    }
    for (auto first = steps_.begin(); first != steps_.end();) {
      const auto end = first + std::min<std::ptrdiff_t>(stride_, steps_.end() - first);
      add_up(first, end);
      first = end;
    }
  }

  /// The way at more than a speed, up to every row that is fitted (way_above).
  Eigen::VectorXd every_way_above(double speed) const {
    Eigen::VectorXd way = Eigen::VectorXd::Zero(error_.size());
    for (Eigen::Index i = 1; i < way.size(); ++i) {
      const auto first = steps_.begin() + (i - 1) * stride_;
      way[i] = way[i - 1] + way_of_faster(first, first + stride_, speed);
    }
    return way;
  }

  /// Takes from a column what is along the first of the orthonormal ones, twice, as rounding has it.
  /// @returns the size of what is left
  double project(Eigen::Ref<Eigen::VectorXd> column, Eigen::Index first) const {
    const auto basis = beside_.leftCols(first);
    for (int i = 0; i < 2; ++i) column -= basis * (basis.transpose() * column).eval();
    return column.norm();
  }

  Eigen::Index stride_ = 1;
  double step_ = 0;
  Motions speeds_;  ///< of the rows
  Motions steps_;   ///< between rows, stride by stride
  Eigen::VectorXd error_;
  Eigen::MatrixXd beside_;  // orthonormal: a constant, a scale, an eccentricity
};

std::vector<double> speeds_of_loss(const RecordSignals& s) {
  std::vector<double> speeds;
  const LossScan scan(s);
  for (const Eigen::Index beside : {1, 4})
    if (const auto speed = scan.best(beside)) speeds.push_back(*speed);
  std::ranges::sort(speeds);
  speeds.erase(std::unique(speeds.begin(), speeds.end()), speeds.end());
  return speeds;
}

Term loss_above(const RecordSignals& s, double speed) {
  Term t = linear_term(s, "lost_counts", -way_above(s.time, s.path, speed),
                       [](Effect& e, const Eigen::VectorXd& c) { e.numbers["fraction"] = c[0]; });
  t.effect.numbers["speed"] = t.shape = speed;
  t.half_width = 0.2 * s.velocity.abs().maxCoeff();
  t.positive = 1;
  t.reshaped = [](const RecordSignals& record, const Term&, double shape) {
    return loss_above(record, shape);
  };
  t.shapes = speeds_of_loss;
  return t;
}

std::vector<Term> terms(const RecordSignals& s) {
  if (!s.ordered || s.is_stationary() || s.coupled()) return {};
  return {loss_above(s, 0.5 * s.velocity.abs().maxCoeff())};
}

/// Lost counts are whole ones. At one instant it may be asked for several counts, of which the first counts.
Action action(const Effect& e, const Encoder&, std::uint64_t) {
  struct Reading {
    double count, joint, time;
  };
  return [fraction = e.number("fraction"), speed = e.number("speed"), lost = 0.0,
          last = std::optional<Reading>()](double x, const Moment& m) mutable {
    if (last && last->time == m.time) return x - std::round(lost);
    if (last && std::abs(m.joint - last->joint) > speed * (m.time - last->time))
      lost += fraction * (x - last->count);
    last = {x, m.joint, m.time};
    return x - std::round(lost);
  };
}

/// All of it may be lost in one direction: fraction v t, with t uniform over the duration.
std::optional<Share> share(const Effect& e, const Encoder& encoder, const Usage& u) {
  if (e.number("fraction") == 0) return Share{};
  if (!u.velocity) return std::nullopt;
  const double fastest = u.velocity->largest();
  if (fastest <= e.number("speed")) return Share{};
  if (!u.duration) return std::nullopt;
  const double most = e.number("fraction") * fastest * *u.duration + encoder.resolution;
  return Share{0, most, most / std::sqrt(3.0), Spectrum::motion};
}

}  // namespace

EffectKind lost_counts_effect() {
  return {.name = "lost_counts",
          .summary = "a part of the counts is lost while the joint is faster than a speed",
          .typical = "counters and opto-couplers above their limiting frequency",
          .stage = Stage::decoder,
          .parameters = {{.name = "fraction",
                          .meaning = "lost counts per count that passes",
                          .required = true,
                          .least = 0,
                          .most = 1},
                         {.name = "speed",
                          .dimension = dimension::angular_speed,
                          .meaning = "of the joint, above which counts are lost",
                          .fallback = 0.0,
                          .least = 0}},
          .action = action,
          .share = share,
          .need = Need::duration,
          .terms = terms,
          .record = "moves below and above that speed, in both directions",
          .remedy = {false,
                     "keep the count rate below the counter's limit: lower the speed, or use a faster "
                     "counter; check the level of the signals at speed"}};
}

}  // namespace qerr
