#include "diagnose/inference/scatter.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/solve.hpp"
#include "core/statistics.hpp"
#include "diagnose/inference/finding.hpp"
#include "diagnose/inference/found_parameters.hpp"
#include "qerr/effect/effect_kind.hpp"

namespace qerr {

namespace {

constexpr Eigen::Index blocks = 32, patterns = 3, fewest_rows = 16;  // per block

std::size_t state_of(double edge) { return static_cast<std::size_t>(edge - 4 * std::floor(edge / 4)); }

/// Counts that a model says the decoder has added, in whole ones: behind a loss the disc's edges have other
/// numbers.
Eigen::ArrayXd added_by_decoder(const Evidence& e, const Explanation& m) {
  Eigen::ArrayXd counts = Eigen::ArrayXd::Zero(e.rows());
  for (std::size_t i = 0; i < m.terms().size(); ++i)
    if (const Term& t = m.terms()[i]; t.named() && effect_kind(t.effect.type).stage == Stage::decoder)
      counts += (addition(t, m.coefficients(i)) / e.step()).round();
  return counts;
}

/// The disc's states, by number, that the readings show.
Eigen::ArrayXd states_of_disc(const Evidence& e, const Explanation& m) {
  return (e.measured / e.step()).round() - added_by_decoder(e, m);
}

/// Displacements of the four edges from their mean, by the states [first, end). NaN: an edge has no
/// readings.
Eigen::Vector4d displacements(const Eigen::ArrayXd& states, const Eigen::ArrayXd& position,
                              Eigen::Index first, Eigen::Index end) {
  Eigen::Vector4d wrong = Eigen::Vector4d::Zero(), all = Eigen::Vector4d::Zero();
  for (Eigen::Index i = first; i < end; ++i) {
    const double state = states[i], edge = std::round(position[i]);
    if (state != edge && state != edge - 1) continue;
    const std::size_t k = state_of(edge);
    const bool above = state == edge, expected = position[i] >= edge;
    wrong[static_cast<Eigen::Index>(k)] += static_cast<double>(expected) - static_cast<double>(above);
    all[static_cast<Eigen::Index>(k)] += 1;
  }
  const Eigen::Vector4d d = wrong.cwiseQuotient(all);
  return d.array() - d.mean();
}

}  // namespace

double EdgePattern::largest() const {
  double most = 0;
  for (const double d : displacement) most = std::max(most, std::abs(d));
  return most;
}

EdgePattern edge_pattern(const Evidence& e, const Explanation& m) {
  EdgePattern p;
  const Eigen::Index n = e.rows();
  // A reference that is coarser than a count has a pattern of its own over the counts.
  if (!e.counted || e.path_noise > e.step() || n < blocks * fewest_rows) return p;
  // In counts, with the edges at whole numbers: edge k at the position k.
  const Eigen::ArrayXd position =
      (e.path + m.addition()) / e.step() + below_reading(e.encoder) - added_by_decoder(e, m);
  const Eigen::ArrayXd states = states_of_disc(e, m);
  Eigen::MatrixXd contrasts(blocks, patterns);
  Eigen::Matrix<double, patterns, 4> basis;
  basis << -0.5, 0.5, -0.5, 0.5, 1, 0, -1, 0, 0, 1, 0, -1;
  for (Eigen::Index b = 0; b < blocks; ++b)
    contrasts.row(b) = basis * displacements(states, position, b * n / blocks, (b + 1) * n / blocks);
  if (!contrasts.allFinite()) return p;
  const Eigen::RowVectorXd mean = contrasts.colwise().mean();
  const Eigen::MatrixXd about = contrasts.rowwise() - mean;
  constexpr double b = blocks, d = patterns;
  Eigen::MatrixXd covariance = about.transpose() * about / (b * (b - 1));
  covariance.diagonal().array() += 1e-12;
  const double t_squared = mean * solve_symmetric(covariance, mean.transpose());
  p.p_value = fisher_f_tail(t_squared * (b - d) / (d * (b - 1)), d, b - d);
  const Eigen::Vector4d all = displacements(states, position, 0, n);
  for (std::size_t k = 0; k < 4; ++k) p.displacement[k] = all[static_cast<Eigen::Index>(k)];
  p.alternating = basis.row(0) * all;
  p.alternating_error = std::sqrt(covariance(0, 0));
  return p;
}

Intervals displaced(const Evidence& e, const Explanation& m, const EdgePattern& p) {
  Intervals intervals = m.intervals();
  const Eigen::ArrayXd states = states_of_disc(e, m);
  for (Eigen::Index i = 0; i < e.rows(); ++i) {
    intervals.lower[i] += p.displacement[state_of(states[i])] * e.step();
    intervals.upper[i] += p.displacement[state_of(states[i] + 1)] * e.step();
  }
  return intervals;
}

namespace {

constexpr double significant = 1e-3;  ///< p-value, corrected for the number of candidates

/// Largest loss of log-likelihood of an alternative: half the 99.95 % quantile of chi-squared.
constexpr double indistinguishable = 6.05;

/// The reference's noise is an estimate: the null hypothesis has its variance times 1.69, the square of
/// scatter_beyond_reference.
constexpr double inflated_noise = 1.69;

/// Displacements of edges that are reported [counts]: good discs have a few percent.
constexpr double displacement_worth_naming = 0.05;

/// Argument and value of the maximum of a function over low .. high, on a logarithmic grid that is refined.
template <typename Function>
std::pair<double, double> largest(Function function, double low, double high) {
  double best = low, at_best = function(low);
  double step = std::log(high / low) / 12;
  for (double x = low * std::exp(step); x <= high * 1.0001; x *= std::exp(step))
    if (const double y = function(x); y > at_best) at_best = y, best = x;
  for (int i = 0; i < 5; ++i) {
    step /= 2;
    for (const double x : {best * std::exp(-step), best * std::exp(step)})
      if (const double y = function(x); y > at_best) at_best = y, best = x;
  }
  return {best, at_best};
}

/// Whether the residual's variance over the expected one differs between twelfths of the rows, sorted by
/// `along`, by more than a ratio.
///
/// The ratio of two such variances of m rows has the standard deviation 2/sqrt m; of the largest and the
/// least of twelve, six of them are exceeded with a probability below 1e-3. A scatter that depends on the
/// speed is known less well: a factor of 2.2.
bool is_uneven(const Eigen::ArrayXd& squares, const Eigen::ArrayXd& variance, const Eigen::ArrayXd& along,
               bool uniform, bool small) {
  constexpr Eigen::Index parts = 12, fewest = 40;
  const Eigen::Index n = squares.size();
  if (n < parts * fewest) return false;
  const std::vector<Eigen::Index> order = ascending_rows(along);
  double least = 1e300, most = 0;
  for (Eigen::Index i = 0; i < parts; ++i) {
    double observed = 0, expected = 0;
    for (Eigen::Index k = i * n / parts; k < (i + 1) * n / parts; ++k) {
      observed += squares[order[static_cast<std::size_t>(k)]];
      expected += variance[order[static_cast<std::size_t>(k)]];
    }
    least = std::min(least, observed / expected);
    most = std::max(most, observed / expected);
  }
  // At rest quantization errors are one number, of up to half a count: of a small scatter only its excess
  // tells.
  if (small) return most > 1.5 && most > 4 * least;
  constexpr double of_speed = 2.2;
  const double of_chance = 1 + 12 / std::sqrt(static_cast<double>(n / parts));
  return most > (uniform ? std::min(of_chance, of_speed) : of_speed) * least;
}

struct ScatterCandidate {
  Effect effect;
  double value = 0;  ///< log-likelihood
  double relative_error = 0;
  Eigen::ArrayXd added = {};  ///< variance that it adds to every row
};

/// Half-width of the 95 % interval of a positive parameter relative to its estimate, from the curvature of
/// the log-likelihood in the parameter's logarithm at the maximum, and the calibration of all intervals.
template <typename Function>
double relative_error(Function function, double best, double at_best) {
  constexpr double step = 0.05;
  const double curvature =
      (2 * at_best - function(best * std::exp(step)) - function(best * std::exp(-step))) / (step * step);
  return curvature > 0 ? std::min(1.0, interval_calibration * 1.96 / std::sqrt(curvature)) : 1;
}

/// Random effects that could scatter the readings of a fitted model, each at its most likely size.
class Trials {
 public:
  /// @param size  of the scatter in excess of the known one [rad or m]
  Trials(const Evidence& e, const Explanation& m, Intervals intervals, double size)
      : e_(e),
        intervals_(std::move(intervals)),
        path_(m.addition()),
        size_(size),
        range_(2 * (e.measured - e.reference).abs().maxCoeff() + e.step()) {}

