#include "bound/proven/ascent.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/search.hpp"

namespace qerr {

namespace {

constexpr double whole_turn = 2 * std::numbers::pi;

/// The first value of t + k turns that is not below the range, if it is in the range.
template <class Use>
void for_each_inside(double t, const Limits& range, Use use) {
  for (double at = t + whole_turn * std::ceil((range.lower - t) / whole_turn); at <= range.upper;
       at += whole_turn)
    use(at);
}

/// Maxima do not repeat beyond one turn.
Limits within_a_turn(const Limits& range) {
  return {range.lower, std::min(range.upper, range.lower + whole_turn)};
}

double sum_of_magnitudes(const Harmonics& h, double t) {
  const double c = std::cos(t), s = std::sin(t);
  double sum = 0;
  for (Eigen::Index g = 0; g < h.rows(); ++g) sum += std::abs(h(g, 0) + h(g, 1) * c + h(g, 2) * s);
  return sum;
}

}  // namespace

Harmonics harmonics(const Eigen::VectorXd& at_0, const Eigen::VectorXd& at_plus,
                    const Eigen::VectorXd& at_minus) {
  Harmonics h(at_0.size(), 3);
  h.col(0) = (at_0 + at_plus + at_minus) / 3;
  h.col(1) = at_0 - h.col(0);
  h.col(2) = (at_plus - at_minus) / std::numbers::sqrt3;
  return h;
}

double argmax_of_magnitudes(const Harmonics& h, const Limits& whole) {
  const Limits range = within_a_turn(whole);
  std::vector<double> ends{range.lower, range.upper};
  for (Eigen::Index g = 0; g < h.rows(); ++g) {
    const double amplitude = std::hypot(h(g, 1), h(g, 2));
    if (!(std::abs(h(g, 0)) < amplitude)) continue;
    const double phase = std::atan2(h(g, 2), h(g, 1)), off = std::acos(-h(g, 0) / amplitude);
    for (const double zero : {phase + off, phase - off})
      for_each_inside(zero, range, [&](double t) { ends.push_back(t); });
  }
  std::sort(ends.begin(), ends.end());
  double best = range.lower, largest = -1;
  const auto consider = [&](double t) {
    const double value = sum_of_magnitudes(h, t);
    if (value > largest) largest = value, best = t;
  };
  for (std::size_t i = 0; i < ends.size(); ++i) {
    consider(ends[i]);
    if (i + 1 == ends.size()) break;
    const double middle = 0.5 * (ends[i] + ends[i + 1]), c = std::cos(middle), s = std::sin(middle);
    double along = 0, across = 0;
    for (Eigen::Index g = 0; g < h.rows(); ++g) {
      const double sign = h(g, 0) + h(g, 1) * c + h(g, 2) * s < 0 ? -1 : 1;
      along += sign * h(g, 1);
      across += sign * h(g, 2);
    }
    for_each_inside(std::atan2(across, along), {ends[i], ends[i + 1]}, consider);
  }
  return best;
}

double argmax_of_squares(const Harmonics& h, const Limits& whole) {
  const Limits range = within_a_turn(whole);
  // (a + b c + c s)^2 = a^2 + (b^2 + c^2)/2 + 2 a b cos + 2 a c sin + (b^2 - c^2)/2 cos 2t + b c sin 2t.
  const double c1 = 2 * h.col(0).dot(h.col(1)), s1 = 2 * h.col(0).dot(h.col(2)),
               c2 = 0.5 * (h.col(1).squaredNorm() - h.col(2).squaredNorm()), s2 = h.col(1).dot(h.col(2));
  const auto value = [&](double t) {
    return c1 * std::cos(t) + s1 * std::sin(t) + c2 * std::cos(2 * t) + s2 * std::sin(2 * t);
  };
  const auto slope = [&](double t) {
    return s1 * std::cos(t) - c1 * std::sin(t) + 2 * s2 * std::cos(2 * t) - 2 * c2 * std::sin(2 * t);
  };
  constexpr int samples = 64;
  double best = range.lower, largest = value(best);
  const auto consider = [&](double t) {
    if (value(t) > largest) largest = value(t), best = t;
  };
  double before = range.lower, slope_before = slope(before);
  for (int i = 1; i <= samples; ++i) {
    const double t = i == samples ? range.upper : range.lower + (range.upper - range.lower) * i / samples;
    const double slope_at = slope(t);
    if (slope_before > 0 && slope_at < 0) {  // a maximum between the two: bisection
      consider(bisect({before, t}, 52, [&](double x) { return slope(x) > 0; }).middle());
    }
    consider(t);
    before = t;
    slope_before = slope_at;
  }
  return best;
}

double argmax_by_search(const std::function<double(double)>& f, const Limits& range, int samples) {
  const double step = (range.upper - range.lower) / samples;
  const auto count = static_cast<std::size_t>(samples);
  std::vector<double> at, value;
  for (std::size_t i = 0; i <= count; ++i) {
    at.push_back(i == count ? range.upper : range.lower + step * static_cast<double>(i));
    value.push_back(f(at.back()));
  }
  std::vector<std::size_t> peaks;
  for (std::size_t i = 0; i <= count; ++i)
    if ((i == 0 || value[i] >= value[i - 1]) && (i == count || value[i] >= value[i + 1])) peaks.push_back(i);
  std::stable_sort(peaks.begin(), peaks.end(),
                   [&](std::size_t a, std::size_t b) { return value[a] > value[b]; });
  constexpr std::size_t refined = 3;  // the highest sample need not be at the highest peak
  peaks.resize(std::min(peaks.size(), refined));
  double best = at[peaks.front()], largest = value[peaks.front()];
  for (const std::size_t peak : peaks) {
    // 0.618^40 = 4e-9, whose square is lost in rounding.
    const double t =
        golden_section(at[peak == 0 ? 0 : peak - 1], at[std::min(peak + 1, count)], 40, f).middle();
    if (const double there = f(t); there > largest) largest = there, best = t;
  }
  return best;
}

namespace {

constexpr int most_rounds = 200;
constexpr double still_growing = 1 + 1e-12;

class Ascent {
 public:
  Ascent(const ErrorTerms& terms, const std::vector<Limits>& ranges, Eigen::VectorXd start)
      : terms_(terms), ranges_(ranges), q_(std::move(start)), value_(terms.value(q_)) {
    for (std::size_t j = 0; j < ranges.size(); ++j) moved_.push_back(terms.moved_by(j));
  }

