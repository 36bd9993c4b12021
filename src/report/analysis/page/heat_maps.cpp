#include <algorithm>
#include <array>
#include <cmath>

#include "core/text.hpp"
#include "qerr/kinematics/coordinates.hpp"
#include "report/analysis/page/pictures.hpp"
#include "report/page/heat_map.hpp"
#include "report/page/page.hpp"

namespace qerr {

namespace {

constexpr std::array<const char*, 3> axis_names{"x", "y", "z"};

/// The axes of the base frame that span the picture: x and z, or those of a workspace that is flat.
std::array<Eigen::Index, 2> plane_of(const Eigen::Vector3d& extent) {
  constexpr double flat = 0.5;  // of the next smaller extent: a side view of it would be a strip
  Eigen::Index least = 0;
  extent.minCoeff(&least);
  const Eigen::Index a = (least + 1) % 3, b = (least + 2) % 3;
  if (extent[least] > flat * std::min(extent[a], extent[b])) return {0, 2};
  return {std::min(a, b), std::max(a, b)};
}

struct TipGrid {
  std::array<Eigen::Index, 2> axes;
  std::array<std::pair<double, double>, 2> span;
  std::array<std::size_t, 2> cells;
  std::vector<std::size_t> cell_of;  ///< [configuration]
};

/// About six configurations a cell, so that few cells inside the workspace are empty, and a hundred by a
/// hundred cells at most: a cell is then three pixels.
TipGrid tip_grid(const ConfigurationSample& sample) {
  constexpr double configurations_a_cell = 6, most_cells = 1e4;
  Eigen::Vector3d low = Eigen::Vector3d::Constant(INFINITY), high = -low;
  for (const Eigen::Vector3d& tip : sample.tips) low = low.cwiseMin(tip), high = high.cwiseMax(tip);
  TipGrid g{plane_of(high - low), {}, {}, {}};
  // A tip that moves by its rounding errors alone rests.
  const double extent = (high - low).maxCoeff(),
               distance = std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff()),
               longest = extent > 1e-9 * (1 + distance) ? extent : 1;
  const double cells =
      std::clamp(static_cast<double>(sample.tips.size()) / configurations_a_cell, 16.0, most_cells);
  for (std::size_t k = 0; k < 2; ++k) {
    const Eigen::Index axis = g.axes[k];
    // An axis on which the tip rests has a row of cells of a hundredth of the other's length.
    const double margin = std::max(0.0, 0.005 * longest - 0.5 * (high - low)[axis]);
    g.span[k] = {low[axis] - margin, high[axis] + margin};
  }
  const double width = g.span[0].second - g.span[0].first, height = g.span[1].second - g.span[1].first;
  const double side = std::sqrt(width * height / cells);
  g.cells = {static_cast<std::size_t>(std::clamp(std::ceil(width / side), 1.0, 100.0)),
             static_cast<std::size_t>(std::clamp(std::ceil(height / side), 1.0, 100.0))};
  for (const Eigen::Vector3d& tip : sample.tips) {
    std::array<std::size_t, 2> at{};
    for (std::size_t k = 0; k < 2; ++k) {
      const double part = (tip[g.axes[k]] - g.span[k].first) / (g.span[k].second - g.span[k].first);
      at[k] = std::min(static_cast<std::size_t>(part * static_cast<double>(g.cells[k])), g.cells[k] - 1);
    }
    g.cell_of.push_back(at[1] * g.cells[0] + at[0]);
  }
  return g;
}

std::string worst_case_map(const TipGrid& g, const std::vector<double>& values, const Signal& c) {
  page::HeatMap map{"Worst case of " + c.name + " over the workspace",
                    "Largest worst case among the configurations with the tip in a cell.",
                    {axis_names[static_cast<std::size_t>(g.axes[0])], "m", false, false},
                    {axis_names[static_cast<std::size_t>(g.axes[1])], "m", false, false},
                    {"worst case of " + c.name, c.unit},
                    g.span[0],
                    g.span[1],
                    g.cells[0],
                    g.cells[1],
                    std::vector<double>(g.cells[0] * g.cells[1], NAN),
                    true};
  for (std::size_t i = 0; i < values.size(); ++i) {
    double& cell = map.cells[g.cell_of[i]];
    if (!(cell >= values[i])) cell = values[i];
  }
  return figure(map);
}

}  // namespace

std::string workspace_figures(const Analysis& a, const ConfigurationSample& sample) {
  if (sample.tips.empty()) return "<p>Without a configuration there is no workspace.</p>";
  const TipGrid grid = tip_grid(sample);
  const std::vector<Signal> coordinates = all_signals(a.spec.model);
  std::vector<std::pair<std::string, std::string>> all;
  for (std::size_t c = 0; c < sample.worst.size(); ++c)
    all.emplace_back(coordinates[c].name, worst_case_map(grid, sample.worst[c], coordinates[c]));
  return "<p>By the position of the tip in the base frame, seen along the third axis: the largest worst case "
         "of the configurations in a cell, of " +
         std::to_string(sample.of) + " configurations" + sampled_note(sample) +
         ". Without colour: no configuration.</p>" + page::choice("Coordinate", all);
}

}  // namespace qerr
