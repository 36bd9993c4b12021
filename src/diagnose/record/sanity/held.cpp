#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/text.hpp"
#include "diagnose/record/encoder_columns.hpp"
#include "diagnose/record/sanity/sanity_steps.hpp"

/// Sensors that are read less often than the log has rows, and references that are coarser than the encoder.
namespace qerr::sanity {

namespace {

/// Rows in motion that a judgement needs: a share of one third from 200 rows has a standard error of 3 %.
constexpr Eigen::Index fewest_moving = 200;

struct Hold {
  double rows = 1;  ///< mean number of rows between two updates
  Eigen::Index first = 0;
};

/// How often one signal changes while the other moves by more than `enough` from row to row.
Hold hold_of(const Eigen::ArrayXd& signal, const Eigen::ArrayXd& other, double enough) {
  Hold h;
  Eigen::Index moving = 0, changed = 0;
  for (Eigen::Index k = 1; k < signal.size(); ++k) {
    if (!(std::abs(other[k] - other[k - 1]) > enough)) continue;
    ++moving;
    if (signal[k] != signal[k - 1])
      ++changed;
    else if (h.first == 0)
      h.first = k;
  }
  if (moving >= fewest_moving && changed > 0)
    h.rows = static_cast<double>(moving) / static_cast<double>(changed);
  return h;
}

/// Step of the values of a column if they all lie on a grid that is coarser than `least`; else 0. Where a
/// grid exists, neighbouring values are equal or differ by whole steps.
double grid_of(const Eigen::ArrayXd& x, double least) {
  double step = 0;
  std::vector<double> changes;
  for (Eigen::Index k = 1; k < x.size(); ++k)
    if (const double by = std::abs(x[k] - x[k - 1]); by > 0) changes.push_back(by);
  // A table may be taken at even steps: only values that repeat are on a grid of the sensor.
  const auto repeated = static_cast<double>(x.size() - 1) - static_cast<double>(changes.size());
  if (changes.size() < 8 || repeated < 0.05 * static_cast<double>(x.size())) return 0;
  step = *std::min_element(changes.begin(), changes.end());
  if (step < least) return 0;
  // Decimals of the file round the values to a thousandth of the step or better.
  const auto off = std::count_if(changes.begin(), changes.end(), [&](double by) {
    return std::abs(by / step - std::round(by / step)) > 0.01 * std::max(1.0, by / step);
  });
  return off == 0 ? step : 0;
}

/// A sensor is held from two rows between updates on.
constexpr double held_from = 1.8;

}  // namespace

void check_held(Sanity& s, std::size_t encoder) {
  const auto read = recorded_counts(s, encoder);
  const Eigen::ArrayXd reference = encoder_reference(s, encoder);
  const auto stamps = s.log.find(LogSignal::time);
  if (!read || reference.size() == 0 || !stamps || s.log.values.rows() < fewest_moving) return;
  const double step = s.model.transmission.encoders[encoder].resolution;
  const std::string& joint = s.model.chain.independent[encoder].name;
  const auto time = s.log.values.col(*stamps);
  const double interval = (time[time.size() - 1] - time[0]) / static_cast<double>(time.size() - 1);
  const auto tell = [&](const Hold& h, const std::string& what, double age) {
    const double rows = std::round(h.rows);
    s.data.push_back(
        {what + " for " + significant(rows, 3) + " rows (" + readable(rows * interval, "s") + ")", joint,
         s.log.row_number(h.first) + 1, time[h.first],
         "record every row with a fresh value, or log at the rate of the sensor; a mean age of " +
             readable(age, "s") + " is due to it"});
    s.held.push_back({joint, age, rows * interval});
  };
  // Between two rows the reference moves by more than a count and a half: the counter must change.
  const Hold counts = hold_of(read->counts, reference, 1.5 * step);
  if (counts.rows > held_from) tell(counts, "the counts are held", 0.5 * (counts.rows - 1) * interval);
  // The counter moves by two counts or more: the reference has moved by more than one.
  const Hold reference_hold = hold_of(reference, read->counts, 1.5);
  if (reference_hold.rows > held_from && counts.rows < held_from && grid_of(reference, step) == 0)
    tell(reference_hold, "the reference is held", -0.5 * (reference_hold.rows - 1) * interval);
}

void check_coarse_reference(Sanity& s, std::size_t encoder) {
  const Eigen::ArrayXd reference = encoder_reference(s, encoder);
  if (reference.size() == 0 || !recorded_counts(s, encoder)) return;
  const double step = s.model.transmission.encoders[encoder].resolution;
  const double grid = grid_of(reference, step);
  if (grid == 0) return;
  const bool prismatic = s.model.chain.independent[encoder].prismatic();
  s.reference_grid[encoder] = grid;
  s.data.push_back({"the reference changes in steps of " + readable(grid, prismatic ? "m" : "rad") + " = " +
                        significant(grid / step, 3) + " counts: it is coarser than the encoder",
                    s.model.chain.independent[encoder].name,
                    1,
                    {},
                    "with it only errors of more than " + significant(grid / step, 2) +
                        " counts can be judged, no noise and no quantization: use a finer sensor, or write "
                        "more decimals"});
}

}  // namespace qerr::sanity
