#include "qerr/bound/proven_maximum.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <mutex>
#include <numbers>
#include <stdexcept>

#include "bound/proven/ascent.hpp"
#include "bound/proven/box_bound.hpp"
#include "bound/proven/chain_bound.hpp"
#include "core/parallel.hpp"
#include "core/text.hpp"
#include "qerr/core/error.hpp"

namespace qerr {

namespace {

constexpr double unbounded = std::numeric_limits<double>::infinity();

/// A finite range with the same configurations: joints whose axes all turn by whole multiples of its angle
/// repeat after one revolution.
Limits bounded_range(const Chain& chain, std::size_t joint, const Limits& range) {
  constexpr double pi = std::numbers::pi;
  if (range.upper - range.lower <= 2 * pi) return range;
  const bool periodic = std::ranges::all_of(chain.joints, [&](const ChainJoint& j) {
    return j.coordinate != joint || (!j.prismatic && j.multiplier == std::round(j.multiplier));
  });
  if (periodic) {
    const double lower = std::clamp(-pi, range.lower, range.upper - 2 * pi);
    return {std::isfinite(lower) ? lower : -pi, (std::isfinite(lower) ? lower : -pi) + 2 * pi};
  }
  if (std::isfinite(range.upper - range.lower)) return range;
  const std::string& name = chain.independent[joint].name;
  throw Error("configurations.limits." + name, "a proof over the joint's whole range needs its limits",
              "unlimited", "add configurations: {limits: {" + name + ": [-180 deg, 180 deg]}}");
}

/// What is proven of the position: its maximum times `factor` is that of the figure.
struct Proportional {
  Figure figure;
  double factor = 1, error = 0;  ///< of the factor, relative
};

Proportional proportional(const OperationalModel& model, const std::vector<Norms>& filters, Figure figure) {
  if (figure.bound == Bound::worst_case_rigorous) figure.bound = Bound::worst_case;
  const bool ideal = model.sources.empty() && !model.along_motion;
  if (figure.filter < 0 || !ideal || figure.bound == Bound::sigma_in_motion) return {figure};
  const Norms& norms = filters[figure.filter];
  const Figure of_position{figure.signal, -1, figure.bound};
  if (figure.bound == Bound::sigma)
    return {of_position, norms.h2, norms.h2 > 0 ? norms.h2_error / norms.h2 : 0};
  return mean_errors(model.transmission).isZero(0) ? Proportional{of_position, norms.l1.upper}
                                                   : Proportional{figure};
}

/// The largest linearization remainder over the ranges, and the bound of the whole rotation.
struct LargestRemainder {
  double added, most;
};

LargestRemainder largest_remainder(const OperationalModel& model, const ErrorTerms& terms, Coordinate c,
                                   const std::vector<Limits>& ranges) {
  const LinearizationRemainder r = linearization_remainder(model.chain, joint_error(model).worst_case);
  if (!is_position(c) && c != Coordinate::xyz) return {r.rotation, r.rotation_angle + terms.added()};
  const Eigen::VectorXd longest = terms.longest_columns(ranges);
  double sum = r.position;
  Eigen::Index joint = 0;
  for (std::size_t k = 0; k < terms.axes().size(); ++k)
    if (terms.axes()[k].of_joint) sum += longest[k] * r.per_column[joint++];
  return {sum * (1 + 64 * machine_epsilon), unbounded};
}

/// Local maximum of any function of the configuration, by searches along the joints; on a crest that runs
/// across them it creeps, so that the rounds are limited.
Eigen::VectorXd ascend_by_search(const std::function<double(const Eigen::VectorXd&)>& f,
                                 const std::vector<Limits>& ranges, Eigen::VectorXd q) {
  constexpr int most_rounds = 30;
  double before = -1, now = f(q);
  for (int i = 0; i < most_rounds && now > (1 + 1e-12) * before && std::isfinite(now); ++i, now = f(q)) {
    before = now;
    for (Eigen::Index j = 0; j < q.size(); ++j) {
      Eigen::VectorXd moved = q;
      moved[j] = argmax_by_search(
          [&](double at) {
            Eigen::VectorXd there = q;
            there[j] = at;
            return f(there);
          },
          ranges[j], 32);
      if (f(moved) > f(q)) q = moved;
    }
  }
  return q;
}

/// Proof of one figure, with its own model.
class Proof {
 public:
  /// @param limit  as in ProofOptions; infinite without one
  Proof(OperationalModel model, const Figure& figure, const std::vector<Limits>& ranges,
        const ProofOptions& options, double limit)
      : model_(std::move(model)),
        figure_(figure),
        ranges_(ranges),
        gap_(options.gap),
        limit_(limit),
        of_distance_(options.of_distance) {}

