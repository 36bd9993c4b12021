#include "qerr/report/write.hpp"

#include <algorithm>

#include "core/text.hpp"
#include "qerr/encoder/encoder_kinds.hpp"
#include "qerr/filter/family.hpp"
#include "qerr/filter/representations.hpp"
#include "report/text_table.hpp"
#include "report/writers.hpp"

namespace qerr {

const std::vector<Format>& formats() {
  static const std::vector<Format> list{{"table", ".txt", "for reading on a terminal"},
                                        {"json", ".json", "everything, SI units"},
                                        {"csv", ".csv", "one figure a row, RFC 4180, SI units"}};
  return list;
}

std::string_view version() { return QERR_VERSION; }

std::string write(const Analysis& a, std::string_view format, const Style& style) {
  return format == "json" ? to_json(a) : format == "csv" ? to_csv(a) : to_table(a, style);
}

std::string write_check(const Analysis& a, std::string_view format, const Style& style) {
  return format == "json" ? check_json(a) : format == "csv" ? check_csv(a) : check_table(a, style);
}

std::string write(const std::vector<ThresholdRow>& rows, std::string_view format, const Style& style) {
  return format == "json"  ? threshold_json(rows)
         : format == "csv" ? threshold_csv(rows)
                           : threshold_table(rows, style);
}

bool all_met(const Analysis& a) {
  return std::all_of(a.spec.requirements.begin(), a.spec.requirements.end(),
                     [&](const Requirement& r) { return evaluate(r, a.workspace).met; });
}

namespace {

std::string xml(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        // XML 1.0 has no way to write most control characters.
        out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
  }
  return out;
}

std::vector<ListRow> rows_of(std::string_view kind) {
  std::vector<ListRow> rows;
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
  if (kind == "statistics")
    for (const StatisticKind& s : statistic_kinds())
      rows.push_back({std::string(s.name), std::string(s.summary)});
  return rows;
}

}  // namespace

std::string junit(const Analysis& a) {
  std::size_t failed = 0;
  std::string cases;
  for (const Requirement& r : a.spec.requirements) {
    const RequirementResult result = evaluate(r, a.workspace);
    cases += "  <testcase classname=\"qerr\" name=\"" + xml(r.quantity + ' ' + r.statistic) + "\" file=\"" +
             xml(r.place.file) + "\" line=\"" + std::to_string(r.place.line) + "\"";
    if (result.met) {
      cases += "/>\n";
    } else {
      ++failed;
      cases += ">\n    <failure message=\"" +
               xml(r.quantity + ' ' + r.statistic + " is " + readable(result.value, r.unit) + ", at most " +
                   readable(r.at_most, r.unit) + " is required") +
               "\"/>\n  </testcase>\n";
    }
  }
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"" + xml(a.spec.file) + "\" tests=\"" +
         std::to_string(a.spec.requirements.size()) + "\" failures=\"" + std::to_string(failed) + "\">\n" +
         cases + "</testsuite>\n";
}

const std::vector<std::string>& list_kinds() {
  static const std::vector<std::string> kinds{"effects", "filters",     "encoders",
                                              "formats", "coordinates", "statistics"};
  return kinds;
}

std::string write_list(std::string_view kind, std::string_view format) {
  const std::vector<ListRow> rows = rows_of(kind);
  if (rows.empty()) return {};
  return format == "json" ? rows_json(rows) : format == "csv" ? rows_csv(rows) : rows_table(rows);
}

std::string parameter_unit(const Parameter& p) {
  if (p.kind != Kind::number) return {};
  return p.coordinate ? "rad or m" : unit_name(p.dimension);
}

}  // namespace qerr