  double value(const Eigen::ArrayXd& variance) const {
    return interval_likelihood(intervals_, path_, variance.sqrt(), outlier_part, range_).log_likelihood;
  }

  /// In descending order of likelihood.
  /// @param known  variance of every row without them
  std::vector<ScatterCandidate> candidates(const Eigen::ArrayXd& known,
                                           const std::vector<ScatterCause>& present) const {
    std::vector<ScatterCandidate> found;
    for (const EffectKind& kind : effect_kinds()) {
      if (!kind.random() || (kind.scattering->possible && !kind.scattering->possible(e_))) continue;
      if (std::none_of(present.begin(), present.end(),
                       [&](const ScatterCause& c) { return c.effect.type == kind.name; }))
        found.push_back(candidate(kind, known));
    }
    std::sort(found.begin(), found.end(),
              [](const ScatterCandidate& a, const ScatterCandidate& b) { return a.value > b.value; });
    return found;
  }

  /// Fits the sizes of several causes together, one at a time until none changes.
  void refine(const Eigen::ArrayXd& own, std::vector<ScatterCause>& causes) const {
    constexpr int rounds = 4;
    for (int round = 0; round < rounds; ++round)
      for (ScatterCause& c : causes) {
        Eigen::ArrayXd others = own;
        for (const ScatterCause& other : causes)
          if (&other != &c) others += added(other.effect);
        const ScatterCandidate better = candidate(effect_kind(c.effect.type), others);
        c.effect = better.effect, c.relative_error = better.relative_error;
        c.rms = std::sqrt(better.added.mean());
      }
  }