  ProvenMaximum run(const std::vector<Eigen::VectorXd>& starts) {
    const Signal signal = all_signals(model_)[figure_.signal];
    if (signal.kind || is_euler_angle(*signal.coordinate)) return search_only(signal, starts);
    const ErrorTerms terms(model_, figure_.signal, is_sigma(figure_.bound));
    if (terms.terms().empty())
      return {terms.added(), terms.added() * (1 + 4 * machine_epsilon) + rounding_of_nothing(),
              starts.front()};
    for (const Eigen::VectorXd& start : starts) consider(terms, start);
    result_.upper = unbounded;
    if (of_distance_ == 1 && result_.lower > limit_) return result_;
    widen_gap();
    rounding_ = rounding_allowance(terms, ranges_);
    const std::size_t joints = influential_joints(terms, ranges_);
    constexpr std::size_t few = 4,
                          many = 6;  // boxes fill their space: beyond, the chain's bound is always lower
    if (joints <= few) search_boxes(terms);
    if (!reached()) along_chain(rounding_);
    if (!reached() && joints > few && (joints < many || result_.upper == unbounded)) search_boxes(terms);
    return result_;
  }

 private:
  void widen_gap() {
    const bool far = std::isfinite(limit_) && limit_ > 0 && result_.lower > 0;
    const double distance = far ? std::max(limit_ / result_.lower, result_.lower / limit_) - 1 : 0;
    gap_ = std::max(gap_, of_distance_ == 1 ? distance : std::min(of_distance_ * distance, 1.0));
    result_.wanted_gap = gap_;
  }

  /// A bound that is the size of the rounding errors is as low as it can be: that of a figure that is zero.
  bool reached() const { return result_.upper <= std::max(result_.lower * (1 + gap_), 16 * rounding_); }

  /// Columns that cancel exactly, such as those of a joint and of one that turns back by as much, leave the
  /// rounding of the sum: a few dozen operations a joint on numbers up to the chain's length, or 1 of a
  /// rotation.
  double rounding_of_nothing() const {
    const Eigen::VectorXd largest = joint_error(model_).worst_case;
    double errors = 0, length = 1 + model_.chain.tip_offset.translation().norm();
    for (const ChainJoint& joint : model_.chain.joints) {
      const Limits& range = ranges_[joint.coordinate];
      errors += std::abs(joint.multiplier) * largest[joint.coordinate];
      length += joint.origin.translation().norm();
      if (joint.prismatic)
        length += std::abs(joint.offset) +
                  std::abs(joint.multiplier) * std::max(std::abs(range.lower), std::abs(range.upper));
    }
    return 64 * static_cast<double>(model_.chain.joints.size()) * machine_epsilon * errors * length;
  }

  void consider(const ErrorTerms& terms, const Eigen::VectorXd& start) {
    const Eigen::VectorXd q = ascend(terms, ranges_, start);
    const double value = terms.value(q);
    if (result_.at.size() > 0 && !(value > result_.lower)) return;
    result_.lower = value;
    result_.at = q;
  }

  void search_boxes(const ErrorTerms& terms) {
    const SearchedMaximum found = branch_and_bound(terms, ranges_, result_.lower, gap_, boxes_of_gap(gap_));
    result_.upper = std::min(result_.upper, found.upper);
    consider(terms, found.at);
  }

  void along_chain(double rounding) {
    const auto upper = chain_upper_bound(model_, ranges_, figure_, result_.lower, gap_);
    if (upper) result_.upper = std::min(result_.upper, *upper + rounding);
  }

  /// No bound is known but of a signal that has one value.
  ProvenMaximum search_only(const Signal& signal, const std::vector<Eigen::VectorXd>& starts) {
    constexpr std::size_t few = 8;
    FigureValues values(model_, {}, {});
    const Figure figure{figure_.signal, -1, is_sigma(figure_.bound) ? Bound::sigma : Bound::worst_case};
    const auto value = [&](const Eigen::VectorXd& q) { return values({figure}, {q})[0][0]; };
    if (signal.kind && signal.kind->constant) {
      const double only = value(starts.front());
      return {only, only * (1 + 4 * machine_epsilon), starts.front()};
    }
    std::vector<Eigen::VectorXd> best = starts;
    std::ranges::stable_sort(best, [&](const auto& a, const auto& b) { return value(a) > value(b); });
    best.resize(std::min(best.size(), few));
    result_.lower = -1;
    for (const Eigen::VectorXd& start : best) {
      const Eigen::VectorXd q = ascend_by_search(value, ranges_, start);
      if (value(q) > result_.lower) result_.lower = value(q), result_.at = q;
    }
    result_.upper = unbounded;
    return result_;
  }

  OperationalModel model_;
  Figure figure_;
  const std::vector<Limits>& ranges_;
  double gap_, limit_, of_distance_, rounding_ = 0;
  ProvenMaximum result_;
};

/// Tells of the proofs that are done, from any thread.
class DoneProofs {
 public:
  DoneProofs(const ProofOptions& options, std::size_t total) : options_(options), total_(total) {}

  void add() {
    const std::lock_guard lock(mutex_);
    ++done_;
    if (options_.progress) options_.progress(done_, total_);
  }

