#include "report/sweep/swept_variant.hpp"

namespace qerr {

std::string fault_text(const Error& error) {
  Fault fault = error.faults().front();
  fault.place = {};
  return format({fault});
}

SweptVariant evaluate_variant(const SpecVariants& variants, const SweepGrid& grid, std::uint64_t variant,
                              bool judged, const WorkspaceOptions& options) {
  SweptVariant result{variant, {}, {}};
  try {
    const Spec spec = grid.spec(variants, grid.steps(variant));
    result.check = judged ? evaluate(spec, options) : SpecCheck{analyze(spec, options), {}};
  } catch (const Error& e) {
    if (e.trouble() != Trouble::input) throw;
    result.fault = fault_text(e);
  }
  return result;
}

}  // namespace qerr