  Eigen::ArrayXd added(const Effect& effect) const {
    const Scattering& s = *effect_kind(effect.type).scattering;
    return (effect.number(std::string(s.parameter)) * s.deviation(e_)).square();
  }

 private:
  ScatterCandidate candidate(const EffectKind& kind, const Eigen::ArrayXd& known) const {
    const Eigen::ArrayXd deviation = kind.scattering->deviation(e_);
    const auto with = [&](double x) { return value(known + (x * deviation).square()); };
    // A uniform scatter has the size of the residual's; any other may be concentrated in few rows.
    const double typical = rms(deviation), factor = kind.scattering->uniform ? 3 : 10;
    const double low = kind.scattering->uniform ? 0.1 : 0.1;
    const auto [size, best] = largest(with, low * size_ / typical, factor * size_ / typical);
    return {{std::string(kind.name), e_.joint, {{std::string(kind.scattering->parameter), size}}, {}},
            best,
            relative_error(with, size, best),
            (size * deviation).square()};
  }

  const Evidence& e_;
  Intervals intervals_;
  Eigen::ArrayXd path_;
  double size_, range_;
};

/// The effect of the catalogue that displaces every second edge; empty if the encoder has none.
std::optional<ScatterCause> displaced_edges(const Evidence& e, const EdgePattern& p) {
  for (const EffectKind& kind : effect_kinds()) {
    if (!kind.scattering || kind.random() || (kind.scattering->possible && !kind.scattering->possible(e)))
      continue;
    const double size = kind.scattering->of_displacement(p.alternating * e.step(), e.encoder);
    // 32 blocks: Student's t with 31 degrees of freedom.
    const double error = student_t_quantile(0.975, 31) * p.alternating_error / std::abs(p.alternating);
    return ScatterCause{
        {std::string(kind.name), e.joint, {{std::string(kind.scattering->parameter), size}}, {}},
        p.p_value,
        error,
        0.5 * std::abs(p.alternating) * e.step(),
        {}};
  }
  return std::nullopt;
}

/// Noise that the recorded effort carries into a model's addition [rad or m]: the effort's white part, by
/// differences of third order, which no motion has, times what the addition changes with it. Medians and a
/// limit of four deviations leave out what friction does at reversals.
double noise_of_effort(const Evidence& e, const Explanation& m) {
  if (e.effort.size() != e.rows() || !e.ordered || e.rows() < fewest_rows) return 0;
  const auto differences = [&](const Eigen::ArrayXd& x) -> Eigen::ArrayXd {
    const Eigen::Index n = x.size() - 3;
    return x.tail(n) - 3 * x.segment(2, n) + 3 * x.segment(1, n) - x.head(n);
  };
  const Eigen::ArrayXd of_effort = differences(e.effort), of_model = differences(m.addition());
  const Eigen::ArrayXd sizes = of_effort.abs();
  // The median of a normal variable's magnitude is 0.6745 deviations; 1, 3, 3, 1 add up to 20 in squares.
  const double deviation = median({sizes.begin(), sizes.end()}) / 0.6745;
  const Eigen::ArrayXd used = (sizes < 4 * deviation).cast<double>();
  const double squares = (used * of_effort.square()).sum();
  if (!(squares > 0)) return 0;
  return std::abs((used * of_effort * of_model).sum()) / squares * deviation / std::sqrt(20.0);
}

}  // namespace

Scatter scatter_of(const Evidence& e, const Explanation& m, double unnamed) {
  Scatter s;
  const double own = std::hypot(std::max(e.path_noise, 1e-3 * e.step()), noise_of_effort(e, m));
  const Eigen::ArrayXd known = (own * m.scatter() / m.noise()).square();
  s.expected = known + e.step() * e.step() / 12;
  s.size = std::sqrt(std::max(0.0, m.noise() * m.noise() - own * own));
  Intervals intervals = m.intervals();
  s.pattern = edge_pattern(e, m);
  if (s.pattern.p_value < significant && s.pattern.largest() > displacement_worth_naming)
    if (auto cause = displaced_edges(e, s.pattern)) {
      s.expected += cause->rms * cause->rms;
      intervals = displaced(e, m, s.pattern);
      if (std::abs(s.pattern.alternating) > displacement_worth_naming) s.causes.push_back(std::move(*cause));
    }
  const bool white = !e.ordered || lag_one_correlation(m.likelihood().score) < correlated_residual;
  // Of single poses the reference's own noise is not known: less than rounding scatters says nothing of the
  // encoder.
  const double least = (e.ordered ? scatter_worth_naming : 1 / std::sqrt(12.0)) * e.step();
  if (m.noise() < scatter_beyond_reference * own || s.size < least || s.size < unnamed || !white) return s;
  // A pose is repeated by most rows: what scatters every row has a mean difference of neighbours, 2
  // sigma/sqrt pi, of less than half a count.
  if (e.repeated && s.size > 0.25 * std::sqrt(std::numbers::pi) * e.step()) return s;
  const Trials trials(e, m, std::move(intervals), s.size);
  std::vector<ScatterCause> random;
  Eigen::ArrayXd variance = inflated_noise * known;
  for (double before = trials.value(variance);;) {  // until each random effect of the catalogue has its turn
    const std::vector<ScatterCandidate> found = trials.candidates(variance, random);
    if (found.empty()) break;
    const ScatterCandidate& best = found.front();
    const double p = best.value > before ? chi_squared_tail(2 * (best.value - before), 1) : 1;
    const double size = std::sqrt(best.added.mean());
    if (p * static_cast<double>(found.size()) > significant || size < scatter_worth_naming * e.step()) break;
    ScatterCause cause{best.effect, p, best.relative_error, size, {}};
    for (const ScatterCandidate& other : found)
      if (random.empty() && other.effect.type != best.effect.type &&
          best.value - other.value < indistinguishable)
        cause.alternative = other.effect;
    if (random.empty()) variance = known;
    variance += best.added;
    random.push_back(std::move(cause));
    before = trials.value(variance);
  }
  if (random.size() > 1) trials.refine(known, random);
  Eigen::ArrayXd expected = s.expected;
  for (const ScatterCause& cause : random) expected += trials.added(cause.effect);
  const Eigen::ArrayXd squares = (e.measured - e.path - m.addition() - mean_error(e.encoder)).square();
  const bool small = s.size <= 0.4 * e.step();
  const bool uniform = std::all_of(random.begin(), random.end(), [](const ScatterCause& c) {
    return effect_kind(c.effect.type).scattering->uniform;
  });
  if (is_uneven(squares, expected, e.path, uniform, small) ||
      (e.ordered && is_uneven(squares, expected, e.time, uniform, small)))
    return s;
  for (ScatterCause& cause : random) {
    s.expected += trials.added(cause.effect);
    s.causes.push_back(std::move(cause));
  }
  return s;
}

}  // namespace qerr
