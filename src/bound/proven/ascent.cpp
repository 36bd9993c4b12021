#include "bound/proven/ascent.hpp"

#include <cmath>
#include <numbers>

#include "bound/proven/line_maximum.hpp"

namespace qerr {

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
