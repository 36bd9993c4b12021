#include <cmath>
#include <memory>

#include "cli/command.hpp"
#include "core/output_file.hpp"
#include "qerr/report/filter_report.hpp"

namespace qerr::cli {

namespace {

struct Arguments {
  std::string spec;
  std::vector<std::string> frequencies;
  std::vector<std::string> motion_band;
  std::string response;
  std::string impulse;
  bool coefficients = false;
  bool noise = false;
  bool estimators = false;
  std::string clock;
  std::vector<std::string> speeds;
  std::vector<std::string> sine;
  std::string transient;
};

double frequency(const std::string& text, const std::string& option) {
  std::string why = "must be a frequency above 0";
  const auto quantity = parse_quantity(text, why);
  const bool good = quantity && quantity->value > 0 &&
                    quantity->dimension.value_or(dimension::frequency) == dimension::frequency;
  if (!good)
    throw Error(
        {{"", 0, 0}, option, why.empty() ? "must be a frequency above 0" : why, "'" + text + "'", "e.g. 5Hz"},
        Trouble::usage);
  return quantity->value;
}

/// A speed or an amplitude: counts (per sample) without a unit, else in the joint's unit.
MotionQuestion motion(const std::string& text, const std::string& option, bool sine) {
  std::string why;
  const auto q = parse_quantity(text, why);
  const Dimension angle = sine ? dimension::angle : dimension::angular_speed;
  const Dimension length = sine ? dimension::length : dimension::speed;
  if (!q || (q->dimension && *q->dimension != angle && *q->dimension != length) ||
      !(std::abs(q->value) < 1e12))
    throw Error({{"", 0, 0},
                 option,
                 why.empty() ? (sine ? "must be an amplitude" : "must be a speed") : why,
                 "'" + text + "'",
                 sine ? "counts such as 40, or 15deg" : "counts per sample such as 0.3, or 2rad/s"},
                Trouble::usage);
  return {sine, q->value, 0, !q->dimension, q->dimension == length};
}

FilterQuestions questions(const Arguments& a) {
  FilterQuestions q;
  for (const std::string& text : a.frequencies) q.frequencies.push_back(frequency(text, "--at"));
  if (!a.motion_band.empty())
    q.motion_band = {frequency(a.motion_band[0], "--motion-band"),
                     frequency(a.motion_band[1], "--motion-band")};
  if (q.motion_band && q.motion_band->first >= q.motion_band->second)
    throw Error({{"", 0, 0},
                 "--motion-band",
                 "the first frequency must lie below the second",
                 "",
                 "e.g. --motion-band 0.5Hz 5Hz"},
                Trouble::usage);
  for (const std::string& text : a.speeds) q.motions.push_back(motion(text, "--speed", false));
  if (!a.sine.empty()) {
    q.motions.push_back(motion(a.sine[0], "--sine", true));
    q.motions.back().frequency = frequency(a.sine[1], "--sine");
  }
  q.noise = a.noise;
  q.coefficients = a.coefficients;
  q.estimators = a.estimators;
  if (!a.clock.empty()) {
    q.clock = frequency(a.clock, "--clock");
    if (*q.clock < 1e-3 || *q.clock > 1e15)
      throw Error(
          {{"", 0, 0}, "--clock", "must lie between 1 mHz and 1e15 Hz", "'" + a.clock + "'", "e.g. 1MHz"},
          Trouble::usage);
  }
  return q;
}

void write_file(const std::string& path, const std::string& text) {
  OutputFile file(path);
  file.write(text);
  file.close();
}

int run(const Arguments& a, const Options& o) {
  const FilterQuestions asked = questions(a);
  const Spec spec = load(a.spec, o);
  if (spec.filters.empty())
    throw Error(Fault{{spec.file, 1, 1},
                      "filters",
                      "the spec has no filters",
                      "",
                      "add filters: {velocity: {derivative: 1, ...}}"});
  const FilterReport report = filter_report(spec, asked);
  if (!a.response.empty()) write_file(a.response, response_csv(report));
  if (!a.transient.empty()) write_file(a.transient, transient_csv(spec));
  if (!a.impulse.empty()) write_file(a.impulse, impulse_csv(report));
  write_file(o.output, write(report, chosen_format(o), style(o)));
  std::vector<std::string> warnings = spec.warnings;
  for (std::string& warning : filter_warnings(spec)) warnings.push_back(std::move(warning));
  warn(warnings, o);
  return 0;
}

}  // namespace

std::function<int()> declare_filter(CLI::App& app, Options& o) {
  auto a = std::make_shared<Arguments>();
  app.add_option("SPEC", a->spec, "the spec (YAML); '-' reads standard input")->required();
  app.add_option("--at", a->frequencies, "gain, phase and tracking error at these frequencies")
      ->type_name("F[,F...]")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->take_all();
  app.add_option("--motion-band", a->motion_band, "tracking error for motion between two frequencies")
      ->type_name("FROM TO")
      ->expected(2);
  app.add_option("--response", a->response, "write the frequency response as CSV")->type_name("FILE.csv");
  app.add_option("--impulse", a->impulse, "write the impulse response as CSV")->type_name("FILE.csv");
  app.add_option("--transient", a->transient, "write the noise after switching on as CSV")
      ->type_name("FILE.csv");
  app.add_flag("--noise", a->noise,
               "from which speed on IPQN can be believed, and when the noise has built up");
  app.add_option("--speed", a->speeds,
                 "noise of every encoder at constant speeds: counts per sample, or with a unit")
      ->type_name("V[,V...]")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->take_all();
  app.add_option("--sine", a->sine,
                 "noise of every encoder along a sine: counts, or with a unit, and its frequency")
      ->type_name("AMPLITUDE FREQUENCY")
      ->expected(2);
  app.add_flag("--coefficients", a->coefficients, "show the realised sections");
  auto* estimators =
      app.add_flag("--estimators", a->estimators,
                   "velocity by finite differences against the time between edges, per encoder");
  app.add_option("--clock", a->clock, "of the time between edges; default: the sample rate")
      ->type_name("F")
      ->needs(estimators);
  add_spec_options(app, o);
  add_output_options(app, o);
  return [=, &o] { return run(*a, o); };
}

}  // namespace qerr::cli
