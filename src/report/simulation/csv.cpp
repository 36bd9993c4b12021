#include "report/csv_text.hpp"
#include "report/formats.hpp"
#include "report/simulation/estimators.hpp"
#include "report/simulation/signals.hpp"

namespace qerr {

std::string to_csv(const SimulationReport& r, const Style&) {
  return r.estimators.empty() ? csv_of(signals_of(r)) : estimator_csv(r);
}

}  // namespace qerr