  Eigen::VectorXd run() {
    for (int round = 0; round < most_rounds; ++round) {
      const Eigen::VectorXd before = q_;
      const double value_before = value_;
      for (std::size_t j = 0; j < ranges_.size(); ++j) improve(j);
      extrapolate(before);
      if (!(value_ > still_growing * value_before)) break;
    }
    return q_;
  }

 private:
  void improve(std::size_t joint) {
    const Limits& range = ranges_[joint];
    if (moved_[joint].empty() || !(range.lower < range.upper)) return;
    if (moved_[joint].size() > 1) return search(joint);
    const TermAxis& axis = terms_.axes()[moved_[joint].front()];
    if (!axis.turns) {
      accept(joint, range.lower);
      accept(joint, range.upper);
      return;
    }
    const double from = axis.multiplier * range.lower + axis.offset,
                 to = axis.multiplier * range.upper + axis.offset;
    const double t = along_turn(joint, axis, {std::min(from, to), std::max(from, to)});
    accept(joint, (t - axis.offset) / axis.multiplier);
  }

  /// The best angle of an axis.
  double along_turn(std::size_t joint, const TermAxis& axis, const Limits& angles) {
    constexpr double third = 2 * std::numbers::pi / 3;
    const auto at = [&](double angle) {
      Eigen::VectorXd q = q_;
      q[static_cast<Eigen::Index>(joint)] = (angle - axis.offset) / axis.multiplier;
      return terms_.vectors(terms_.columns(q));
    };
    const Eigen::Matrix3Xd v0 = at(0), v1 = at(third), v2 = at(-third);
    if (terms_.length() && !terms_.sigma()) {
      const Eigen::VectorXd corner = longest_corner();
      return argmax_of_squares(harmonics(v0 * corner, v1 * corner, v2 * corner), angles);
    }
    if (terms_.length())
      return argmax_of_squares(harmonics(weighted(v0), weighted(v1), weighted(v2)), angles);
    const Harmonics h = harmonics(weighted(v0), weighted(v1), weighted(v2));
    return terms_.sigma() ? argmax_of_squares(h, angles) : argmax_of_magnitudes(h, angles);
  }

