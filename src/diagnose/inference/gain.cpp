#include "diagnose/inference/gain.hpp"

#include <algorithm>
#include <cmath>

#include "core/random.hpp"
#include "core/statistics.hpp"
#include "diagnose/record/sampling.hpp"

namespace qerr {

namespace {

constexpr std::size_t fewest_blocks = 4;
constexpr std::uint64_t draws = 999;

/// Prediction of a fitted model for some rows.
struct Prediction {
  Eigen::ArrayXd before, after;  ///< what is added to the reference, without terms and with them
  double noise_before = 0, noise_after = 0;
};

/// What a model adds that none of its terms does: the constant of an encoder whose zero is free.
double constant_of(const Explanation& m) {
  double first = m.addition()[0];
  for (std::size_t i = 0; i < m.terms().size(); ++i) first -= addition(m.terms()[i], m.coefficients(i))[0];
  return first;
}

/// The term over all rows, at the coefficients that a part of them led to.
Term anew(const Evidence& e, const Term& fitted, const Term& whole, const Eigen::VectorXd& coefficients) {
  return fitted.relinearized ? fitted.relinearized(e, whole, coefficients) : whole;
}

Prediction predict(const Evidence& e, const std::vector<Term>& terms, const std::vector<Eigen::Index>& known,
                   const std::vector<Eigen::Index>& asked) {
  const Evidence part = rows_of(e, known);
  Explanation fitted(part);
  Prediction p;
  p.before = Eigen::ArrayXd::Constant(static_cast<Eigen::Index>(asked.size()), constant_of(fitted));
  p.noise_before = p.noise_after = fitted.noise();
  p.after = p.before;
  if (terms.empty()) return p;
  for (const Term& t : terms) fitted.add(rows_of(t, known));
  fitted.fit();
  p.after.setConstant(constant_of(fitted));
  for (std::size_t i = 0; i < terms.size(); ++i)
    p.after += addition(rows_of(anew(e, fitted.terms()[i], terms[i], fitted.coefficients(i)), asked),
                        fitted.coefficients(i));
  p.noise_after = fitted.noise();
  return p;
}

/// Expected square of reading - position, in counts: the encoder rounds position + noise.
/// @param position, noise  in counts
double expected_square(const Encoder& encoder, double position, double noise) {
  if (noise > 1) return 1.0 / 12 + noise * noise + (encoder.rounding == Rounding::down ? 0.25 : 0);
  const double below = below_reading(encoder);
  const double first = std::floor(position + below - 6 * noise);
  double sum = 0;
  // Twelve standard deviations of at most a count each; beyond 2^53 the next count is none of its own.
  for (int i = 0; i <= 13 && first + i <= position + below + 6 * noise; ++i) {
    const double count = first + i;
    const double edge = count - below - position;
    sum +=
        (count - position) * (count - position) * (normal_cdf((edge + 1) / noise) - normal_cdf(edge / noise));
  }
  return sum;
}

/// Fraction of the interval [low, high] of a reading's distribution function within the central 95 %: the
/// randomized probability integral transform, by which the right model covers 95 % also of certain counts.
double part_inside(double low, double high) {
  return high > low ? std::max(0.0, std::min(high, 0.975) - std::max(low, 0.025)) / (high - low)
                    : static_cast<double>(low > 0.025 && low < 0.975);
}

void judge(const Evidence& e, const std::vector<Eigen::Index>& rows, const Prediction& p, HeldOut& h) {
  const double under = below_reading(e.encoder);
  const Evidence part = rows_of(e, rows);
  const Eigen::ArrayXd lower = part.measured - under * e.step() - part.path;
  const Intervals edges{lower, lower + e.step()};
  const auto log_likelihood = [&](const Eigen::ArrayXd& added, double noise) {
    const double spread = 2 * (part.measured - part.path).abs().maxCoeff() + e.step();
    return interval_likelihood(edges, added, Eigen::ArrayXd::Constant(1, noise), outlier_part, spread)
        .log_likelihood;
  };
  h.log_score += log_likelihood(p.after, p.noise_after) - log_likelihood(p.before, p.noise_before);
  for (Eigen::Index k = 0; k < part.rows(); ++k) {
    const double x = part.path[k] + p.after[k], noise = p.noise_after;
    const double residual = (part.measured[k] - x) / e.step();
    h.residual += residual * residual;
    h.inside += part_inside(normal_cdf((edges.lower[k] - p.after[k]) / noise),
                            normal_cdf((edges.upper[k] - p.after[k]) / noise));
  }
  h.readings += static_cast<double>(part.rows());
}

std::vector<Eigen::Index> range(Eigen::Index first, Eigen::Index end) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index k = first; k < end; ++k) rows.push_back(k);
  return rows;
}

double ratio(double before, double after) { return after > 0 ? std::sqrt(before / after) : 1; }

