#include <algorithm>
#include <cmath>

#include "core/lists.hpp"
#include "core/parallel.hpp"
#include "core/random.hpp"
#include "filter/run/cascade.hpp"
#include "qerr/bound/velocity_estimators.hpp"
#include "qerr/core/error.hpp"
#include "simulate/along_motion.hpp"
#include "simulate/estimators/estimator.hpp"
#include "simulate/run.hpp"
#include "simulate/sensing.hpp"

namespace qerr {

namespace {

/// Estimates of an encoder's velocity, [row][sample of all runs, one after another].
using Estimates = std::vector<std::vector<double>>;

/// What is compared, rows being the filters and then the estimators.
struct ComparedMotion {
  const OperationalModel& model;
  const std::vector<VelocityFilter>& filters;
  const std::vector<EstimatorDesign>& estimators;
  const Motion& motion;
  const std::vector<Effect>& effects;
  const SimulationOptions& options;
  MotionPath path;
  Coupling to_encoders;
  std::size_t samples = 0, first = 0;  ///< of a run, and the first one behind the settling

  std::size_t rows() const { return filters.size() + estimators.size(); }
  double time(std::size_t sample) const { return static_cast<double>(sample) / motion.sample_rate; }
  const std::string& joint_name(std::size_t j) const { return model.chain.independent[j].name; }

