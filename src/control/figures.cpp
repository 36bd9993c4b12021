#include "control/figures.hpp"

#include "control/loop_response.hpp"

namespace qerr {

std::vector<ControlFigure> control_figures(const Control& control, const Chain& chain) {
  using Kind = ControlFigure::Kind;
  std::vector<ControlFigure> all;
  for (std::size_t j = 0; j < control.joints.size(); ++j) {
    if (!has_loop(control, chain, j)) continue;
    const std::string loop = "loop." + chain.independent[j].name + '.';
    all.push_back({loop + "gain_margin", Kind::gain_margin, j, dimension::none});
    all.push_back({loop + "phase_margin", Kind::phase_margin, j, dimension::angle});
    all.push_back({loop + "bandwidth", Kind::bandwidth, j, dimension::frequency});
    all.push_back({loop + "limit_cycle", Kind::limit_cycle, j,
                   chain.independent[j].prismatic() ? dimension::length : dimension::angle});
  }
  for (std::size_t j = 0; j < control.joints.size(); ++j)
    if (control.joints[j].kd > 0)
      all.push_back({"control." + chain.independent[j].name + ".kd_max", Kind::largest_kd, j,
                     chain.independent[j].prismatic() ? Dimension{-1, 0, 1, 1} : Dimension{1, -1, 1, 1}});
  for (std::size_t w = 0; w < control.walls.size(); ++w)
    all.push_back({"wall." + control.walls[w].name + ".stiffness", Kind::wall_stiffness, w, {-1, 0, 0, 1}});
  return all;
}

}  // namespace qerr
