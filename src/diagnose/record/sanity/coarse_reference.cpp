#include <algorithm>
#include <cmath>
#include <string>

#include "core/text.hpp"
#include "diagnose/record/sanity/sanity_steps.hpp"
#include "diagnose/record/smooth_path.hpp"

/// References that are coarser or noisier than the encoder that they judge.
namespace qerr::sanity {

namespace {

/// Changes of up to `most_steps` steps show a grid. Values without a grid lie within `grid_tolerance` of a
/// whole number of steps in one of five cases, so that 32 changes of two steps and more are never chance.
constexpr double most_steps = 8, grid_tolerance = 0.1;
constexpr Eigen::Index fewest_changes = 32;

/// Step of a column whose values are on a grid coarser than `least`; else 0.
double grid_of(const Eigen::ArrayXd& x, double least) {
  double step = 1e300;
  for (Eigen::Index k = 1; k < x.size(); ++k)
    if (const double by = std::abs(x[k] - x[k - 1]); by > 0) step = std::min(step, by);
  if (step < least || step == 1e300) return 0;
  Eigen::Index single = 0, several = 0, none = 0;
  double sum = 0;
  for (Eigen::Index k = 1; k < x.size(); ++k) {
    const double steps = std::abs(x[k] - x[k - 1]) / step;
    none += steps == 0;
    if (steps == 0 || steps > most_steps) continue;
    if (std::abs(steps - std::round(steps)) > grid_tolerance) return 0;
    ++(steps < 1.5 ? single : several);
    if (steps < 1.5) sum += steps * step;
  }
  // At constant speed, and in a table at even steps, all changes are alike without a grid; but no value is
  // repeated.
  if (none < fewest_changes || std::max(single, several) < fewest_changes) return 0;
  return sum / static_cast<double>(single);
}

const char* unit_of_joint(const Sanity& s, std::size_t joint) {
  return s.model.chain.independent[joint].prismatic() ? "m" : "rad";
}

}  // namespace

void check_reference_grid(Sanity& s, std::size_t encoder) {
  const Eigen::ArrayXd reference = encoder_reference(s, encoder);
  if (reference.size() < 2 || !recorded_counts(s, encoder)) return;
  const double step = s.model.transmission.encoders[encoder].resolution;
  const double grid = grid_of(reference, step);
  if (grid == 0) return;
  s.reference_grid[encoder] = grid;
  s.data.push_back({"the reference changes in steps of " + readable(grid, unit_of_joint(s, encoder)) + " = " +
                        significant(grid / step, 3) + " counts: it is coarser than the encoder",
                    s.model.chain.independent[encoder].name,
                    1,
                    {},
                    "with it only errors of more than " + significant(grid / step, 2) +
                        " counts can be judged, no noise and no quantization: use a finer sensor, or write "
                        "more decimals"});
}

void check_reference_noise(Sanity& s, std::size_t encoder) {
  const Eigen::ArrayXd reference = encoder_reference(s, encoder);
  const auto read = recorded_counts(s, encoder);
  const auto stamps = s.log.find(LogSignal::time);
  const Encoder& model = s.model.transmission.encoders[encoder];
  if (!stamps || !read || reference.size() < 64 || s.reference_grid[encoder] > 0 ||
      is_static(reference, model.resolution))
    return;
  const Eigen::ArrayXd time = s.log.values.col(*stamps);
  const double of_reference = noise_of_path(time, reference, 0);
  // Where the reference's variance exceeds that of the quantization, most of the residual is not the
  // encoder's.
  if (of_reference < sigma(model)) return;
  // Motion that is too fast for the rows looks like noise, but the encoder follows it.
  const double noise =
      std::min(of_reference, noise_of_path(time, read->counts * model.resolution - reference, 0));
  if (noise < sigma(model)) return;
  // The amplitude of a periodic error has the standard error sigma sqrt(2/n); four of them are no chance.
  const double counts = noise / model.resolution,
               visible = 4 * counts * std::sqrt(2 / static_cast<double>(reference.size()));
  s.data.push_back({"the reference has noise of " + readable(noise, unit_of_joint(s, encoder)) + " = " +
                        significant(counts, 2) +
                        " counts (standard deviation): it is coarser than the encoder",
                    s.model.chain.independent[encoder].name,
                    1,
                    {},
                    "with it only errors that repeat can be judged, from about " + significant(visible, 1) +
                        " counts on in the mean of all rows, and no noise of the encoder: use a better "
                        "sensor, or move more slowly"});
}

}  // namespace qerr::sanity
