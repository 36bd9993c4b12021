#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "core/text.hpp"
#include "diagnose/record/sanity/sanity_steps.hpp"

/// Positions on a grid that is coarser than the encoder, and sensors that do not move.
namespace qerr::sanity {

namespace {

constexpr double still_moves = 20;  // [counts] that a sensor must have missed before it is called stuck

/// Whether the spec has a rounding to this grid.
bool is_known(const Sanity& s, std::size_t joint, double step) {
  const Effect* effect = known(s, joint, "log_rounding");
  return effect && std::abs(effect->number("step") - step) < 1e-6 * step;
}

/// The file's rounding is one of the error's parts, and stays where the counts are not known. It is named
/// when it is more than a hundredth of the residual's variance.
void name_rounding(Sanity& s, std::size_t joint, double step) {
  if (is_known(s, joint, step)) return;
  const auto column = s.log.find(LogSignal::reference, joint);
  const auto measured = measured_joint(s.log, s.log.values, s.model.transmission, joint);
  double now = 0;
  if (column && measured) {
    const Eigen::ArrayXd residual = *measured - s.log.values.col(*column);
    if (step / std::sqrt(12.0) < 0.1 * standard_deviation(residual)) return;
    now = rms(residual);
  }
  s.causes.push_back(cause(s, joint, "log_rounding", {{"step", step}}, 1e-300, now, now));
}

/// Counts of which most never occur: a counter with fewer edges than the spec says, brought to its counts.
void check_counts(Sanity& s, Readings& read, std::size_t encoder) {
  std::int64_t every = 0;
  for (const double c : read.counts) every = std::gcd(every, std::llround(c - read.counts[0]));
  if (every < 2 || peak_to_peak(read.counts) < 32 * static_cast<double>(every)) return;
  name_rounding(s, encoder, s.model.transmission.encoders[encoder].resolution * static_cast<double>(every));
  read.counts /= static_cast<double>(every);
  decode(s, read, encoder, 1 / static_cast<double>(every));
}

/// Measured positions with too few decimals. Where these still tell the counts apart, they are restored.
void check_measured(Sanity& s, Readings& read, std::size_t encoder) {
  Encoder& model = s.model.transmission.encoders[encoder];
  const double grid = s.log.columns[static_cast<std::size_t>(read.column)].step() / model.resolution;
  const Eigen::ArrayXd counts = (read.counts + 0.5).floor();
  const Eigen::ArrayXd off = read.counts - counts;
  const bool on_counts = off.abs().maxCoeff() <= 0.5 * grid + 1e-6;
  if (grid >= 1) {
    // Of about one count the grid may be the encoder itself.
    if (grid < 1.01 || peak_to_peak(read.counts) < 32 * grid) return;
    name_rounding(s, encoder, grid * model.resolution);
    const Eigen::ArrayXd lowest = (read.counts - 0.5 * grid).ceil();
    const Eigen::ArrayXd highest = (read.counts + 0.5 * grid).floor();
    // With an odd number of counts in every step all have as many; halves are rounded up or down by chance.
    s.rounding_sigma[encoder] = std::abs(std::remainder(grid, 2)) < 1e-3
                                    ? sigma(model)
                                    : 0.5 * rms(highest + 1 - lowest - grid) * model.resolution;
    if (model.zero_known)
      read.counts = 0.5 * (lowest + highest) + (model.rounding == Rounding::down ? 0.5 - 0.5 * grid : 0.0);
    read.counts /= grid;
    model.resolution *= grid;
    write_back(s, read, encoder);
  } else if (on_counts && grid < 0.95 && rms(off) > 0.04) {
    const double step = grid * model.resolution, before = rms(read.counts - counts) * model.resolution;
    if (!is_known(s, encoder, step))
      s.causes.push_back(cause(s, encoder, "log_rounding", {{"step", step}}, 1e-300, before, 0));
    read.counts = counts;
    write_back(s, read, encoder);
  } else if (grid >= 0.5 && rms(off) > 0.04 && peak_to_peak(read.counts) > 32) {
    name_rounding(s, encoder, grid * model.resolution);
  }
}

/// The step of a reference's values, where it rests on them while the counts go on; else 0.
double coarseness(const Eigen::ArrayXd& reference, const Eigen::ArrayXd& counts) {
  Eigen::Index rests = 0, moves = 0;
  double least = 1e300;
  for (Eigen::Index k = 1; k < counts.size(); ++k) {
    if (counts[k] == counts[k - 1]) continue;
    const double step = std::abs(reference[k] - reference[k - 1]);
    if (step == 0)
      ++rests;
    else
      ++moves, least = std::min(least, step);
  }
  return rests > 32 && rests > moves / 4 && moves > 8 ? least : 0;
}

void check_reference(Sanity& s, const Readings& read, std::size_t encoder) {
  const auto column = s.log.find(LogSignal::reference, encoder);
  if (!column || !s.log.has_time()) return;
  const LogColumn& reference = s.log.columns[static_cast<std::size_t>(*column)];
  const double resolution = s.model.transmission.encoders[encoder].resolution;
  const double of_file = reference.step();
  const double found = coarseness(s.log.values.col(*column), read.counts);
  if (std::max(found, of_file) < 0.5 * resolution || peak_to_peak(s.log.values.col(*column)) < 8 * of_file)
    return;
  const bool written = of_file > 0.5 * found;
  s.warnings.push_back(
      reference.header + ": its values are " + significant(std::max(found, of_file), 4) + ' ' +
      reference.unit + " apart, a count of the encoder is " + significant(resolution, 4) +
      (written ? ": write more decimals" : ": a reference must be finer than what it judges"));
  if (written && of_file > resolution) name_rounding(s, encoder, of_file);
}

}  // namespace

void check_dead(Sanity& s, std::size_t encoder) {
  const auto read = readings(s, encoder);
  const auto column = s.log.find(LogSignal::reference, encoder);
  if (!read) return;
  const double resolution = s.model.transmission.encoders[encoder].resolution;
  const IndependentJoint& joint = s.model.chain.independent[encoder];
  if (column && peak_to_peak(s.log.values.col(*column)) == 0 && peak_to_peak(read->counts) >= still_moves) {
    s.warnings.push_back(s.log.columns[static_cast<std::size_t>(*column)].header +
                         ": never changes, while the encoder moves by " +
                         significant(peak_to_peak(read->counts), 4) + " counts: it is not used");
    drop_column(s.log, *column);
    return;
  }
  const Eigen::ArrayXd reference = encoder_reference(s, encoder);
  if (reference.size() == 0 || peak_to_peak(read->counts) > 0 ||
      peak_to_peak(reference) < still_moves * resolution)
    return;
  s.unexplained.push_back(
      {joint.name, "the encoder stands still while its reference moves", {}, {}, peak_to_peak(reference)});
  s.warnings.push_back(s.log.columns[static_cast<std::size_t>(read->column)].header +
                       ": never changes: the joint is not judged");
  drop_column(s.log, read->column);
}

void check_grids(Sanity& s, std::size_t encoder) {
  auto read = readings(s, encoder);
  if (!read) {  // a joint of several encoders: their counts cannot be told from its position
    const auto measured = s.log.find(LogSignal::measured, encoder);
    if (!measured) return;
    const double grid = s.log.columns[static_cast<std::size_t>(*measured)].step();
    if (grid / std::sqrt(12.0) > ideal_sigma(s, encoder) &&
        peak_to_peak(s.log.values.col(*measured)) > 32 * grid)
      name_rounding(s, encoder, grid);
    return;
  }
  // A counter that was decoded wrongly has been brought to its own counts already.
  const std::string& joint = s.model.chain.independent[encoder].name;
  const bool decoded = std::any_of(s.causes.begin(), s.causes.end(), [&](const Cause& c) {
    return c.effect.type == "decoding" && c.effect.joint == joint;
  });
  if (!decoded && read->whole) check_counts(s, *read, encoder);
  if (!decoded && !read->whole) check_measured(s, *read, encoder);
  check_reference(s, *readings(s, encoder), encoder);
}

/// A stuck sensor catches up with a jump when it wakes; behind a gap, or when counts were lost, it does not.
void check_stuck(Sanity& s, std::size_t encoder) {
  const auto read = readings(s, encoder);
  if (!read || !s.log.has_time()) return;
  const Eigen::ArrayXd reference =
      encoder_reference(s, encoder) / s.model.transmission.encoders[encoder].resolution;
  if (reference.size() == 0) return;
  const Eigen::ArrayXd& counts = read->counts;
  const Eigen::Index n = counts.size();
  std::vector<Eigen::Index> kept;
  double missed = 0, since = 0;
  for (Eigen::Index first = 0; first < n;) {
    Eigen::Index end = first + 1;
    while (end < n && counts[end] == counts[first]) ++end;
    const double moved = reference[std::min(end, n - 1)] - reference[first];
    const double woke = end < n ? counts[end] - counts[first] : moved;
    // What moves after the last still row may be a gap in the record.
    const double meanwhile = std::abs(reference[end - 1] - reference[first]);
    const bool stuck = end - first >= 5 && meanwhile >= 0.5 * still_moves && std::abs(moved) >= still_moves &&
                       woke * moved > 0 && std::abs(woke - moved) < 0.2 * std::abs(moved) + 2 &&
                       (end < n || first == 0 || end - first > n / 100);
    if (stuck && std::abs(moved) > missed)
      missed = std::abs(moved), since = s.log.values(first, *s.log.find(LogSignal::time));
    for (Eigen::Index k = first; k < (stuck ? first + 1 : end); ++k) kept.push_back(k);
    first = end;
  }
  if (missed == 0) return;
  const double resolution = s.model.transmission.encoders[encoder].resolution;
  s.unexplained.push_back({s.model.chain.independent[encoder].name,
                           "the encoder stands still for a while and catches up with a jump",
                           {},
                           {},
                           missed * resolution});
  s.warnings.push_back(
      s.log.columns[static_cast<std::size_t>(read->column)].header + ": stands still from " +
      significant(since, 4) + " s on while its reference moves by " + significant(missed, 4) +
      " counts: " + std::to_string(n - static_cast<Eigen::Index>(kept.size())) + " rows are left out");
  s.log.values = s.log.values(kept, Eigen::all).eval();
  s.log.rows = kept.size();
  s.log.stretches.clear();
}

}  // namespace qerr::sanity
