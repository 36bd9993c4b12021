#include <cmath>

#include "core/text.hpp"
#include "report/analysis/control.hpp"
#include "report/analysis/count_rates.hpp"
#include "report/analysis/effects.hpp"
#include "report/analysis/proofs.hpp"
#include "report/analysis/tables.hpp"
#include "report/formats.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

std::string name_of(SamplingMethod m) {
  switch (m) {
    case SamplingMethod::sobol:
      return "Sobol";
    case SamplingMethod::random:
      return "random";
    case SamplingMethod::grid:
      return "grid";
    case SamplingMethod::list:
      return "listed";
  }
  return {};
}

}  // namespace

std::string shown_unit(std::string_view unit, const Filter& filter) {
  return has_unknown_unit(filter) ? "" : derivative_unit(unit, filter);
}

double cleaned(double value) { return std::abs(value) < 1e-18 ? 0 : value; }

bool has_effects(const Analysis& a) { return !a.spec.model.sources.empty() || a.spec.model.along_motion; }

std::string norm_text(const NamedFilter& f) {
  const std::string unit = f.filter.derivative == 0   ? ""
                           : f.filter.derivative == 1 ? "/s"
                                                      : "/s^" + std::to_string(f.filter.derivative);
  return "H2 norm " + significant(f.norms.h2, 5) + unit + ", l1 norm " + significant(f.norms.l1.upper, 5) +
         unit + ", " + readable(1 / f.filter.sample_rate, "s") + " a sample";
}

std::string to_table(const Analysis& a, const Style& style) {
  const Chain& chain = a.spec.model.chain;
  const std::string robot = "robot '" + escaped(a.spec.robot_name, 60) + "', " + escaped(chain.base, 60) +
                            " -> " + escaped(tips_of(a.spec.model), 120);
  std::string out = painted("qerr analyze", Paint::bold, style) +
                    wrapped("qerr analyze " + robot, style.width, "  ", "").substr(12) +
                    counted(chain.independent.size(), "encoder") + ", " + std::to_string(a.workspace.count) +
                    ' ' + name_of(a.spec.configurations.method) +
                    (a.workspace.count == 1 ? " configuration\n" : " configurations\n");
  out += heading(
             a.spec.model.along_motion
                 ? "Encoders: error at the joint with the effects, share of the encoders' variance at the tip"
             : has_effects(a) ? "Encoders and effects: error at the joint, share of the tip's variance"
                              : "Encoders: error at the joint, share of the tip's variance, first to upgrade",
             style) +
         encoder_table(a, style);
  out += accuracy_table(a, style) + count_rate_table(a.spec, style);
  if (!a.effects.empty())
    out +=
        heading("Effects: errors that they add at the joint", style) + effect_table(a.spec, a.effects, style);
  return out + (style.details ? detail_tables(a, style) : summary_table(a, style)) +
         (a.control ? control_text(a.spec, *a.control, style) : "") + exceedance_tables(a, style) +
         proof_table(a, style);
}

}  // namespace qerr
