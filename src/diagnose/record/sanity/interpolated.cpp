#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/text.hpp"
#include "diagnose/record/sanity/sanity_steps.hpp"

/// Tables that have been filled by interpolation: they have more rows than readings.
namespace qerr::sanity {

namespace {

/// Knots that a judgement needs, and their least distance in the mean [rows]. Between knots a measured path
/// would be straight to the last decimal by chance only.
constexpr std::size_t fewest_knots = 16;
constexpr double least_distance = 4;

/// Rows at which a piecewise linear column bends. Empty: it is not piecewise linear.
/// @param rounding  of the values by the file: four halves of it bend a straight line
std::vector<Eigen::Index> knots_of(const Eigen::ArrayXd& x, double rounding) {
  const double exact = 16 * std::numeric_limits<double>::epsilon() * x.abs().maxCoeff();
  const double straight = 2.01 * rounding + exact;
  std::vector<Eigen::Index> knots;
  Eigen::Index reversals = 0, rests = 0, last = -2;
  for (Eigen::Index k = 1; k + 1 < x.size(); ++k) {
    const double before = x[k] - x[k - 1], after = x[k + 1] - x[k];
    if (std::abs(after - before) <= straight) continue;
    reversals += before * after < 0;
    rests += before == 0 || after == 0;
    // A knot between two rows bends the path in both of them.
    const bool same = k == last + 1;
    last = k;
    if (same && k > knots.back() + 1) return {};  // a curve
    if (same) continue;
    knots.push_back(k);
    if (static_cast<double>(knots.size()) * least_distance > static_cast<double>(x.size())) return {};
  }
  // A straight path that turns back is a motion at constant speed; one that rests is a held value.
  if (knots.size() < fewest_knots || 2 * (reversals + rests) > static_cast<Eigen::Index>(knots.size()))
    return {};
  return knots;
}

}  // namespace

void check_interpolated(Sanity& s, std::size_t encoder) {
  const auto column = s.log.find(LogSignal::reference, encoder);
  const auto read = recorded_counts(s, encoder);
  // Values on a coarse grid are straight without interpolation.
  if (!column || !read || s.reference_grid[encoder] > 0) return;
  const double rounding = s.log.columns[static_cast<std::size_t>(*column)].step();
  if (rounding > s.model.transmission.encoders[encoder].resolution) return;
  const std::vector<Eigen::Index> knots = knots_of(s.log.values.col(*column), rounding);
  if (knots.empty()) return;
  const std::size_t readings = knots.size() + 2;
  s.data.push_back({"the reference is interpolated between about " + std::to_string(readings) +
                        " readings: the " + std::to_string(s.log.values.rows()) + " rows are not independent",
                    s.model.chain.independent[encoder].name, s.log.row_number(knots.front()) + 1,
                    time_of(s, knots.front()),
                    "record the readings themselves; between them nothing can be judged, and orders above " +
                        std::to_string(readings / 2) + " per record cannot be told from lower ones"});
}

}  // namespace qerr::sanity
