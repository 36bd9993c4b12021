#include "report/analysis/json_header.hpp"

namespace qerr {

Json analysis_header(const Analysis& a, const char* command) {
  const Spec& spec = a.spec;
  const auto method = spec.configurations.method;
  Json j = report_header(spec, command, spec.configurations.seed);
  j["configurations"] = {{"method", method == SamplingMethod::sobol    ? "sobol"
                                    : method == SamplingMethod::random ? "random"
                                    : method == SamplingMethod::grid   ? "grid"
                                    : spec.points_file.empty()         ? "list"
                                                                       : "file"},
                         {"count", a.workspace.count}};
  return j;
}

Json by_joint(const Spec& spec, const Eigen::VectorXd& values) {
  Json object = Json::object();
  for (Eigen::Index i = 0; i < values.size(); ++i)
    object[spec.model.chain.independent[static_cast<std::size_t>(i)].name] = values[i];
  return object;
}

Json proven_json(const Spec& spec, const ProvenMaximum& proven) {
  return {{"lower", proven.lower},
          {"upper", proven.upper},
          {"gap", proven.gap()},
          {"at", by_joint(spec, proven.at)}};
}

}  // namespace qerr
