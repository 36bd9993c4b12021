#pragma once

#include <functional>
#include <mutex>
#include <vector>

#include "qerr/report/analysis.hpp"

namespace qerr {

/// Counts, during an analysis, the configurations at which bounds exceed limits, and where the tip is there.
///
///     ExceedanceCounter counter(spec, limits);
///     options.visit = counter.visitor();
///     Analysis a = analyze(spec, options);
///     a.exceedances = counter.result(a);
class ExceedanceCounter {
 public:
  /// @param spec    with the lengths of the limits among its coordinates
  /// @param limits  at_most, of bounds of coordinates; their statistic has no meaning here
  ExceedanceCounter(const Spec& spec, std::vector<Requirement> limits);

  /// For WorkspaceOptions::visit. @pre the counter outlives the analysis
  std::function<void(const ConfigurationBatch&)> visitor() {
    return [this](const ConfigurationBatch& batch) { count(batch); };
  }

  /// @throws Error (usage) if a bound is not known: sigma behind a filter, of errors of unknown spectrum
  std::vector<Exceedance> result(const Analysis&) const;

 private:
  void count(const ConfigurationBatch&);
  void add(Exceedance&, const Eigen::Vector3d& tip, bool above) const;

  Chain chain_;
  std::vector<Norms> filters_;
  std::vector<Requirement> limits_;
  std::vector<Figure> figures_;  // of the limits
  double step_;                  // between the distances of two shells [m]
  std::mutex guard_;
  std::vector<Exceedance> counts_;  // [limit]; sums and extremes do not depend on the order of the batches
};

}  // namespace qerr
