#include "qerr/report/simulation_report.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include "core/lists.hpp"
#include "core/text.hpp"
#include "kinematics/inverse_dynamics.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "qerr/report/analysis.hpp"
#include "qerr/report/filter_report.hpp"
#include "report/analysis/effects.hpp"
#include "report/analysis/figures.hpp"
#include "report/analysis/tables.hpp"
#include "report/rows.hpp"
#include "report/simulation/parts.hpp"
#include "report/text_table.hpp"
#include "simulate/sensing.hpp"
#include "simulate/unrounded_record.hpp"

namespace qerr {
std::vector<NamedSignal> signals_of(const SimulationReport& r) {
  std::vector<NamedSignal> all;
  for (std::size_t o = 0; o < r.simulation.results.size(); ++o) {
    const NamedFilter* filter = o == 0 ? nullptr : &r.spec.filters[o - 1];
    for (std::size_t c = 0; c < r.simulation.results[o].size(); ++c) {
      const Signal s = signal_of(r.spec.model.coordinates[c]);
      all.push_back({r.simulation.results[o][c], filter ? filter->name : "position", s.name,
                     filter ? derivative_unit(s.unit, filter->filter) : s.unit,
                     filter ? shown_unit(s.unit, filter->filter) : s.unit});
    }
  }
  return all;
}

namespace {

/// A motion that ends before its filters have settled, so that their transients are in the figures.
void warn_of_a_short_motion(const SimulationReport& r, std::vector<std::string>& warnings) {
  Motion endless = *r.spec.motion;
  endless.duration = std::numeric_limits<double>::infinity();
  const double needed = settling_time(endless, designed_filters(r.spec)),
               discarded = static_cast<double>(r.simulation.settling) / endless.sample_rate;
  if (needed > discarded + 2 / endless.sample_rate)
    warnings.push_back("the figures contain transients of the filters: these take " + readable(needed, "s") +
                       ", and of a motion so short only the first " + readable(discarded, "s") +
                       " are discarded; make motion.duration at least " + readable(2 * needed, "s"));
}

/// The figures that are missing from the report, or wrong in it, with the reason.
std::vector<std::string> warnings_of(const SimulationReport& r, bool exact) {
  std::vector<std::string> warnings;
  warn_of_a_short_motion(r, warnings);
  const bool without_exact =
      std::ranges::any_of(r.simulation.results, [](const std::vector<SimulatedSignal>& row) {
        return std::ranges::any_of(row, [](const SimulatedSignal& s) { return std::isnan(s.sigma_exact); });
      });
  if (exact && without_exact)
    warnings.emplace_back(
        "sigma at the speeds of the motion is not given: an encoder moves by less than a quarter of a count; "
        "`analyze` has it, as sigma in motion");
  if (const OperationalModel& model = r.spec.model; !model.tips && !model.signals.empty()) {
    std::vector<std::string> names;
    for (const Signal& s : model.signals) names.push_back(shown(s.name));
    warnings.push_back("not compared: " + joined(names) + ", as only coordinates of the tip are");
  }
  const auto& positions = r.simulation.results[0];
  if (std::ranges::any_of(positions, [](const SimulatedSignal& s) {
        return std::isinf(s.sigma_ipqn) || std::isinf(s.sigma_ipqn_path);
      }))
    warnings.push_back(
        "Euler angles: the motion passes the gimbal lock (pitch = +-90 deg), where they have no bound; use "
        "rx ry rz");
  return warnings;
}

template <class Number>
void append_number(std::string& text, Number value) {
  std::array<char, 32> buffer;
  const auto end =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value == 0 ? Number(0) : value);
  text.append(buffer.data(), end.ptr);
}

}  // namespace

