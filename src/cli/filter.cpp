#include <algorithm>
#include <cmath>

#include "cli/shared.hpp"
#include "core/lists.hpp"
#include "qerr/report/filter_report.hpp"
namespace qerr::cli {

namespace {

double frequency(const std::string& text, const std::string& option) {
  std::string why = "must be a frequency above 0";
  const auto quantity = parse_quantity(text, why);
  const bool good = quantity && quantity->value > 0 &&
                    quantity->dimension.value_or(dimension::frequency) == dimension::frequency;
  if (!good)
    throw usage(option, why.empty() ? "must be a frequency above 0" : why, "'" + text + "'", "e.g. 5Hz");
  return quantity->value;
}

/// A speed or an amplitude: counts (per sample) without a unit, else in the joint's unit.
MotionQuestion motion(const std::string& text, const std::string& option, bool sine) {
  std::string why;
  const auto q = parse_quantity(text, why);
  const Dimension angle = sine ? dimension::angle : dimension::angular_speed;
  const Dimension length = sine ? dimension::length : dimension::speed;
  if (!q || (q->dimension && *q->dimension != angle && *q->dimension != length) ||
      !(std::abs(q->value) < 1e12) || (sine && !(q->value > 0)))
    throw usage(option, why.empty() ? (sine ? "must be an amplitude above 0" : "must be a speed") : why,
                "'" + text + "'",
                sine ? "counts such as 40, or 15deg" : "counts per sample such as 0.3, or 2rad/s");
  return {sine, q->value, 0, !q->dimension, q->dimension == length};
}

FilterQuestions questions(const Values& v) {
  FilterQuestions q;
  for (const std::string& text : v.texts("at")) q.frequencies.push_back(frequency(text, "--at"));
  if (const auto& band = v.texts("motion-band"); !band.empty())
    q.motion_band = {frequency(band[0], "--motion-band"), frequency(band[1], "--motion-band")};
  if (q.motion_band && q.motion_band->first >= q.motion_band->second)
    throw usage("--motion-band", "the first frequency must lie below the second", "",
                "e.g. --motion-band 0.5Hz 5Hz");
  for (const std::string& text : v.texts("speed")) q.motions.push_back(motion(text, "--speed", false));
  if (const auto& sine = v.texts("sine"); !sine.empty()) {
    q.motions.push_back(motion(sine[0], "--sine", true));
    q.motions.back().frequency = frequency(sine[1], "--sine");
  }
  q.noise = v.given("noise");
  q.coefficients = v.given("coefficients");
  q.estimators = v.given("estimators");
  if (v.given("clock")) {
    q.clock = frequency(v.text("clock"), "--clock");
    if (*q.clock < 1e-3 || *q.clock > 1e15)
      throw usage("--clock", "must lie between 1 mHz and 1e15 Hz", "'" + v.text("clock") + "'", "e.g. 1MHz");
  }
  return q;
}

/// Refuses a speed or an amplitude of which no encoder is of the kind: the answer would be an empty table.
void require_joints(const Spec& spec, const std::vector<MotionQuestion>& motions) {
  for (const MotionQuestion& m : motions) {
    const auto& joints = spec.model.chain.independent;
    if (m.in_counts || std::ranges::any_of(joints, [&](const IndependentJoint& joint) {
          return joint.prismatic() == m.length;
        }))
      continue;
    throw usage(m.sine ? "--sine" : "--speed", "is of a joint that the robot does not have",
                "a " + std::string(m.length ? "length" : "angle") + " for joints that all " +
                    (m.length ? "turn" : "slide"),
                "give counts, which have no unit, or " + std::string(m.length ? "an angle" : "a length"));
  }
}

struct Code {
  const CodeLanguage* language = nullptr;  ///< null: none is asked for
  std::unique_ptr<OutputFile> file;
};

/// The language and the file of --write-code, opened.
Code code(const Values& v) {
  const auto& words = v.texts("write-code");
  if (words.empty()) return {};
  if (const CodeLanguage* const l = find_named(code_languages(), words[0]))
    return {l, std::make_unique<OutputFile>(words[1], "--write-code")};
  throw usage("--write-code", "unknown language", "'" + words[0] + "'",
              "use one of " + qerr::joined(names_of(code_languages())));
}

int run_filter(const Values& v) {
  const FilterQuestions asked = questions(v);
  const Spec spec =
      load(v.text("SPEC"), v, {"configurations", "requirements", "threshold", "sweep", "design"},
           [&](const Spec& s) { return write(filter_report(s, asked), "json"); });
  require_joints(spec, asked.motions);
  if (spec.filters.empty())
    throw Error({spec.file, 1, 1}, "filters", "the spec has no filters", "",
                "add filters: {velocity: {derivative: 1, ...}}");
  const Code written = code(v);
  const bool alone =
      written.language && v.texts("write-code")[1] == "-" && !v.given("output") && !v.given("format");
  const auto out = alone ? nullptr : opened(v, "output");
  const auto response = opened(v, "response"), transient = opened(v, "transient"),
             impulse = opened(v, "impulse");
  const FilterReport report = filter_report(spec, asked);
  Outputs outputs;
  if (response) outputs.write([&] { finish(*response, response_csv(report)); });
  if (transient) outputs.write([&] { finish(*transient, transient_csv(spec)); });
  if (impulse) outputs.write([&] { finish(*impulse, impulse_csv(report)); });
  if (written.language) outputs.write([&] { finish(*written.file, written.language->write(report)); });
  if (out) outputs.write([&] { finish(*out, report, v); });
  warn(report.warnings, v);
  outputs.finish();
  return 0;
}

}  // namespace

Command filter_command() {
  return {
      "filter",
      "Every filter: norms, delay, bandwidth, settling, fidelity, responses",
      joined(
          {spec_options(),
           {valued("--at", "F[,F...]", "gain, phase and tracking error at these frequencies",
                   OptionKind::list),
            valued("--motion-band", "FROM TO", "tracking error for motion between two frequencies",
                   OptionKind::pair),
            valued("--response", "FILE.csv", "write the frequency response as CSV"),
            valued("--impulse", "FILE.csv", "write the impulse response as CSV"),
            valued("--transient", "FILE.csv", "write the noise after switching on as CSV"),
            flag("--noise", "speed above which IPQN is accurate, and rise time of the noise"),
            valued("--speed", "V[,V...]",
                   "noise of every encoder at constant speeds: counts per sample, or with a unit",
                   OptionKind::list),
            valued("--sine", "AMPLITUDE FREQUENCY",
                   "noise of every encoder along a sine: amplitude in counts, or with a unit",
                   OptionKind::pair),
            flag("--coefficients", "show the sections or taps"),
            valued("--write-code", "c|python|ros FILE",
                   "write the filters as code: coefficients, a step function, norms and the rounding error",
                   OptionKind::pair),
            flag("--estimators",
                 "velocity by finite differences compared with the time between edges, per encoder"),
            valued("--clock", "F",
                   "clock of the time between edges (default: that of the spec's estimators, else the sample "
                   "rate)")
                .with("--estimators")},
           output_options()}),
      run_filter,
      {{"qerr filter arm.yaml", "noise, delay and bandwidth of every filter of the spec"},
       {"qerr filter arm.yaml --motion-band 0.5Hz 5Hz",
        "and how well it tracks motion between two frequencies"},
       {"qerr filter arm.yaml --noise --speed 2rad/s",
        "its noise at a speed, and from which speed on IPQN is accurate"},
       {"qerr filter arm.yaml --write-code c filters.h", "the filters as C code for the controller"},
       {"qerr filter arm.yaml --estimators --clock 1MHz", "counts per time compared with time per count"}},
      {"filters"}};
}

}  // namespace qerr::cli
