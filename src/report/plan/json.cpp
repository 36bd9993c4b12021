#include "report/json_header.hpp"
#include "report/plan/parts.hpp"

namespace qerr {

namespace {

using JointEffect = In<PlannedEffect, PlannedJoint>;

using BetterMotion = In<Motion, PlanReport>;

/// An effect with the choices and the figures that tell it from others of its type.
template <class Entry, class Planned>
RowsOf<Entry> effect_rows(Effect Planned::*effect) {
  const auto number = [effect](const char* name) {
    return [=](const Entry& e) {
      const Effect& of = std::invoke(effect, e);
      return of.numbers.contains(name) ? std::optional(of.number(name)) : std::nullopt;
    };
  };
  return {{"effect", [effect](auto& e) { return std::invoke(effect, e).type; }},
          {"shaft",
           [effect](auto& e) {
             const Effect& of = std::invoke(effect, e);
             return of.choices.contains("shaft") ? of.choices.at("shaft") : "";
           },
           optional},
          {"order", number("order"), optional},
          {"time_constant", number("time_constant"), optional}};
}

}  // namespace

RowsOf<CorrelatedEffect> rows(Of<CorrelatedEffect>) {
  return effect_rows<CorrelatedEffect>(&CorrelatedEffect::effect)
      .with({{"correlation", &CorrelatedEffect::correlation},
             {"told_apart", &CorrelatedEffect::separable_from, "from this magnitude on", nullable},
             {"record", &CorrelatedEffect::record, "what tells them apart"}});
}

RowsOf<JointEffect> rows(Of<JointEffect>) {
  return effect_rows<JointEffect>(&PlannedEffect::effect)
      .with({{"parameter", &PlannedEffect::parameter},
             {"unit", [](auto& e) { return size_unit(*e, e.whole.prismatic); }},
             {"seen", &PlannedEffect::detectable, "smallest detectable magnitude", nullable},
             {"named", &PlannedEffect::identifiable, "smallest identifiable magnitude", nullable},
             {"seen_counts", &PlannedEffect::detectable_counts, nullable},
             {"named_counts", &PlannedEffect::identifiable_counts, nullable},
             {"alike", &PlannedEffect::correlated}});
}

RowsOf<UndetectableEffect> rows(Of<UndetectableEffect>) {
  return {{"effect", &UndetectableEffect::effect}, {"needs", &UndetectableEffect::required}};
}

RowsOf<PlannedJoint> rows(Of<PlannedJoint>) {
  return {{"joint", &PlannedJoint::joint},
          {"unit", [](auto& j) { return j.prismatic ? "m" : "rad"; }},
          {"resolution", &PlannedJoint::resolution},
          {"moves", &PlannedJoint::moves},
          {"readings", &PlannedJoint::readings, "independent ones"},
          {"effects", within(&PlannedJoint::effects)},
          {"unseen", &PlannedJoint::undetectable}};
}

RowsOf<BetterMotion> rows(Of<BetterMotion>) {
  return {{"motion", [](auto& b) { return motion_text(*b, b.whole.spec.model.chain); }, "YAML to paste"},
          {"changed",
           [](auto& b) {
             const auto& joints = b.whole.spec.model.chain.independent;
             return b.whole.plan.changed |
                    std::views::transform([&](std::size_t j) { return joints[j].name; });
           },
           "joints"},
          {"joints", [](auto& b) { return b.whole.plan.joints_better; }}};
}

RowsOf<PlanReport> rows(Of<PlanReport>) {
  return header<PlanReport>("diagnose --plan")
      .with({{"spec",
              {{"file", [](auto& r) { return r.spec.file; }},
               {"sha256", [](auto& r) { return r.spec.sha256; }}}},
             {"reference_noise", [](auto& r) { return r.plan.options.reference_noise; }, "counts"},
             {"power", [](auto& r) { return r.plan.options.power; }},
             {"joints", [](auto& r) { return r.plan.joints; }},
             {"better", within([](auto& r) { return r.plan.better; }), "a motion that identifies more"},
             {"warnings", &PlanReport::warnings}});
}

}  // namespace qerr
