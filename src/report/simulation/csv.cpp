#include "report/csv_text.hpp"
#include "report/formats.hpp"
#include "report/simulation/signals.hpp"

namespace qerr {

std::string to_csv(const SimulationReport& r, const Style&) { return csv_of(signals_of(r)); }

}  // namespace qerr
