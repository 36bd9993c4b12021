#include "report/analysis/ellipsoids.hpp"

#include <algorithm>
#include <array>

#include "core/text.hpp"
#include "report/analysis/tables.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

using Three = std::array<Coordinate, 3>;

/// Indices of three coordinates in the model; empty if one is missing.
std::optional<std::array<Eigen::Index, 3>> find_three(const OperationalModel& model, const Three& wanted) {
  std::array<Eigen::Index, 3> at{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto found = std::find(model.coordinates.begin(), model.coordinates.end(), wanted[i]);
    if (found == model.coordinates.end()) return std::nullopt;
    at[i] = found - model.coordinates.begin();
  }
  return at;
}

Eigen::Matrix3d block(const Eigen::MatrixXd& covariance, const std::array<Eigen::Index, 3>& at) {
  Eigen::Matrix3d three;
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t c = 0; c < 3; ++c)
      three(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c)) = covariance(at[r], at[c]);
  return three;
}

}  // namespace

std::vector<TipEllipsoids> tip_ellipsoids(const Analysis& a) {
  std::vector<TipEllipsoids> all;
  if (a.workspace.covariance_at_largest.size() == 0) return all;
  const auto add = [&](std::string_view of, std::string_view unit, const Three& coordinates) {
    if (const auto at = find_three(a.spec.model, coordinates))
      all.push_back({of, unit, error_ellipsoid(block(a.workspace.mean_covariance, *at)),
                     error_ellipsoid(block(a.workspace.covariance_at_largest, *at))});
  };
  add("position", "m", {Coordinate::x, Coordinate::y, Coordinate::z});
  add("rotation", "rad", {Coordinate::rx, Coordinate::ry, Coordinate::rz});
  return all;
}

std::string ellipsoid_tables(const Analysis& a, const Style& style) {
  const std::string axes = a.spec.model.frame == CoordinateFrame::tip ? "the tip" : "the base";
  std::string out;
  for (const TipEllipsoids& tip : tip_ellipsoids(a)) {
    std::vector<std::vector<std::string>> rows{{"semi-axis", "sigma", "x", "y", "z"}};
    const auto add = [&](const std::string& where, const ErrorEllipsoid& e) {
      for (Eigen::Index i = 0; i < 3; ++i) {
        rows.push_back(
            {where + ' ' + std::to_string(i + 1), readable(e.semi_axes[i], std::string(tip.unit))});
        for (Eigen::Index c = 0; c < 3; ++c) rows.back().push_back(fixed_point(e.directions(c, i), 3));
      }
    };
    add("mean", tip.mean);
    add("largest", tip.at_largest);
    out += heading(
               "Ellipsoid of one sigma of the " + std::string(tip.of) + ", directions in the axes of " + axes,
               style) +
           fitted_table(rows, style.width);
  }
  if (!out.empty())
    out += wrapped(
        "mean: root mean square over the configurations; largest: where that of the position is largest",
        style.width, "  ");
  return out;
}

}  // namespace qerr
