#include "report/sweep/swept_variant.hpp"

#include "report/analysis/effects.hpp"
#include "report/analysis/proofs.hpp"
#include "report/analysis/proofs.hpp"
#include "report/check/parts.hpp"

namespace qerr {

namespace {

/// The first fault, without its place, which is the same for many variants.
std::string fault_text(const Error& error) {
  Fault fault = error.faults().front();
  fault.place = {};
  const std::string text = format({fault});
  constexpr std::string_view program = "qerr: ";  // in place of a place
  return text.starts_with(program) ? text.substr(program.size()) : text;
}

/// @param evaluate  what can fail
template <class Evaluate>
void guard(SweptVariant& v, Evaluate evaluate) {
  try {
    evaluate();
  } catch (const Error& e) {
    if (e.trouble() != Trouble::input) throw;
    v.check.reset();
    v.fault = fault_text(e);
  }
}

}  // namespace

SweptVariant prepared_variant(const SpecVariants& variants, const SweepGrid& grid, std::uint64_t variant,
                              bool judged, const WorkspaceOptions& options,
                              const std::function<bool(const Analysis&)>& without_workspace) {
  SweptVariant v{variant, {}, {}};
  guard(v, [&] {
    const Spec spec = grid.spec(variants, grid.steps(variant));
    EffectReport effects = effect_report(spec);
    if (judged) require_known(spec, effects.shares);
    v.check.emplace(
        SpecCheck{unbounded_analysis(spec, std::move(effects), noise_in_motion(spec, options.threads)), {}});
    Analysis& a = v.check->analysis;
    if (without_workspace(a)) return;
    WorkspaceOptions all = options;
    all.noise_in_motion = a.noise_in_motion;
    a.workspace = workspace(a.spec.model, filter_norms(a.spec), a.spec.configurations, all);
  });
  if (v.check && v.check->analysis.workspace.count > 0) judge(v, judged);
  return v;
}

void judge(SweptVariant& v, bool judged) {
  guard(v, [&] {
    Analysis& a = v.check->analysis;
    add_proofs(a, {}, 1);  // of requirements; variants are evaluated on all threads
    if (judged) v.check->results = requirement_results(a);
  });
}

SweptVariant evaluate_variant(const SpecVariants& variants, const SweepGrid& grid, std::uint64_t variant,
                              bool judged, const WorkspaceOptions& options) {
  return prepared_variant(variants, grid, variant, judged, options, [](const Analysis&) { return false; });
}

}  // namespace qerr
