#include "report/csv_text.hpp"
#include "report/formats.hpp"
#include "report/simulation/signals.hpp"

namespace qerr {

namespace {

/// The figures, and the factors of the ladder.
Figures cells_of(const SimulatedSignal& s) {
  Figures all = figures_of(s);
  for (const auto& factor : factors_of(s.ladder)) all.push_back(factor);
  return all;
}

}  // namespace

std::string to_csv(const SimulationReport& r, const Style&) {
  std::string out = "filter,coordinate,unit";
  for (const auto& cell : cells_of({})) out += ',' + std::string(cell.first);
  out += "\r\n";
  for (const NamedSignal& s : signals_of(r)) {
    out += csv_cell(s.filter) + ',' + s.coordinate + ',' + s.unit;
    for (const auto& [name, value] : cells_of(s.signal)) out += ',' + csv_number(value);
    out += "\r\n";
  }
  return out;
}

}  // namespace qerr
