#include "report/formats.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "core/text.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

template <class Report>
Json whole_json(const Report& report) {
  return json_of(report);
}
template <>
Json whole_json(const ListReport& report) {
  return json_of(report.rows);
}
/// The report of one spec; for several a list of such reports.
template <>
Json whole_json(const CheckReport& report) {
  const bool single = report.specs.size() == 1 && report.broken.empty();
  return single ? json_of(report.specs.front()) : json_of(report);
}

template <class Report>
std::string to_json(const Report& report, const Style&) {
  return document(whole_json(report));
}

template <class Report>
std::string to_html(const Report& report, const Style&) {
  page::Page page = page_of(report);
  page.report = line(whole_json(report));
  return markup(page);
}

template <class Report>
struct Exporter {
  Format format;
  Writer<Report>* write;
};

/// The page of a report; null: it has none.
template <class Report>
constexpr Writer<Report>* html_of() {
  if constexpr (requires(const Report& r) { page_of(r); })
    return to_html<Report>;
  else
    return nullptr;
}

/// The table in Markdown of a report; null: it has none.
template <class Report>
constexpr Writer<Report>* markdown_of() {
  if constexpr (std::same_as<Report, CheckReport>)
    return to_markdown;
  else
    return nullptr;
}

/// The first row is the format of an output whose ending is not listed.
template <class Report>
inline constexpr std::array<Exporter<Report>, 5> exporters{{
    {{"table", ".txt", "for reading on a terminal"}, to_table},
    {{"json", ".json", "everything, SI units"}, to_json<Report>},
    {{"csv", ".csv", "one figure a row, RFC 4180, SI units"}, to_csv},
    {{"html", ".html", "a page with pictures"}, html_of<Report>()},
    {{"md", ".md", "a table in Markdown, of check"}, markdown_of<Report>()},
}};

Error not_written(std::string_view format) {
  return Error("", format == "html" ? "this report has no page" : "this report is not written in this format",
               quoted(std::string(format)), "choose table, json or csv with --format", Trouble::usage);
}

template <class Report>
std::string changes_above(const Report& report, const Style& style) {
  if constexpr (requires { report.spec; }) return changes_above(report.spec, style.width);
  if constexpr (requires { report.specs; })
    return report.specs.empty() ? "" : changes_above(report.specs.front().analysis.spec, style.width);
  return "";
}

}  // namespace

std::string changes_above(const Spec& spec, std::size_t width) {
  std::string all;
  for (const auto& [key, value] : spec.overrides) {
    std::string text = key + '=' + value;
    std::ranges::replace(text, '\n', ' ');
    all += (all.empty() ? "with --set " : ", --set ") + escaped(text, 100);
  }
  return all.empty() ? "" : wrapped(all, width);
}

void refuse_page(std::string_view format) {
  if (format == "html") throw not_written(format);
}

std::string_view version() { return QERR_VERSION; }

const std::vector<Format>& formats() {
  static const std::vector<Format> list = [] {
    std::vector<Format> rows;
    for (const auto& exporter : exporters<Analysis>) rows.push_back(exporter.format);
    return rows;
  }();
  return list;
}

std::string_view format_of(std::string_view path) {
  for (const Format& format : formats())
    if (path.ends_with(format.ending)) return format.name;
  return formats().front().name;
}

template <class Report>
std::string write(const Report& report, std::string_view format, const Style& style) {
  for (const Exporter<Report>& exporter : exporters<Report>)
    if (exporter.format.name == format) {
      if (exporter.write == nullptr) throw not_written(format);
      return (format == "table" || format == "md" ? changes_above(report, style) : "") +
             exporter.write(report, style);
    }
  throw Error("", "unknown format", "'" + std::string(format) + "'",
              did_you_mean(format, names_of(formats())), Trouble::usage);
}

template std::string write(const Analysis&, std::string_view, const Style&);
template std::string write(const CheckReport&, std::string_view, const Style&);
template std::string write(const ReportComparison&, std::string_view, const Style&);
template std::string write(const DesignReport&, std::string_view, const Style&);
template std::string write(const ThresholdReport&, std::string_view, const Style&);
template std::string write(const FilterReport&, std::string_view, const Style&);
template std::string write(const SimulationReport&, std::string_view, const Style&);
template std::string write(const DiagnosisReport&, std::string_view, const Style&);
template std::string write(const PlanReport&, std::string_view, const Style&);
template std::string write(const RobotReport&, std::string_view, const Style&);
template std::string write(const ListReport&, std::string_view, const Style&);

namespace {

/// A value of the spec that --set replaced.
struct ChangedValue {
  std::string key, value;
};

ChangedValue changed_value(const std::pair<std::string, std::string>& o) { return {o.first, o.second}; }

}  // namespace

RowsOf<ChangedValue> rows(Of<ChangedValue>) {
  return {{"key", &ChangedValue::key}, {"value", &ChangedValue::value}};
}

RowsOf<Spec> rows(Of<Spec>) {
  return {{"file", &Spec::file},
          {"sha256", &Spec::sha256, "of the file's bytes"},
          {"set", [](auto& s) { return each(s.overrides, changed_value); }, "the values that --set replaced",
           optional}};
}

RowsOf<Interval> rows(Of<Interval>) {
  return {{"lower", &Interval::lower, nullable}, {"upper", &Interval::upper, nullable}};
}

std::vector<std::vector<double>> nested(const Eigen::MatrixXd& m) {
  std::vector<std::vector<double>> rows;
  for (const auto& row : m.rowwise()) rows.emplace_back(row.begin(), row.end());
  return rows;
}

std::vector<std::pair<std::string, double>> by_joint(const Spec& spec, const Eigen::VectorXd& values) {
  std::vector<std::pair<std::string, double>> all;
  for (const double value : values) all.emplace_back(spec.model.chain.independent[all.size()].name, value);
  return all;
}

namespace {

/// A row: a command with a JSON report.
struct OutputSchema {
  std::string_view command;
  std::string_view title;
  Json (*schema)();
};

constexpr OutputSchema output_schemas[] = {
    {"analyze", "qerr analyze --format json", schema_of<Analysis>},
    {"check", "qerr check --format json",
     [] {
       return Json{{"anyOf", Json::array({schema_of<SpecCheck>(), schema_of<CheckReport>()})}};
     }},
    {"compare", "qerr compare --format json", schema_of<ReportComparison>},
    {"design", "qerr design --format json", schema_of<DesignReport>},
    {"filter", "qerr filter --format json", schema_of<FilterReport>},
    {"simulate", "qerr simulate --format json", schema_of<SimulationReport>},
    {"diagnose", "qerr diagnose --format json", schema_of<DiagnosisReport>},
    {"plan", "qerr diagnose --plan --format json", schema_of<PlanReport>},
    {"sweep", "qerr sweep --format json", sweep_schema},
    {"threshold", "qerr threshold --format json", schema_of<ThresholdReport>},
    {"robot", "qerr robot --format json", schema_of<RobotReport>},
    {"list", "qerr list --format json", schema_of<std::vector<ListReport::Row>>},
};

}  // namespace

std::vector<std::string> output_schema_names() {
  std::vector<std::string> names;
  for (const OutputSchema& row : output_schemas) names.emplace_back(row.command);
  return names;
}

std::string output_schema(std::string_view command) {
  for (const OutputSchema& row : output_schemas)
    if (row.command == command) {
      Json root = {{"$schema", "https://json-schema.org/draft/2020-12/schema"}, {"title", row.title}};
      root.update(row.schema());
      return document(root);
    }
  throw std::logic_error("no report has the name '" + std::string(command) + "'");
}

}  // namespace qerr
