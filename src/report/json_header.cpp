#include "report/json_header.hpp"

#include <stdexcept>

#include "qerr/report/write.hpp"

namespace qerr {

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
          {"set", [](auto& s) { return s.overrides | std::views::transform(changed_value); },
           "the values that --set replaced", optional}};
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
      root.append(row.schema());
      return root.document();
    }
  throw std::logic_error("no report has the name '" + std::string(command) + "'");
}

}  // namespace qerr