  /// The filter of a row uses every n-th sample; an estimator each.
  std::size_t every(std::size_t row) const {
    return row < filters.size() ? divisor_of(filters[row].filter, motion) : 1;
  }
  bool applies(std::size_t row, std::size_t joint) const {
    const auto& joints = row < filters.size() ? filters[row].joints : estimators[row - filters.size()].joints;
    return joints.empty() || contains(joints, joint);
  }
};

/// Between two turning points of a joint, at least a quarter of the period of its fastest sine; of moves and
/// tables a quarter of a sample.
double sub_step(const Motion& motion) {
  double fastest = motion.sample_rate;
  for (const JointMotion& joint : motion.joints)
    for (const Sine& s : joint.sines) fastest = std::max(fastest, 8 * s.frequency);
  return 1 / (fastest * (motion.joints.empty() ? 4 : 1));
}

EncoderPath path_of(const ComparedMotion& c, std::size_t encoder, double displacement) {
  std::vector<std::pair<std::size_t, double>> parts;
  for (std::size_t j = 0; j < c.path.joints(); ++j)
    if (const double part = c.to_encoders(encoder, j); part != 0) parts.emplace_back(j, part);
  const auto sum = [&path = c.path, parts](double time, double JointState::*value) {
    double all = 0;
    for (const auto& [joint, part] : parts) all += part * (path.at(joint, time).*value);
    return all;
  };
  return {[=](double t) { return displacement + sum(t, &JointState::position); },
          [=](double t) { return sum(t, &JointState::velocity); }, sub_step(c.motion)};
}

void require_edges_apart(const ComparedMotion& c, std::size_t encoder) {
  const EdgeErrors edges =
      edge_errors(c.model.transmission.encoders[encoder], c.effects, c.joint_name(encoder));
  if (edges.shortest > 0 && edges.slope < 1) return;
  throw Error("effects", "the errors of the disc let edges of the encoder coincide, which cannot be timed",
              "joint " + c.joint_name(encoder), "reduce the effects, or leave out estimators with a clock");
}

/// Adds one run of one encoder.
/// @param counts  at the samples
void run_encoder(const ComparedMotion& c, std::size_t encoder, const std::vector<double>& counts,
                 double displacement, Estimates& all) {
  const Encoder& e = c.model.transmission.encoders[encoder];
  for (std::size_t row = 0; row < c.filters.size(); ++row) {
    Cascade<double> filter(c.filters[row].filter);
    const std::size_t every = c.every(row);
    for (std::size_t n = 0; n < c.samples; n += every)
      all[row].push_back(filter.step((counts[n] - counts[0]) * e.resolution));
  }
  if (c.estimators.empty()) return;
  bool timed = false;
  std::vector<VelocityEstimate> estimates;
  for (const EstimatorDesign& d : c.estimators) {
    const EstimatorKind& kind = estimator_kind(d.kind);
    timed = timed || kind.timed;
    estimates.push_back(kind.make(d, {e.resolution, 1 / c.motion.sample_rate, e.counts_per_period}));
  }
  if (timed) require_edges_apart(c, encoder);
  EdgeFinder finder(e, disc_actions(c.effects, e, c.joint_name(encoder)), path_of(c, encoder, displacement),
                    0);
  const std::vector<Edge> none;
  for (std::size_t n = 0; n < c.samples; ++n) {
    const CounterSample sample{c.time(n), counts[n], timed ? finder.until(c.time(n)) : none};
    for (std::size_t i = 0; i < estimates.size(); ++i)
      all[c.filters.size() + i].push_back(estimates[i](sample) * e.resolution);
  }
}

/// The counts of one run, [encoder][sample].
std::vector<std::vector<double>> counts_of_run(const ComparedMotion& c, std::uint64_t run,
                                               const Eigen::VectorXd& displacement) {
  Sensing sensing(c.model, c.motion, c.effects, {displacement, random_bits(c.options.seed, run, 0)},
                  c.options.instructions);
  std::vector<std::vector<double>> counts(c.model.transmission.encoders.size());
  for (std::size_t first = 0; first < c.samples; first += batch_size) {
    const std::size_t count = std::min<std::size_t>(batch_size, c.samples - first);
    const SensedBatch& batch = sensing.sense(first, count);
    for (std::size_t e = 0; e < counts.size(); ++e)
      counts[e].insert(counts[e].end(), batch.counts + e * batch_size, batch.counts + e * batch_size + count);
  }
  return counts;
}

/// An estimate of a joint's velocity at the instants that are judged.
struct VelocitySeries {
  std::vector<double> time, estimate, velocity;
};

VelocitySeries series_of(const ComparedMotion& c, std::size_t row, std::size_t joint,
                         const std::vector<Estimates>& encoders) {
  VelocitySeries s;
  const std::size_t every = c.every(row), of_run = (c.samples + every - 1) / every;
  for (std::size_t i = 0; i < encoders[0][row].size(); ++i) {
    const std::size_t sample = i % of_run * every;
    if (sample < c.first) continue;
    double estimate = 0;
    for (std::size_t e = 0; e < encoders.size(); ++e)
      estimate += c.model.transmission.coupling(joint, e) * encoders[e][row][i];
    s.time.push_back(c.time(sample));
    s.estimate.push_back(estimate);
    s.velocity.push_back(c.path.at(joint, s.time.back()).velocity);
  }
  return s;
}

/// The delay at which the true velocity fits best; empty where it does not change.
std::optional<double> delay_of(const ComparedMotion& c, std::size_t joint, const VelocitySeries& s) {
  constexpr std::size_t most = 4000;  // samples, whose errors of the delay are far below those of the noise
  const std::size_t stride = (s.time.size() + most - 1) / most;
  const double longest = 0.5 * c.motion.duration;
  const auto square_at = [&](double late) {
    double sum = 0;
    for (std::size_t k = 0; k < s.time.size(); k += stride)
      sum += std::pow(s.estimate[k] - c.path.at(joint, s.time[k] - late).velocity, 2);
    return sum;
  };
  double delay = 0;
  for (int i = 0; i < 20; ++i) {
    double products = 0, squares = 0;
    for (std::size_t k = 0; k < s.time.size(); k += stride) {
      const JointState at = c.path.at(joint, s.time[k] - delay);
      products += (s.estimate[k] - at.velocity) * at.acceleration;
      squares += at.acceleration * at.acceleration;
    }
    if (!(squares > 0)) return std::nullopt;
    const double step = -products / squares;
    delay += step;
    if (!(std::abs(delay) < longest)) return std::nullopt;
    if (std::abs(step) < 1e-6 / c.motion.sample_rate) break;
  }
  // An estimate that does not follow the velocity may lead to another stationary point, or to none.
  const double least = square_at(delay), beside = 0.01 / c.motion.sample_rate;
  if (least > square_at(0) || least > square_at(delay - beside) || least > square_at(delay + beside))
    return std::nullopt;
  return delay;
}

/// Rms errors in classes of equal ratio over the last three decades of the speed.
std::vector<ErrorAtSpeed> by_speed(const VelocitySeries& s) {
  constexpr int classes = 18;
  constexpr double decades = 3;
  double largest = 0;
  for (const double v : s.velocity) largest = std::max(largest, std::abs(v));
  std::vector<double> count(classes), speed(classes), square(classes);
  for (std::size_t k = 0; k < s.velocity.size(); ++k) {
    const double v = std::abs(s.velocity[k]), error = s.estimate[k] - s.velocity[k];
    const double place = v > 0 ? classes * (1 + std::log10(v / largest) / decades) : 0;
    const auto i = static_cast<std::size_t>(std::clamp(place, 0.0, classes - 1.0));
    count[i] += 1;
    speed[i] += v;
    square[i] += error * error;
  }
  std::vector<ErrorAtSpeed> all;
  for (std::size_t i = 0; i < classes; ++i)
    if (count[i] > 0) all.push_back({speed[i] / count[i], std::sqrt(square[i] / count[i])});
  return all;
}

/// Bound of the error that the counts make; empty with errors of other sources, or where none is known, as of
/// the timing of edges at a speed that changes between them, or before there are two.
std::optional<double> bound_of(const ComparedMotion& c, std::size_t row, std::size_t joint,
                               const VelocitySeries& s) {
  const Transmission& t = c.model.transmission;
  if (row < c.filters.size()) {
    if (!c.effects.empty()) return std::nullopt;
    return c.filters[row].norms.l1.upper * 0.5 * t.coupling.row(joint).cwiseAbs().dot(resolutions(t));
  }
  const EstimatorDesign& d = c.estimators[row - c.filters.size()];
  const bool edges = d.choices.contains("edges") && d.choices.at("edges") == "all";
  if (!edges || !t.coupling.is_identity() || s.velocity.empty()) return std::nullopt;
  const auto [slowest, fastest] = std::minmax_element(s.velocity.begin(), s.velocity.end());
  const double speed = std::abs(s.velocity.front());
  if (*fastest - *slowest > 1e-9 * speed || s.estimate.front() == 0) return std::nullopt;
  for (const Effect& e : c.effects)
    if (const Stage stage = effect_kind(e.type).stage; stage != Stage::disc && stage != Stage::line)
      return std::nullopt;
  const double bound = inverse_time_error(t.encoders[joint].resolution, d.numbers.at("clock"), speed,
                                          edge_errors(t.encoders[joint], c.effects, c.joint_name(joint)))
                           .varying;
  return std::isfinite(bound) ? std::optional(bound) : std::nullopt;
}

EstimatedVelocity judged(const ComparedMotion& c, std::size_t row, std::size_t joint,
                         const VelocitySeries& s) {
  EstimatedVelocity r;
  const bool filter = row < c.filters.size();
  r.estimator = filter ? c.filters[row].name : c.estimators[row - c.filters.size()].name;
  r.kind = filter ? "filter" : c.estimators[row - c.filters.size()].kind;
  r.joint = joint;
  r.delay = delay_of(c, joint, s);
  double square = 0, noise = 0, tracking = 0;
  for (std::size_t k = 0; k < s.time.size(); ++k) {
    const double error = s.estimate[k] - s.velocity[k],
                 late = r.delay ? c.path.at(joint, s.time[k] - *r.delay).velocity : s.velocity[k];
    square += error * error;
    noise += (s.estimate[k] - late) * (s.estimate[k] - late);
    tracking += (late - s.velocity[k]) * (late - s.velocity[k]);
    r.worst = std::max(r.worst, std::abs(error));
  }
  const auto count = static_cast<double>(std::max<std::size_t>(s.time.size(), 1));
  r.rms = std::sqrt(square / count);
  r.noise = std::sqrt(noise / count);
  r.tracking = std::sqrt(tracking / count);
  r.by_speed = by_speed(s);
  r.worst_case = bound_of(c, row, joint, s);
  return r;
}

}  // namespace

std::vector<EstimatedVelocity> compare_velocities(const OperationalModel& model,
                                                  const std::vector<VelocityFilter>& filters,
                                                  const std::vector<EstimatorDesign>& estimators,
                                                  const Motion& motion, const std::vector<Effect>& effects,
                                                  double settling, const SimulationOptions& options) {
  const auto samples = static_cast<std::size_t>(std::floor(motion.duration * motion.sample_rate + 0.5));
  const auto first = static_cast<std::size_t>(std::ceil(settling * motion.sample_rate - 1e-9));
  const ComparedMotion c{model,
                         filters,
                         estimators,
                         motion,
                         effects,
                         options,
                         MotionPath(motion),
                         model.transmission.coupling.inverse(),
                         samples,
                         std::min(first, samples)};
  for (std::size_t row = 0; row < filters.size(); ++row) c.every(row);  // refuses
  const std::size_t joints = model.chain.independent.size();
  std::vector<Estimates> encoders(joints, Estimates(c.rows()));
  for (std::uint64_t run = 0; run < options.runs; ++run) {
    const Eigen::VectorXd displacement = displacement_of_run(model.transmission, options, run);
    const std::vector<std::vector<double>> counts = counts_of_run(c, run, displacement);
    parallel_for(joints, options.threads,
                 [&](std::size_t e) { run_encoder(c, e, counts[e], displacement[e], encoders[e]); });
  }
  std::vector<EstimatedVelocity> all;
  for (std::size_t joint = 0; joint < joints; ++joint) {
    const auto begin = std::ssize(all);
    for (std::size_t row = 0; row < c.rows(); ++row)
      if (c.applies(row, joint)) all.push_back(judged(c, row, joint, series_of(c, row, joint, encoders)));
    std::stable_sort(all.begin() + begin, all.end(),
                     [](const EstimatedVelocity& a, const EstimatedVelocity& b) { return a.rms < b.rms; });
  }
  return all;
}

}  // namespace qerr
