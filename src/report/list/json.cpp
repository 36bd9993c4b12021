#include <cmath>

#include "report/list/parameter_unit.hpp"
#include "report/output_schemas.hpp"

namespace qerr {

namespace {

/// A further column, by its name.
auto note(std::string_view name) {
  return [name](const ListReport::Row& row) {
    for (const auto& [of, text] : row.notes)
      if (of == name) return text;
    return std::string();
  };
}

}  // namespace

RowsOf<Parameter> rows(Of<Parameter>) {
  return {{"name", &Parameter::name},
          {"unit", parameter_unit, "SI; empty of a pure number and of other kinds"},
          {"meaning", &Parameter::meaning},
          {"required", &Parameter::required},
          {"default", &Parameter::fallback, optional},
          {"least", [](auto& p) { return only_if(std::isfinite(p.least), p.least); }, optional},
          {"most", [](auto& p) { return only_if(std::isfinite(p.most), p.most); }, optional},
          {"choices", choices_of, "the default first", optional}};
}

RowsOf<ListReport::Row> rows(Of<ListReport::Row>) {
  return {{"name", &ListReport::Row::name},
          {"summary", &ListReport::Row::summary},
          {"parameters", &ListReport::Row::parameters},
          {"stage", note("stage"), "of an effect: where it acts", optional},
          {"typical", note("typical"), "of an effect: usual magnitudes", optional}};
}

}  // namespace qerr
