#include "report/analysis/json_header.hpp"

namespace qerr {

std::string_view method_name(const Spec& spec) {
  const SamplingMethod method = spec.configurations.method;
  return method == SamplingMethod::sobol    ? "sobol"
         : method == SamplingMethod::random ? "random"
         : method == SamplingMethod::grid   ? "grid"
         : spec.points_file.empty()         ? "list"
                                            : "file";
}

std::vector<std::pair<std::string, double>> budget(const Analysis& a) {
  const std::vector<double> shares = encoder_budget(a);
  return by_joint(a.spec, Eigen::Map<const Eigen::VectorXd>(shares.data(), std::ssize(shares)));
}

RowsOf<ReportedProof> rows(Of<ReportedProof>) {
  return {{"lower", &ReportedProof::lower, "reached at `at`", nullable},
          {"upper", &ReportedProof::upper, "never exceeded, rounding included; null: no bound is known",
           nullable},
          {"gap", &ReportedProof::gap, "upper/lower - 1; null: unbounded", nullable},
          {"at", [](auto& p) { return by_joint(p.spec, p.at); }, "joints"}};
}

}  // namespace qerr
