#include "report/json_header.hpp"

#include "qerr/report/write.hpp"

namespace qerr {

Json spec_source(const Spec& spec) {
  Json source = {{"file", spec.file}, {"sha256", spec.sha256}};
  for (const auto& [key, value] : spec.overrides) source["set"].push_back({{"key", key}, {"value", value}});
  return source;
}

Json report_header(const Spec& spec, const char* command, std::uint64_t seed) {
  const Chain& chain = spec.model.chain;
  return {{"qerr", version()},
          {"command", command},
          {"spec", spec_source(spec)},
          {"seed", seed},
          {"robot", {{"name", spec.robot_name}, {"base", chain.base}, {"tip", chain.tip}}}};
}

}  // namespace qerr
