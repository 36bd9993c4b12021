#include <cmath>

#include "report/formats.hpp"
#include "report/json_value.hpp"
#include "report/list/parameter_unit.hpp"

namespace qerr {

std::string to_json(const ListReport& report, const Style&) {
  Json list = Json::array();
  for (const ListReport::Row& row : report.rows) {
    Json parameters = Json::array();
    for (const Parameter& p : row.parameters) {
      Json parameter = {
          {"name", p.name}, {"unit", parameter_unit(p)}, {"meaning", p.meaning}, {"required", p.required}};
      if (p.fallback) parameter["default"] = *p.fallback;
      if (std::isfinite(p.least)) parameter["least"] = p.least;
      if (std::isfinite(p.most)) parameter["most"] = p.most;
      if (!p.choices.empty()) parameter["choices"] = choices_of(p);
      parameters.push_back(parameter);
    }
    list.push_back({{"name", row.name}, {"summary", row.summary}, {"parameters", parameters}});
    for (const auto& [name, text] : row.notes) list.back()[name] = text;
  }
  return list.document();
}

}  // namespace qerr
