#include "report/csv_text.hpp"
#include "report/formats.hpp"
#include "report/list/parameter_unit.hpp"

namespace qerr {

std::string to_csv(const ListReport& report, const Style&) {
  std::string out = "name,parameter,unit,default,meaning";
  for (const auto& note : report.rows.front().notes) out += ',' + note.first;
  out += "\r\n";
  for (const ListReport::Row& row : report.rows) {
    out += csv_cell(row.name) + ",,,," + csv_cell(row.summary);
    for (const auto& note : row.notes) out += ',' + csv_cell(note.second);
    out += "\r\n";
    for (const Parameter& p : row.parameters)
      out += csv_cell(row.name) + ',' + std::string(p.name) + ',' + parameter_unit(p) + ',' +
             (p.fallback ? shortest(*p.fallback) : "") + ',' + csv_cell(std::string(p.meaning)) +
             std::string(row.notes.size(), ',') + "\r\n";
  }
  return out;
}

}  // namespace qerr
