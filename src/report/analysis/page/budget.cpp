#include "qerr/kinematics/coordinates.hpp"
#include "report/analysis/page/pictures.hpp"
#include "report/page/bars.hpp"
#include "report/page/page.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

template <class Shares>
page::Bars bars_of(const Analysis& a, const std::string& title, const Shares& shares) {
  page::Bars bars{title,
                  "Share of each encoder; the shares add up to 100 % unless effects without an encoder "
                  "contribute.",
                  {}};
  const auto& joints = a.spec.model.chain.independent;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const double share = shares[static_cast<Eigen::Index>(i)];
    bars.bars.push_back({joints[i].name, share, percent(share)});
  }
  return bars;
}

}  // namespace

std::string budget_figures(const Analysis& a) {
  std::vector<std::pair<std::string, std::string>> all;
  const std::vector<double> budget = encoder_budget(a);
  const Eigen::Map<const Eigen::VectorXd> mean(budget.data(), static_cast<Eigen::Index>(budget.size()));
  all.emplace_back("tip, variance", figure(bars_of(a, "Share of the tip's mean variance", mean)));
  const std::vector<Signal> coordinates = all_signals(a.spec.model);
  for (std::size_t i = 0; i < a.workspace.coordinates.size(); ++i) {
    const CoordinateStatistics& c = a.workspace.coordinates[i];
    const std::string& name = coordinates[i].name;
    if (c.share.size() > 0)
      all.emplace_back(name + ", variance", figure(bars_of(a, "Share of the variance of " + name, c.share)));
    if (c.share_worst_case.size() > 0)
      all.emplace_back(name + ", worst case",
                       figure(bars_of(a, "Share of the worst case of " + name, c.share_worst_case)));
  }
  const std::string filters =
      a.spec.filters.empty() ? ""
      : a.spec.model.sources.empty() && !a.spec.model.along_motion
          ? "<p>Behind each filter the shares are the same: its norm multiplies every encoder's part.</p>"
          : "<p>The shares are those of the unfiltered position: behind a filter the effects of the spec "
            "have other shares, according to their spectra.</p>";
  return page::choice("Coordinate and bound", all) + filters;
}

}  // namespace qerr
