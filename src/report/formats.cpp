#include "report/formats.hpp"

#include <algorithm>
#include <array>

#include "core/suggest.hpp"
#include "core/text.hpp"
#include "report/check/parts.hpp"
#include "report/wrapped_text.hpp"

namespace qerr {

namespace {

/// The table in Markdown of a report; null: it has none.
template <class Report>
inline constexpr Writer<Report>* markdown_of = nullptr;
template <>
inline constexpr Writer<CheckReport>* markdown_of<CheckReport> = to_markdown;

template <class Report>
struct Exporter {
  Format format;
  Writer<Report>* write;
};

/// The page of a report; null: it has none.
template <class Report>
inline constexpr Writer<Report>* page_of = nullptr;
template <>
inline constexpr Writer<Analysis>* page_of<Analysis> = to_html;
template <>
inline constexpr Writer<ReportComparison>* page_of<ReportComparison> = to_html;
template <>
inline constexpr Writer<DesignReport>* page_of<DesignReport> = to_html;
template <>
inline constexpr Writer<FilterReport>* page_of<FilterReport> = to_html;
template <>
inline constexpr Writer<SimulationReport>* page_of<SimulationReport> = to_html;
template <>
inline constexpr Writer<DiagnosisReport>* page_of<DiagnosisReport> = to_html;

/// The first row is the format of an output whose ending is not listed.
template <class Report>
inline constexpr std::array<Exporter<Report>, 5> exporters{{
    {{"table", ".txt", "for reading on a terminal"}, to_table},
    {{"json", ".json", "everything, SI units"}, to_json},
    {{"csv", ".csv", "one figure a row, RFC 4180, SI units"}, to_csv},
    {{"html", ".html", "a page with pictures"}, page_of<Report>},
    {{"md", ".md", "a table in Markdown, of check"}, markdown_of<Report>},
}};

std::vector<std::string> format_names() {
  std::vector<std::string> names;
  for (const Format& format : formats()) names.emplace_back(format.name);
  return names;
}

Error not_written(std::string_view format) {
  return Error({{},
                "",
                format == "html" ? "this report has no page" : "this report is not written in this format",
                quoted(std::string(format)),
                "choose table, json or csv with --format"},
               Trouble::usage);
}

template <class Report>
std::string changes_above(const Report& report, const Style& style) {
  if constexpr (requires { report.spec; }) return changes_above(report.spec, style.width);
  if constexpr (requires { report.specs; })
    return report.specs.empty() ? "" : changes_above(report.specs.front().analysis.spec, style.width);
  return "";
}

template <class Report>
std::string written(const Report& report, std::string_view format, const Style& style) {
  for (const Exporter<Report>& exporter : exporters<Report>)
    if (exporter.format.name == format) {
      if (exporter.write == nullptr) throw not_written(format);
      return (format == "table" || format == "md" ? changes_above(report, style) : "") +
             exporter.write(report, style);
    }
  throw Error(
      {{}, "", "unknown format", "'" + std::string(format) + "'", did_you_mean(format, format_names())},
      Trouble::usage);
}

}  // namespace

std::string changes_above(const Spec& spec, std::size_t width) {
  std::string all;
  for (const auto& [key, value] : spec.overrides) {
    std::string text = key + '=' + value;
    std::replace(text.begin(), text.end(), '\n', ' ');
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

std::string write(const Analysis& r, std::string_view format, const Style& style) {
  return written(r, format, style);
}
std::string write(const CheckReport& r, std::string_view format, const Style& style) {
  return written(r, format, style);
}
std::string write(const ReportComparison& r, std::string_view format, const Style& style) {
  return written(r, format, style);
}
std::string write(const DesignReport& r, std::string_view format, const Style& style) {
  return written(r, format, style);
}
std::string write(const ThresholdReport& r, std::string_view format, const Style& style) {
  return written(r, format, style);
}
std::string write(const FilterReport& r, std::string_view format, const Style& style) {
  return written(r, format, style);
}
std::string write(const SimulationReport& r, std::string_view format, const Style& style) {
  return written(r, format, style);
}
std::string write(const DiagnosisReport& r, std::string_view format, const Style& style) {
  return written(r, format, style);
}
std::string write(const PlanReport& r, std::string_view format, const Style& style) {
  return written(r, format, style);
}
std::string write(const RobotReport& r, std::string_view format, const Style& style) {
  return written(r, format, style);
}
std::string write(const ListReport& r, std::string_view format, const Style& style) {
  return written(r, format, style);
}

}  // namespace qerr
