#include "report/sweep/swept_variant.hpp"

#include "report/analysis/effects.hpp"
#include "report/analysis/proofs.hpp"
#include "report/analysis/requirements.hpp"

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
/// @returns whether it failed, because of the input
template <class Evaluate>
bool failed(SweptVariant& v, Evaluate evaluate) {
  try {
    evaluate();
    return false;
  } catch (const Error& e) {
    if (e.trouble() != Trouble::input) throw;
    v.fault = fault_text(e);
    return true;
  }
}

}  // namespace

SweptVariant prepared_variant(const SpecVariants& variants, const SweepGrid& grid, std::uint64_t variant,
                              bool judged, const WorkspaceOptions& options,
                              const std::function<bool(const Analysis&)>& without_workspace) {
  SweptVariant v{variant, {}, {}};
  const bool no_figures = failed(v, [&] {
    const Spec spec = grid.spec(variants, grid.steps(variant));
    EffectReport effects = effect_report(spec);
    v.check.emplace(
        SpecCheck{unbounded_analysis(spec, std::move(effects), noise_in_motion(spec, options.threads)), {}});
    Analysis& a = v.check->analysis;
    if (without_workspace(a)) return;
    WorkspaceOptions all = options;
    all.noise_in_motion = a.noise_in_motion;
    a.workspace = workspace_with_quantization(a.spec.model, filter_norms(a.spec), a.spec.configurations, all);
  });
  if (no_figures) v.check.reset();
  if (v.check && v.check->analysis.workspace.count > 0) judge(v, judged);
  return v;
}

void judge(SweptVariant& v, bool judged) {
  if (!judged) return;
  const bool undecided = failed(v, [&] {
    Analysis& a = v.check->analysis;
    require_known(a.spec, a.effects);
    add_proofs(a, {}, 1);  // variants are evaluated on all threads
    v.check->results = requirement_results(a);
  });
  if (undecided) v.check->results.clear();
}

SweptVariant evaluate_variant(const SpecVariants& variants, const SweepGrid& grid, std::uint64_t variant,
                              bool judged, const WorkspaceOptions& options) {
  return prepared_variant(variants, grid, variant, judged, options, [](const Analysis&) { return false; });
}

}  // namespace qerr