 private:
  const ProofOptions& options_;
  std::uint64_t done_ = 0, total_;
  std::mutex mutex_;
};

/// Figures of signals that are no coordinates of other chains.
std::vector<ProvenMaximum> maxima_of_model(const OperationalModel& model, const std::vector<Norms>& filters,
                                           const std::vector<Limits>& given_ranges,
                                           const std::vector<Figure>& figures, const ProofOptions& options) {
  if (figures.empty()) return {};
  std::vector<Limits> ranges;
  for (std::size_t j = 0; j < given_ranges.size(); ++j)
    ranges.push_back(bounded_range(model.chain, j, given_ranges[j]));
  std::vector<Figure> jobs;  // without duplicates
  for (const Figure& figure : figures) jobs.push_back(proportional(model, filters, figure).figure);
  std::ranges::sort(jobs);
  jobs.erase(std::unique(jobs.begin(), jobs.end()), jobs.end());
  std::vector<OperationalModel> models;
  for (const Figure& job : jobs) models.push_back(figure_model(model, filters, options.noise_in_motion, job));

  // The strictest limit of the figures that a job proves, in units of the job's figure.
  const auto limit_of_job = [&](const Figure& job) {
    double limit = unbounded;
    for (std::size_t i = 0; i < options.limits.size(); ++i) {
      const Proportional of = proportional(model, filters, figures[i]);
      const bool scaled = of.factor > 0 && figures[i].bound != Bound::worst_case_rigorous;
      if (of.figure == job) limit = scaled ? std::min(limit, options.limits[i] / of.factor) : unbounded;
      if (of.figure == job && !scaled) break;
    }
    return limit;
  };

  FigureValues values(model, filters, options.noise_in_motion);
  std::vector<std::vector<Eigen::VectorXd>> starts = values.best_samples(jobs, ranges);
  std::vector<ProvenMaximum> proven(jobs.size());
  DoneProofs done(options, jobs.size());
  parallel_for(jobs.size(), options.threads, [&](std::size_t i) {
    starts[i].insert(starts[i].end(), options.starts.begin(), options.starts.end());
    proven[i] = Proof(models[i], jobs[i], ranges, options, limit_of_job(jobs[i])).run(starts[i]);
    proven[i].wanted_gap = std::max(proven[i].wanted_gap, options.gap);
    done.add();
  });

  std::vector<ProvenMaximum> results;
  for (const Figure& figure : figures) {
    const Proportional of = proportional(model, filters, figure);
    ProvenMaximum result = proven[std::ranges::lower_bound(jobs, of.figure) - jobs.begin()];
    if (figure.bound == Bound::worst_case_rigorous) {
      const Signal signal = all_signals(model)[figure.signal];
      if (signal.kind) {
        result.upper += signal.kind->remainder(model, signal.index, result.at, joint_error(model).worst_case);
      } else if (!is_euler_angle(*signal.coordinate)) {
        const ErrorTerms terms(model, figure.signal, false);
        const LargestRemainder r = largest_remainder(model, terms, *signal.coordinate, ranges);
        result.upper = std::min(result.upper + r.added, r.most) * (1 + 4 * machine_epsilon);
      }
    }
    result.upper *= of.factor * (1 + of.error) * (1 + 4 * machine_epsilon);
    set_reached(result, values({figure}, {result.at})[0][0]);
    results.push_back(std::move(result));
  }
  return results;
}

}  // namespace

double ProvenMaximum::gap() const { return lower == upper ? 0 : upper / lower - 1; }

void set_reached(ProvenMaximum& m, double value) {
  if (value > m.upper * (1 + 1e-9)) throw std::logic_error("a configuration exceeds the proven maximum");
  m.lower = value;
  m.upper = std::max(m.upper, value);
}

std::vector<ProvenMaximum> proven_maxima(const OperationalModel& model, const std::vector<Norms>& filters,
                                         const std::vector<Limits>& ranges,
                                         const std::vector<Figure>& figures, const ProofOptions& options) {
  // Coordinates of other chains are proven with those, all figures of a signal together.
  const std::vector<Signal> signals = all_signals(model);
  std::map<std::size_t, std::vector<std::size_t>> of_signal;  // places in `figures`
  const std::size_t own = signals.size();
  for (std::size_t i = 0; i < figures.size(); ++i) {
    const Signal& s = signals[figures[i].signal];
    of_signal[s.kind && s.kind->of_chain ? figures[i].signal : own].push_back(i);
  }
  std::vector<ProvenMaximum> all(figures.size());
  for (const auto& [signal, places] : of_signal) {
    ProofOptions some = options;
    std::vector<Figure> proven;
    some.limits.clear();
    for (const std::size_t i : places) {
      proven.push_back(figures[i]);
      if (signal != own) proven.back().signal = 0;
      if (!options.limits.empty()) some.limits.push_back(options.limits[i]);
    }
    const std::vector<ProvenMaximum> maxima = maxima_of_model(
        signal == own ? model : coordinate_model(model, signal), filters, ranges, proven, some);
    for (std::size_t k = 0; k < places.size(); ++k) all[places[k]] = maxima[k];
  }
  return all;
}

}  // namespace qerr
