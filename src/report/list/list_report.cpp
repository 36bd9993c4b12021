#include <cmath>

#include "core/text.hpp"
#include "qerr/bound/figure.hpp"
#include "qerr/core/quantity.hpp"
#include "qerr/design/requirement.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "qerr/encoder/encoder.hpp"
#include "qerr/filter/family.hpp"
#include "qerr/kinematics/coordinates.hpp"
#include "qerr/report/write.hpp"
#include "report/formats.hpp"
#include "report/text_table.hpp"
#include "simulate/estimators/estimator.hpp"

namespace qerr {

namespace {

void add_quantities(std::vector<ListReport::Row>& rows) {
  for (const bool behind_filter : {false, true})
    for (const Bound b : bounds_of(behind_filter))
      rows.push_back(
          {(behind_filter ? "FILTER.COORDINATE." : "position.COORDINATE.") + std::string(name_of(b)),
           std::string(summary_of(b))});
  for (const FilterFigure& f : filter_figures())
    rows.push_back({"FILTER." + std::string(f.name), std::string(f.summary) + "; without a statistic"});
  rows.push_back(
      {"encoder.JOINT.count_rate",
       "counts per second along `motion:`, else at the URDF's velocity limit; without a statistic"});
  rows.push_back({"torque.JOINT.BOUND", "torque of a controller of `control:`, the loop open"});
  rows.push_back({"closed_torque.JOINT.BOUND", "torque in the closed loop: worst_case or sigma"});
  rows.push_back(
      {"closed_position.JOINT.BOUND", "true motion in the closed loop; of the tip: closed_position.x.sigma"});
  rows.push_back(
      {"loop.JOINT.FIGURE", "gain_margin, phase_margin, bandwidth or limit_cycle; without a statistic"});
  rows.push_back({"wall.NAME.stiffness", "largest stiffness that stays passive; without a statistic"});
  rows.push_back(
      {"control.JOINT.kd_max", "largest kd that meets a requirement on the torque; without a statistic"});
}

void add_units(std::vector<ListReport::Row>& rows) {
  std::string prefixes;
  for (const UnitPrefix& p : unit_prefixes()) prefixes += (prefixes.empty() ? "" : " ") + std::string(p.name);
  for (const UnitSymbol& s : unit_symbols()) {
    const std::string si = unit_name(s.dimension);
    rows.push_back({std::string(s.name), significant(s.factor, 9) + (si.empty() ? "" : ' ' + si) +
                                             (s.prefixable ? "; with a prefix, too: " + prefixes : "")});
  }
  rows.push_back({"mm/s, rad/s^2, N m/rad", "products, quotients and powers of the others"});
}

std::vector<ListReport::Row> rows_of(std::string_view kind) {
  std::vector<ListReport::Row> rows;
  if (kind == "filters") {
    for (const FilterFamily& f : filter_families())
      rows.push_back({std::string(f.name), std::string(f.summary), f.parameters});
    for (const FilterRepresentation& r : filter_representations()) {
      rows.push_back({std::string(r.name), std::string(r.summary), {r.key}});
      for (const auto& more : {r.inside, r.beside})
        rows.back().parameters.insert(rows.back().parameters.end(), more.begin(), more.end());
    }
  }
  if (kind == "encoders")
    for (const EncoderKind& e : encoder_kinds())
      rows.push_back({std::string(e.name), std::string(e.summary), encoder_parameters(e)});
  if (kind == "effects")
    for (const EffectKind& e : effect_kinds())
      rows.push_back({std::string(e.name),
                      std::string(e.summary),
                      e.parameters,
                      {{"stage", std::string(stage_name(e.stage))}, {"typical", std::string(e.typical)}}});
  if (kind == "estimators")
    for (const EstimatorKind& e : estimator_kinds())
      rows.push_back({std::string(e.name), std::string(e.summary), e.parameters});
  if (kind == "formats")
    for (const Format& f : formats()) rows.push_back({std::string(f.name), std::string(f.summary)});
  if (kind == "coordinates")
    for (const CoordinateInfo& c : coordinate_list())
      rows.push_back({std::string(c.name), std::string(c.summary) + " [" + std::string(c.unit) + "]"});
  if (kind == "coordinates")
    for (const SignalKind& s : signal_kinds()) rows.push_back({std::string(s.group), std::string(s.summary)});
  if (kind == "statistics")
    for (const StatisticKind& row : statistic_kinds())
      rows.push_back({std::string(row.name), std::string(row.summary)});
  if (kind == "statistics")
    rows.push_back(
        {std::string(proven_statistic), "proven bound of the maximum over the whole joint ranges"});
  if (kind == "quantities") add_quantities(rows);
  if (kind == "units") add_units(rows);
  return rows;
}

/// A further column, by its name.
auto note(std::string_view name) {
  return [name](const ListReport::Row& row) {
    for (const auto& [of, text] : row.notes)
      if (of == name) return text;
    return std::string();
  };
}

/// Name, unit, meaning, choices and default in one sentence.
std::string described(const Parameter& p) {
  std::string text(p.name);
  if (const std::string unit = parameter_unit(p); !unit.empty()) text += " [" + unit + ']';
  text += ": " + std::string(p.meaning);
  if (!p.choices.empty()) {
    text += " (";
    const std::vector<std::string> words = choices_of(p);
    for (std::size_t i = 0; i < words.size(); ++i)
      text += (i ? ", " : "") + words[i] + (i ? "" : " by default");
    text += ')';
  }
  if (p.fallback) text += " (default " + shortest(*p.fallback) + ')';
  if (p.required) text += " (required)";
  return text;
}

}  // namespace

const std::vector<std::string>& list_kinds() {
  static const std::vector<std::string> kinds{"effects",    "filters",    "estimators",
                                              "encoders",   "formats",    "coordinates",
                                              "statistics", "quantities", "units"};
  return kinds;
}

ListReport list_report(std::string_view kind) { return {rows_of(kind)}; }

std::string parameter_unit(const Parameter& p) {
  if (p.kind != Kind::number) return {};
  return p.coordinate ? "rad or m" : unit_name(p.dimension);
}

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

std::string to_table(const ListReport& report, const Style& style) {
  std::string out;
  for (const ListReport::Row& row : report.rows) {
    out += painted(row.name, Paint::bold, style) + '\n' + wrapped(row.summary, style.width, "    ");
    for (const auto& [name, text] : row.notes) out += wrapped(name + ": " + text, style.width, "    ");
    for (const Parameter& p : row.parameters) out += wrapped(described(p), style.width, "      ", "    - ");
  }
  return out;
}

}  // namespace qerr