SimulationReport simulation_report(const Spec& all, const SimulationOptions& options) {
  Spec spec = all;  // what is simulated are coordinates of the tip
  if (const auto removed =
          std::erase_if(spec.filters, [](const NamedFilter& f) { return !f.joints.empty(); }))
    spec.warnings.push_back(counted(removed, "filter") +
                            " of joints or controllers: not simulated; `analyze` has their figures");
  if (!spec.motion)
    throw spec_error(spec, "motion", "the spec has no motion to simulate", "",
                     "add motion: {sample_rate: 1 kHz, duration: 10 s, joints: {...}}");
  if (needs_effort(spec.effects) && !has_masses(spec.model.chain) && !states_any(spec.motion->table.efforts))
    throw spec_error(spec, "effects", "compliance needs a load, which the URDF does not determine",
                     "no <inertial> between base and tip",
                     "give the links their masses, or the motion's file JOINT.effort");
  if (spec.model.tips)
    spec.warnings.emplace_back(
        "of several tips none is compared with the simulation: give the spec one `robot.tip`");
  const EffectReport effects = effects_by_range(spec);
  OperationalModel model = spec.model;
  model.sources = effects.sources;
  SimulationReport report{
      spec, simulate(model, designed_filters(spec), filter_norms(spec), *spec.motion, spec.effects, options),
      options.seed, spec.warnings};
  append(report.warnings, effect_warnings(spec, effects.shares));
  if (states_accuracy(spec))
    report.warnings.emplace_back(
        "the encoders' `accuracy` is not simulated, and not in the theory beside it: the shape of the error "
        "is "
        "not known; an effect such as eccentricity has one");
  append(report.warnings, filter_warnings(spec));
  append(report.warnings, count_rate_warnings(spec));
  append(report.warnings, warnings_of(report, options.exact));
  return report;
}

LogWriter::LogWriter(const Spec& spec)
    : spec_(spec),
      efforts_(has_masses(spec.model.chain) || (spec.motion && states_any(spec.motion->table.efforts))),
      temperatures_(spec.motion && states_any(spec.motion->table.temperatures)) {
  for (const IndependentJoint& joint : spec.model.chain.independent)
    rounded_.push_back(std::ranges::any_of(spec.effects, [&](const Effect& e) {
      return e.joint == joint.name && effect_kind(e.type).stage == Stage::log && e.number("step") > 0;
    }));
  // Without the counts of one encoder, positions are recorded of every joint that it moves.
  const Coupling& coupling = spec.model.transmission.coupling;
  for (bool more = !coupling.is_identity(); more;) {
    more = false;
    for (Eigen::Index j = 0; j < coupling.size(); ++j)
      for (Eigen::Index i = 0; i < coupling.size(); ++i) {
        const auto joint = static_cast<std::size_t>(j), encoder = static_cast<std::size_t>(i);
        if (coupling(j, i) == 0 || !rounded_[encoder] || rounded_[joint]) continue;
        rounded_[joint] = more = true;
      }
  }
}

std::string LogWriter::header() const {
  std::string text = "time [s]";
  for (std::size_t i = 0; i < rounded_.size(); ++i) {
    const IndependentJoint& joint = spec_.model.chain.independent[i];
    const std::string unit = joint.prismatic() ? " [m]" : " [rad]";
    text += ',' + csv_cell(joint.name + (rounded_[i] ? ".measured" + unit : ".counts")) + ',' +
            csv_cell(joint.name + ".reference" + unit);
    if (efforts_) {
      const std::vector<RecordedSignal>& stated = spec_.motion->table.efforts;
      const bool recorded = i < stated.size() && stated[i].values.size() > 0;
      const std::string own = recorded ? stated[i].unit : joint.effort_unit();
      text += ',' + csv_cell(joint.name + ".effort [" + own + ']');
    }
    if (temperatures_) text += ',' + csv_cell(joint.name + ".temperature [K]");
  }
  return text + ",tip.x [m],tip.y [m],tip.z [m]\r\n";
}

std::string_view LogWriter::row(const Reading& r) {
  text_.clear();
  append_number(text_, r.time);
  for (std::size_t i = 0; i < rounded_.size(); ++i) {
    text_ += ',';
    if (rounded_[i])
      append_number(text_, r.logged[i]);
    else
      append_number(text_, static_cast<long long>(r.counts[i]));
    text_ += ',';
    append_number(text_, r.reference[i]);
    if (efforts_) append_number(text_ += ',', r.effort[i]);
    if (temperatures_) append_number(text_ += ',', r.temperature_rise[i]);
  }
  for (Eigen::Index i = 0; i < 3; ++i) {
    text_ += ',';
    append_number(text_, r.tip.translation()[i]);
  }
  text_ += "\r\n";
  return text_;
}

}  // namespace qerr
