#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "qerr/report/analysis.hpp"

namespace qerr {

/// Counts, during an analysis, the configurations at which bounds exceed limits, and where the tip is there.
///
///     ExceedanceCounter counter(limits);
///     options.visit = counter.visitor();
///     Analysis a = analyze(spec, options);
///     a.exceedances = counter.result(a);
class ExceedanceCounter {
 public:
  /// @param spec    with the lengths of the limits among its coordinates
  /// @param limits  at_most, of bounds of coordinates; their statistic has no meaning here
  ExceedanceCounter(const Spec& spec, std::vector<Requirement> limits);
  ~ExceedanceCounter();

  /// For WorkspaceOptions::visit. @pre the counter outlives the analysis
  std::function<void(const ConfigurationBatch&)> visitor();

  /// @throws Error (usage) if a bound is not known: sigma behind a filter, of errors of unknown spectrum
  std::vector<Exceedance> result(const Analysis&) const;

 private:
  struct Job;
  std::unique_ptr<Job> job_;
};

}  // namespace qerr
