#include "report/json_header.hpp"

namespace qerr {

namespace {

struct Override {
  std::string key, value;
};

Override override_of(const std::pair<std::string, std::string>& o) { return {o.first, o.second}; }

}  // namespace

RowsOf<Override> rows(Of<Override>) { return {{"key", &Override::key}, {"value", &Override::value}}; }

RowsOf<Spec> rows(Of<Spec>) {
  return {{"file", &Spec::file},
          {"sha256", &Spec::sha256, "of the file's bytes"},
          {"set", [](auto& s) { return s.overrides | std::views::transform(override_of); },
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

}  // namespace qerr
