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

}  // namespace qerr
