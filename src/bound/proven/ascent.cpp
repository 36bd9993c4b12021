#include "bound/proven/ascent.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/search.hpp"
#include "kinematics/sampler.hpp"
#include "qerr/bound/workspace.hpp"
#include "qerr/core/error.hpp"

namespace qerr {

namespace {

Error not_known(const std::string& what, const std::string& remedy) {
  return Error("requirements", what + ": its maximum cannot be proven", "", remedy);
}

/// Encoders of the resolutions times a factor each, that round to nearest.
void scale_encoders(OperationalModel& model, const Eigen::VectorXd& factors) {
  for (std::size_t i = 0; i < model.transmission.encoders.size(); ++i) {
    Encoder& encoder = model.transmission.encoders[i];
    encoder.resolution *= factors[i];
    encoder.rounding = Rounding::nearest;
  }
}

/// @param length  whose largest length of displaced origins, mean included, is multiplied by ||H||_1
/// (signal_errors.hpp)
void set_worst_case(OperationalModel& model, const Norms& norms, bool length) {
  const Eigen::VectorXd means = mean_errors(model.transmission);
  scale_encoders(model, Eigen::VectorXd::Constant(means.size(), norms.l1.upper));
  for (IndependentError& s : model.sources) {
    s.half_width *= norms.l1.upper;
    s.mean *= length && s.where == IndependentError::Where::origin ? norms.l1.upper : norms.dc_gain;
  }
  for (Eigen::Index i = 0; i < means.size(); ++i) {
    if (means[i] == 0 || norms.dc_gain == 0) continue;
    IndependentError bias{IndependentError::Where::encoder, static_cast<std::size_t>(i)};
    bias.mean = norms.dc_gain * means[i];
    model.sources.push_back(std::move(bias));
  }
}

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
      q[joint] = (angle - axis.offset) / axis.multiplier;
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
      const ErrorTerm& term = list[g];
      values.segment(rows * g, rows) =
          (terms_.sigma() ? term.sigma : term.half_width) * v.col(g).segment(first, rows);
      mean += term.mean * v(first, g);
    }
    if (!terms_.sigma()) values[rows * count] = mean;
    return values;
  }

  /// Signed half width and mean of each term at the longest corner, by flipping signs one by one.
  Eigen::VectorXd longest_corner() {
    const Eigen::Matrix3Xd v = terms_.vectors(terms_.columns(q_));
    const std::vector<ErrorTerm>& list = terms_.terms();
    Eigen::VectorXd mean(v.cols()), width(v.cols()), best;
    for (Eigen::Index g = 0; g < v.cols(); ++g) {
      mean[g] = list[g].mean;
      width[g] = list[g].half_width;
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
                        q[joint] = at;
                        return terms_.value(q);
                      },
                      ranges_[joint], 64));
  }

  void accept(std::size_t joint, double at) {
    Eigen::VectorXd q = q_;
    q[joint] = std::clamp(at, ranges_[joint].lower, ranges_[joint].upper);
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
        double& at = q[j];
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

OperationalModel figure_model(const OperationalModel& position, const std::vector<Norms>& filters,
                              const std::vector<Eigen::VectorXd>& noise_in_motion, const Figure& figure) {
  OperationalModel model = position;
  if (figure.filter < 0) return model;
  const auto f = static_cast<std::size_t>(figure.filter);
  if (model.along_motion) model.along_motion->tip = model.along_motion->filtered[f];
  if (!is_sigma(figure.bound)) {
    set_worst_case(model, filters[f], is_length(all_signals(model)[figure.signal]));
    return model;
  }
  if (!sigma_is_known(model.sources, f))
    throw not_known(
        "sigma behind a filter is not known: it depends on the motion, of which nothing is stated",
        "add `motion:`, or velocity to the joints' <limit> in the URDF; or ask for worst_case");
  const bool in_motion = figure.bound == Bound::sigma_in_motion;
  if (in_motion && !is_known(noise_in_motion, f))
    throw not_known("sigma in motion is not known", "ask for sigma, or for worst_case");
  const auto count = std::ssize(model.transmission.encoders);
  const Eigen::VectorXd ratios = sigma_ratios(model.sources, f, filters[f].h2, in_motion);
  for (std::size_t i = 0; i < model.sources.size(); ++i) model.sources[i].sigma *= ratios[i];
  scale_encoders(model, in_motion ? Eigen::VectorXd(std::sqrt(12.0) * noise_in_motion[f])
                                  : Eigen::VectorXd::Constant(count, filters[f].h2));
  return model;
}

FigureValues::FigureValues(const OperationalModel& model, const std::vector<Norms>& filters,
                           const std::vector<Eigen::VectorXd>& noise_in_motion)
    : filters_(filters),
      errors_(model,
              {.rigorous = true, .shares = false, .filters = filters, .noise_in_motion = noise_in_motion}),
      joints_(model.chain.independent.size()),
      q_(joints_ * batch_size),
      figures_(errors_.figures().count * batch_size) {}

double FigureValues::value(const Figure& figure, std::size_t configuration) const {
  const FigureColumn column = figure_column(figure, filters_, errors_.figures());
  return column.factor * figures_[column.figure * batch_size + configuration];
}

std::vector<std::vector<double>> FigureValues::operator()(
    const std::vector<Figure>& figures, const std::vector<Eigen::VectorXd>& configurations) {
  std::vector<std::vector<double>> values(figures.size());
  for (std::size_t first = 0; first < configurations.size(); first += batch_size) {
    const std::size_t count = std::min<std::size_t>(batch_size, configurations.size() - first);
    for (std::size_t i = 0; i < batch_size; ++i)
      for (std::size_t j = 0; j < joints_; ++j)
        q_[j * batch_size + i] = configurations[first + std::min(i, count - 1)][j];
    errors_(q_.data(), figures_.data());
    for (std::size_t f = 0; f < figures.size(); ++f)
      for (std::size_t i = 0; i < count; ++i) values[f].push_back(value(figures[f], i));
  }
  return values;
}

std::vector<std::vector<Eigen::VectorXd>> FigureValues::best_samples(const std::vector<Figure>& figures,
                                                                     const std::vector<Limits>& ranges) {
  constexpr std::uint64_t blocks = 64, block = 1024;
  const Configurations points{.method = SamplingMethod::sobol, .count = blocks * block, .ranges = ranges};
  Sampler sampler(points);
  std::vector<std::vector<Eigen::VectorXd>> best(figures.size());
  std::vector<double> largest(figures.size());
  for (std::uint64_t first = 0; first < blocks * block; first += batch_size) {
    sampler(first, q_.data());
    errors_(q_.data(), figures_.data());
    const bool fresh = first % block == 0;
    for (std::size_t f = 0; f < figures.size(); ++f)
      for (std::size_t i = 0; i < batch_size; ++i) {
        const double here = value(figures[f], i);
        if (fresh && i == 0)
          best[f].emplace_back(static_cast<Eigen::Index>(joints_));
        else if (!(here > largest[f]))
          continue;
        largest[f] = here;
        for (std::size_t j = 0; j < joints_; ++j) best[f].back()[j] = q_[j * batch_size + i];
      }
  }
  return best;
}

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
  std::ranges::sort(ends);
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
  std::ranges::stable_sort(peaks, [&](std::size_t a, std::size_t b) { return value[a] > value[b]; });
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

Eigen::VectorXd ascend(const ErrorTerms& terms, const std::vector<Limits>& ranges, Eigen::VectorXd start) {
  return Ascent(terms, ranges, std::move(start)).run();
}

}  // namespace qerr
