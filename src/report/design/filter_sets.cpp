#include "report/design/filter_sets.hpp"

namespace qerr {

std::vector<FilterSet> filter_sets(const Spec& spec, const DesignRequest&, std::optional<std::size_t>) {
  return {{spec.filters, {}}};
}

SpecChange lowpass_change(const DesignedFilter& f) {
  return {"filters." + f.name + ".lowpass",
          mapping_node({{"family", scalar_node(f.family)},
                        {"order", scalar_node(std::to_string(f.order))},
                        {"cutoff", scalar_node(shortest(f.cutoff) + " Hz")}})};
}

}  // namespace qerr
