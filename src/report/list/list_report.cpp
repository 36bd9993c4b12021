#include "core/suggest.hpp"
#include "qerr/bound/statistic.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "qerr/encoder/encoder_kinds.hpp"
#include "qerr/filter/family.hpp"
#include "qerr/filter/representations.hpp"
#include "qerr/kinematics/coordinates.hpp"
#include "qerr/report/write.hpp"
#include "report/list/parameter_unit.hpp"

namespace qerr {

namespace {

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
  return rows;
}

}  // namespace

const std::vector<std::string>& list_kinds() {
  static const std::vector<std::string> kinds{"effects", "filters",     "encoders",
                                              "formats", "coordinates", "statistics"};
  return kinds;
}

ListReport list_report(std::string_view kind) { return {rows_of(kind)}; }

std::string parameter_unit(const Parameter& p) {
  if (p.kind != Kind::number) return {};
  return p.coordinate ? "rad or m" : unit_name(p.dimension);
}

}  // namespace qerr