  /// sigma_g v_g; of a worst case half_width_g u.v_g and the mean.
  Eigen::VectorXd weighted(const Eigen::Matrix3Xd& v) const {
    const std::vector<ErrorTerm>& list = terms_.terms();
    const Eigen::Index count = v.cols(), rows = terms_.length() ? 3 : 1,
                       first = terms_.length() ? 0 : terms_.row();
    Eigen::VectorXd values(rows * count + (terms_.sigma() ? 0 : 1));
    double mean = 0;
    for (Eigen::Index g = 0; g < count; ++g) {
      const ErrorTerm& term = list[static_cast<std::size_t>(g)];
      values.segment(rows * g, rows) =
          (terms_.sigma() ? term.sigma : term.half_width) * v.col(g).segment(first, rows);
      mean += term.mean * v(first, g);
    }
    if (!terms_.sigma()) values[rows * count] = mean;
    return values;
  }

  /// Of each term its signed half width and its mean at the longest corner, by flipping signs one by one.
  Eigen::VectorXd longest_corner() {
    const Eigen::Matrix3Xd v = terms_.vectors(terms_.columns(q_));
    const std::vector<ErrorTerm>& list = terms_.terms();
    Eigen::VectorXd mean(v.cols()), width(v.cols()), best;
    for (Eigen::Index g = 0; g < v.cols(); ++g) {
      mean[g] = list[static_cast<std::size_t>(g)].mean;
      width[g] = list[static_cast<std::size_t>(g)].half_width;
    }
    double longest = -1;
    for (Eigen::Index along = 0; along < v.cols() + 3; ++along) {  // from each term's direction, and the axes
      Eigen::Vector3d sum =
          along < v.cols() ? Eigen::Vector3d(v.col(along)) : Eigen::Vector3d::Unit(along - v.cols());
      Eigen::VectorXd corner;
      for (int step = 0; step < 8; ++step) {
        corner = mean + width.cwiseProduct(
                            (v.transpose() * sum).unaryExpr([](double x) { return x < 0 ? -1.0 : 1.0; }));
        const Eigen::Vector3d next = v * corner;
        if (next == sum) break;
        sum = next;
      }
      if (sum.norm() > longest) longest = sum.norm(), best = corner;
    }
    return best.size() > 0 ? best : mean;
  }

  void search(std::size_t joint) {
    Eigen::VectorXd q = q_;
    accept(joint, argmax_by_search(
                      [&](double at) {
                        q[static_cast<Eigen::Index>(joint)] = at;
                        return terms_.value(q);
                      },
                      ranges_[joint], 64));
  }

  void accept(std::size_t joint, double at) {
    Eigen::VectorXd q = q_;
    q[static_cast<Eigen::Index>(joint)] = std::clamp(at, ranges_[joint].lower, ranges_[joint].upper);
    accept(q);
  }

  bool accept(const Eigen::VectorXd& q) {
    const double value = terms_.value(q);
    if (!(value > value_)) return false;
    q_ = q;
    value_ = value;
    return true;
  }

  /// On a narrow ridge rounds take many small steps in one direction: steps of 2, 4, 8, ... rounds.
  void extrapolate(const Eigen::VectorXd& before) {
    const Eigen::VectorXd step = q_ - before;
    for (double times = 1; times <= 1024; times *= 2) {
      Eigen::VectorXd q = q_ + times * step;
      for (std::size_t j = 0; j < ranges_.size(); ++j) {
        double& at = q[static_cast<Eigen::Index>(j)];
        at = std::clamp(at, ranges_[j].lower, ranges_[j].upper);
      }
      if (!accept(q)) break;
    }
  }

  const ErrorTerms& terms_;
  const std::vector<Limits>& ranges_;
  Eigen::VectorXd q_;
  double value_;
  std::vector<std::vector<std::size_t>> moved_;
};

}  // namespace

Eigen::VectorXd ascend(const ErrorTerms& terms, const std::vector<Limits>& ranges, Eigen::VectorXd start) {
  return Ascent(terms, ranges, std::move(start)).run();
}

}  // namespace qerr