/// Central 95 % of the ratio when blocks are drawn with replacement, encoder by encoder.
void bootstrap(const std::vector<HeldOut>& all, std::uint64_t seed, Gain& g) {
  std::vector<double> ratios;
  for (std::uint64_t draw = 0; draw < draws; ++draw) {
    double before = 0, after = 0;
    std::uint64_t index = 0;
    const std::uint64_t of_draw = stream_seed(seed, "bootstrap", draw);
    for (const HeldOut& h : all)
      for (std::size_t i = 0; i < h.blocks.size(); ++i) {
        const double u = unit_interval(random_bits(of_draw, index++, 0));
        const HeldOut::Block& b =
            h.blocks[static_cast<std::size_t>(u * static_cast<double>(h.blocks.size()))];
        before += b.before;
        after += b.after;
      }
    ratios.push_back(ratio(before, after));
  }
  std::sort(ratios.begin(), ratios.end());
  // Widen to include the point estimate.
  g.lower = std::min(g.ratio(), ratios[static_cast<std::size_t>(0.025 * draws)]);
  g.upper = std::max(g.ratio(), ratios[static_cast<std::size_t>(0.975 * draws)]);
}

}  // namespace

double expected_squares(const Evidence& e, const Eigen::ArrayXd& added, const Eigen::ArrayXd& variance) {
  double sum = 0;
  for (Eigen::Index k = 0; k < e.rows(); ++k)
    sum += expected_square(e.encoder, e.counted ? (e.path[k] + added[k]) / e.step() : 0.5,
                           std::sqrt(variance[k]) / e.step());
  return sum;
}

HeldOut hold_out(const Evidence& record, const Evidence& sampled, const std::vector<RowGroup>& groups,
                 const std::vector<Term>& terms) {
  HeldOut h;
  h.step = record.step();
  h.prismatic = record.prismatic;
  const std::vector<Eigen::Index> blocks = block_starts(sampled);
  const auto end_of = [&](std::size_t b) { return b + 1 < blocks.size() ? blocks[b + 1] : sampled.rows(); };
  h.held_out = blocks.size() >= fewest_blocks;
  std::vector<Eigen::Index> halves[2];
  for (std::size_t b = 0; b < blocks.size(); ++b)
    for (const Eigen::Index k : range(blocks[b], end_of(b))) halves[h.held_out ? b % 2 : 0].push_back(k);
  Eigen::ArrayXd before(sampled.rows()), after(sampled.rows());
  for (int half = 0; half < (h.held_out ? 2 : 1); ++half) {
    const std::vector<Eigen::Index>& asked = halves[half];
    const Prediction p = predict(sampled, terms, halves[h.held_out ? 1 - half : 0], asked);
    before(asked) = p.before;
    after(asked) = p.after;
    judge(sampled, asked, p, h);
  }
  const Eigen::ArrayXd residual = record.measured - record.reference;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    HeldOut::Block sums;
    for (Eigen::Index k = blocks[b]; k < end_of(b); ++k) {
      const RowGroup& g = groups[static_cast<std::size_t>(k)];
      const auto rows = residual.segment(g.first, g.end - g.first);
      sums.before += (rows - before[k]).square().sum();
      sums.after += (rows - after[k]).square().sum();
      sums.rows += static_cast<double>(g.end - g.first);
    }
    h.blocks.push_back(sums);
  }
  return h;
}

Gain gain(const std::vector<HeldOut>& all, std::uint64_t seed) {
  Gain g;
  double before = 0, after = 0, rows = 0, before_counts = 0, after_counts = 0;
  double readings = 0, residual = 0, predicted = 0, log_score = 0, inside = 0;
  g.held_out = !all.empty();
  if (g.held_out && std::all_of(all.begin(), all.end(), [](const HeldOut& h) { return h.prismatic; }))
    g.unit = "m";
  for (const HeldOut& h : all) {
    for (const HeldOut::Block& b : h.blocks) {
      before += b.before, after += b.after, rows += b.rows;
      before_counts += b.before / (h.step * h.step), after_counts += b.after / (h.step * h.step);
    }
    // A joint that rests has nothing to hold out, and nothing was fitted to it.
    g.held_out &= h.held_out || h.log_score == 0;
    readings += h.readings, residual += h.residual, predicted += h.predicted;
    log_score += h.log_score, inside += h.inside;
  }
  if (rows == 0) return g;
  g.rms_before = std::sqrt(before / rows), g.rms_after = std::sqrt(after / rows);
  g.counts_before = std::sqrt(before_counts / rows), g.counts_after = std::sqrt(after_counts / rows);
  g.sigma_ratio = predicted > 0 ? std::sqrt(residual / predicted) : 1;
  g.log_score = log_score / readings, g.coverage = inside / readings;
  bootstrap(all, seed, g);
  return g;
}

}  // namespace qerr
