#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/text.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "report/diagnosis/parts.hpp"
#include "report/formats.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

std::string verdict_line(const DiagnosisReport& r, const Style& style) {
  const Diagnosis& d = r.diagnosis;
  return painted(verdict_title(d), is_faultless(d) ? Paint::green : Paint::yellow, style) + ": " +
         verdict_words(r) + "\n";
}

std::string probability(double p) { return p < 1e-15 ? "p < 1e-15" : "p = " + significant(p, 2); }

/// The statistics that the model does not explain, most significant first; the JSON has all.
std::string simulation_table(const Diagnosis& d, const Style& style) {
  constexpr std::size_t most = 8;
  constexpr double significance_level = 0.01;
  std::vector<Comparison> list;
  std::ranges::copy_if(d.simulation, std::back_inserter(list),
                       [](const Comparison& c) { return c.p_value < significance_level; });
  std::ranges::stable_sort(list,
                           [](const Comparison& a, const Comparison& b) { return a.p_value < b.p_value; });
  TableRows rows{{"joint", "statistic", "observed", "expected", "p"}};
  for (std::size_t i = 0; i < std::min(list.size(), most); ++i)
    rows.push_back({shown(list[i].joint), list[i].statistic, significant(list[i].observed, 3),
                    significant(list[i].expected, 3),
                    list[i].p_value < 1e-15 ? "< 1e-15" : significant(list[i].p_value, 2)});
  if (list.empty()) return "";
  return heading("Statistics that the simulated model does not reproduce", style) + aligned(rows) +
         (list.size() > most ? "  and " + std::to_string(list.size() - most) + " more (--format json)\n"
                             : "");
}

std::vector<std::string> gain_row(const std::string& label, const Gain& g) {
  const auto in_counts = [](double value) { return std::isfinite(value) ? significant(value, 3) : "-"; };
  return {label,
          readable(g.rms_before, g.unit),
          readable(g.rms_after, g.unit),
          in_counts(g.counts_before),
          in_counts(g.counts_after),
          significant(g.ratio(), 3),
          g.upper > 0 ? significant(g.lower, 3) + " .. " + significant(g.upper, 3) : ""};
}

std::string share_of(double share) {
  return share < 0.01 ? "under 1 %" : std::to_string(std::lround(100 * std::min(share, 1.0))) + " %";
}

std::string causes_table(const DiagnosisReport& r) {
  std::string out;
  for (const Cause& c : r.diagnosis.causes) {
    const double share = c.gain.rms_before > 0 ? std::pow(c.rms / c.gain.rms_before, 2) : 0;
    out += "  " + label(c) + "  " + probability(c.p_value);
    if (share > 0) out += ", " + share_of(share) + " of the joint's residual variance";
    out += '\n';
    TableRows rows;
    for (const ReportedParameter& p : reported_parameters(r.spec, c))
      rows.push_back({p.figure.name + "  " + parameter_size(r.spec, c, p)});
    out += aligned(rows, "    ");
  }
  return out;
}

std::string gain_table(const Diagnosis& d, const Style& style) {
  std::string out = fitted_table(gain_rows(d), style.width) +
                    (d.gain.held_out ? "  after: on held-out blocks of the log\n" : "");
  for (const std::string& line : prediction_lines(d.gain)) out += "  " + line + '\n';
  return out;
}

/// Statistics, intervals, p-values and gains.
std::string details_section(const DiagnosisReport& r, const Style& style) {
  const Diagnosis& d = r.diagnosis;
  std::string out = simulation_table(d, style);
  if (!d.causes.empty()) out += heading("Parameters, with 95 % intervals", style) + causes_table(r);
  if (d.verdict == Verdict::cannot_judge) return out;
  return out + heading(d.causes.empty() ? "Residual" : "Improvement with the extended model", style) +
         gain_table(d, style);
}

/// `0.294 counts (34.4 urad) rms; quantization and the stated noise leave 0.288 counts`.
std::string remainder_line(const std::string& place, const Gain& g) {
  const bool in_counts = std::isfinite(g.counts_after);
  std::string out = place + ": ";
  out += in_counts ? significant(g.counts_after, 3) + " counts (" + readable(g.rms_after, g.unit) + ") rms"
                   : readable(g.rms_after, g.unit) + " rms";
  if (std::isfinite(g.sigma_ratio) && g.sigma_ratio > 0)
    out += "; quantization and the stated noise leave " +
           (in_counts ? significant(g.counts_after / g.sigma_ratio, 3) + " counts"
                      : readable(g.rms_after / g.sigma_ratio, g.unit));
  return out;
}

/// `all joints: the extended model, simulated along the record: 5.5 mrad rms, measured 5.52 mrad`.
std::string reproduction_line(const std::string& place, const Reproduction& check, const std::string& unit) {
  return place + ": the extended model, simulated along the record, errs by " +
         readable(check.rms_simulated, unit) + " rms, the record by " + readable(check.rms_measured, unit) +
         (check.agrees ? ""
                       : ": they differ by more than what the causes leave, and `explained` is not said");
}

/// The faults of the record itself, each with its place and remedy.
std::string data_section(const DiagnosisReport& r, const Style& style) {
  std::string out;
  for (const DataFinding& f : r.diagnosis.data) {
    out += "  " + place_of(f) + ": " + escaped(f.what) + '\n';
    if (!f.remedy.empty()) out += "    remedy: " + escaped(f.remedy) + '\n';
  }
  return out.empty() ? "" : heading("The record itself", style) + out;
}

/// The residual of the extended model, and the shapes in it that no effect has.
std::string remainder_section(const DiagnosisReport& r, const Style& style) {
  const Diagnosis& d = r.diagnosis;
  std::string out;
  for (const std::string& line : remainder_lines(d)) out += "  " + line + '\n';
  for (const Unidentified& u : d.unexplained)
    out += "  " + shown(u.joint) + ": " + shape_words(r.spec, u) + '\n' +
           curve_picture(r.spec, u.joint, u.curve, style);
  return out.empty() ? "" : heading("What remains", style) + out;
}

/// What to inspect or to record for each shape in the residual.
std::string next_section(const DiagnosisReport& r, const Style& style) {
  std::string out;
  for (const std::string& line : advice_lines(r.diagnosis)) out += "  " + line + '\n';
  return out.empty() ? "" : heading("What to do next", style) + out;
}

/// A size for people: `5.49 counts = 400 urad = 1.38 arcmin`.
/// @param unit     rad or m
/// @param encoder  of the counts; null: none
std::string size_text(double value, const std::string& unit, const Encoder* encoder) {
  std::string text = encoder ? significant(value / encoder->resolution, 3) + " counts = " : "";
  text += readable(value, unit);
  return unit == "rad" ? text + " = " + arc_text(value) : text;
}

/// What the words are made of.
struct FoundShape {
  const Spec& spec;
  const Unidentified& found;

  std::string unit() const { return coordinate_unit(spec, found.joint); }
  bool has(const std::string& figure) const { return found.figures.contains(figure); }
  double figure(const std::string& name) const { return found.figures.at(name); }
  std::string size(double value) const { return size_text(value, unit(), encoder_of(spec, found.joint)); }

  /// `prefix` and the figure, "" without it.
  std::string with(const std::string& prefix, const std::string& name) const {
    if (!has(name)) return "";
    return prefix + (figure_unit(spec, found, name) == "rad"
                         ? size_text(figure(name), "rad", nullptr)
                         : readable(figure(name), figure_unit(spec, found, name)));
  }
  std::string of_amplitude(const std::string& prefix) const {
    return found.amplitude > 0 ? prefix + size(found.amplitude) : "";
  }
  std::string of_size() const {
    return has("size") ? " of " + size(std::abs(figure("size"))) : of_amplitude(" of ");
  }
  std::string order_text() const {
    const double order = has("order") ? figure("order") : found.order.value_or(0);
    return significant(order, 4) + (unit() == "m" ? " per metre" : " per revolution of the joint");
  }
};

/// Mains are within 1 % of 50 Hz for 99.5 % of a year (EN 50160), and better at 60 Hz; rectifiers double it.
std::string mains(double frequency) {
  for (const double grid : {50.0, 60.0})
    for (const double multiple : {1.0, 2.0})
      if (std::abs(frequency - multiple * grid) <= 0.01 * multiple * grid)
        return multiple == 1 ? " (mains)" : " (twice mains)";
  return "";
}

std::string step_words(const FoundShape& r) { return "a step" + r.of_size() + r.with(" at ", "time"); }

std::string hysteresis_words(const FoundShape& r) {
  const std::string width = r.has("width") ? " of " + r.size(r.figure("width")) : r.of_amplitude(" of ");
  return "hysteresis" + width + r.with(" over ", "travel") + " after each reversal";
}

std::string exponential_words(const FoundShape& r) {
  return "an exponential after stops" + r.of_amplitude(" of ") + r.with(", time constant ", "time_constant");
}

std::string line_words(const FoundShape& r) {
  const double frequency = r.has("frequency") ? r.figure("frequency") : r.found.frequency.value_or(0);
  return "a line at " + readable(frequency, "Hz") + mains(frequency) + r.of_amplitude(", amplitude ");
}

std::string order_words(const FoundShape& r) {
  return "a sine of order " + r.order_text() + r.of_amplitude(", amplitude ");
}

std::string bump_words(const FoundShape& r) {
  return "a bump" + r.of_size() + r.with(" at ", "angle") + r.with(", width ", "width");
}

std::string count_words(const FoundShape& r) {
  return "an error that repeats every " +
         (r.has("divisor") ? significant(r.figure("divisor"), 4) + " counts" : "few counts") +
         r.of_amplitude(", amplitude ");
}

std::string noise_words(const FoundShape& r) { return "scatter from row to row" + r.of_amplitude(" of "); }

std::string unknown_words(const FoundShape& r) {
  std::string text = escaped(r.found.what);
  if (r.found.order && *r.found.order > 0) text += ", order " + r.order_text();
  if (r.found.frequency) text += ", " + readable(*r.found.frequency, "Hz");
  if (r.has("rate")) text += " by " + r.size(r.figure("rate")) + " per second";
  return text + r.of_amplitude(", amplitude ");
}

struct ShapeRow {
  Shape shape;
  std::string (*words)(const FoundShape&);
  std::string_view next;  ///< what to inspect or to record
};

constexpr std::array<ShapeRow, 9> shape_rows{{
    {Shape::step, step_words, "look for a slip, a collision or a restart at that time, and record again"},
    {Shape::hysteresis, hysteresis_words,
     "record slow reversals with two loads: friction with a soft drive grows with the load, play does not"},
    {Shape::exponential, exponential_words,
     "record stops of five time constants or more, from two speeds, and the controller's command"},
    {Shape::line, line_words,
     "record with the drives off, then on and at rest: what remains is electrical or comes through the "
     "floor"},
    {Shape::order, order_words,
     "compare the order with the teeth, shafts and bearings of the drive; record at another speed"},
    {Shape::bump, bump_words,
     "inspect scale, track or teeth at that angle; record a second passage in either direction"},
    {Shape::by_count, count_words,
     "record one slow revolution, and inspect offset, gain and phase of the encoder's signals"},
    {Shape::noise, noise_words, "record at rest with the drives off, then on: the difference is theirs"},
    {Shape::unknown, unknown_words,
     "record load and temperature too, with reversals at two speeds and a rest after each"},
}};

const ShapeRow& row_of(Shape shape) {
  for (const ShapeRow& row : shape_rows)
    if (row.shape == shape) return row;
  return shape_rows.back();
}

/// What to inspect or to record to find the cause of a shape.
std::string shape_advice(Shape shape) { return std::string(row_of(shape).next); }

constexpr double degree = std::numbers::pi / 180;

struct AxisUnit {
  double factor = 1;  ///< of the unit shown, in SI units
  std::string name;
};

double largest(const std::vector<double>& values) {
  double most = 0;
  for (const double value : values)
    if (std::isfinite(value)) most = std::max(most, std::abs(value));
  return most;
}

AxisUnit axis_unit(const std::vector<double>& values, const std::string& unit) {
  if (unit == "rad") return {degree, "deg"};
  if (unit == "rad/s") return {degree, "deg/s"};
  if (unit.empty() || unit.starts_with("count")) return {1, unit};
  const PrefixedUnit prefix = prefixed(largest(values), unit);
  return {prefix.factor, prefix.unit};
}

std::vector<double> divided(std::vector<double> values, double factor) {
  for (double& value : values) value /= factor;
  return values;
}

}  // namespace

namespace {

/// The turns that were removed from a column of a log, in words.
std::string turns_words(const Wraps& w, bool has_time) {
  const std::string start = std::to_string(w.start);
  if (has_time) return counted(w.count, "full turn") + (w.start ? ", " + start + " at the start" : "");
  if (w.count == 0) return start + " in all rows";
  return "whole turns in " + counted(w.count, "row") + (w.start ? ", " + start + " in the others" : "");
}

}  // namespace

std::string record_words(const Log& log) {
  std::string out = "'" + escaped(log.file) + "': " + counted(log.rows, "row");
  if (log.has_time()) out += " over " + significant(log.last_time - log.first_time, 4) + " s";
  for (const LogColumn& c : log.columns)
    if (c.wraps.count > 0 || c.wraps.start != 0)
      out += "\n  unwrapped: " + escaped(c.header) + ", " + turns_words(c.wraps, log.has_time());
  return out;
}

std::string to_table(const DiagnosisReport& r, const Style& style) {
  std::string out = painted("qerr diagnose", Paint::bold, style) + "  robot '" +
                    escaped(r.spec.robot_name, 60) + "', " + record_words(r.log) + "\n\n" +
                    verdict_line(r, style);
  out += data_section(r, style) + causes_section(r, style) + remainder_section(r, style) +
         next_section(r, style) + visible_section(r, style);
  if (style.details) out += details_section(r, style);
  if (!r.extended_model.empty()) out += "\nExtended model: " + escaped(r.extended_model) + '\n';
  return within(out, style.width);
}

std::string parameter_size(const Spec& spec, const Cause& cause, const ReportedParameter& p) {
  std::string text = with_interval(p);
  const Encoder* encoder = encoder_of(spec, cause.effect.joint);
  if (!encoder) return text;
  for (const Parameter& row : effect_kind(cause.effect.type).parameters)
    if (row.name == p.figure.name && row.coordinate)
      text += " = " + significant(p.figure.value / encoder->resolution, 3) + " counts";
  return text;
}

/// The joints with a cause, or the tip, and the gain of each.
std::vector<std::pair<std::string, Gain>> gains_by_place(const Diagnosis& d) {
  std::vector<std::pair<std::string, Gain>> all;
  for (const Cause& c : d.causes)
    if (std::ranges::none_of(all, [&](const auto& known) { return known.first == place_of(c); }))
      all.emplace_back(place_of(c), c.gain);
  return all;
}

std::string whole_place(const Diagnosis& d) { return d.gain.of_tip ? "the tip" : "all joints"; }

TableRows gain_rows(const Diagnosis& d) {
  TableRows rows{{"residual, rms", "before", "after", "counts before", "after", "ratio", "95 %"}};
  for (const auto& [place, gain] : gains_by_place(d)) rows.push_back(gain_row(place, gain));
  // The total of a single place would repeat its row.
  if (rows.size() != 2 || d.causes.front().gain.rms_before != d.gain.rms_before)
    rows.push_back(gain_row(whole_place(d), d.gain));
  return rows;
}

std::vector<std::string> prediction_lines(const Gain& g) {
  std::vector<std::string> out;
  if (std::isfinite(g.coverage))
    out.push_back(percent(g.coverage) + " of the readings are in the extended model's central 95 % interval");
  if (std::isfinite(g.log_score))
    out.push_back("log-likelihood per reading: " + significant(g.log_score, 3) +
                  " more than without the causes");
  return out;
}

std::vector<std::string> remainder_lines(const Diagnosis& d) {
  if (d.verdict == Verdict::cannot_judge) return {};
  std::vector<std::string> out;
  for (const auto& [place, gain] : gains_by_place(d)) out.push_back(remainder_line(place, gain));
  if (out.empty() && d.gain.rms_after > 0) out.push_back(remainder_line(whole_place(d), d.gain));
  const bool of_joints = std::ranges::any_of(d.causes, [](const Cause& c) { return !c.gain.of_tip; });
  if (d.check && of_joints)
    out.push_back(reproduction_line("all joints", *d.check, d.gain.of_tip ? "rad" : d.gain.unit));
  if (d.tip_check) out.push_back(reproduction_line("the tip", *d.tip_check, "m"));
  return out;
}

std::string place_of(const DataFinding& f) {
  std::vector<std::string> parts;
  if (!f.joint.empty()) parts.push_back(shown(f.joint));
  if (f.row) parts.push_back("row " + std::to_string(*f.row));
  if (f.time) parts.push_back(significant(*f.time, 6) + " s");
  return parts.empty() ? "the whole record" : joined(parts);
}

std::vector<std::string> advice_lines(const Diagnosis& d) {
  std::vector<std::string> out;
  std::vector<std::string> seen;
  for (const Unidentified& u : d.unexplained) {
    // What is wrong with the record itself comes with a remedy of its own.
    if (u.shape == Shape::unknown &&
        std::ranges::any_of(d.data, [&](const DataFinding& f) { return f.joint == u.joint; }))
      continue;
    const std::string advice = u.next.empty() ? shape_advice(u.shape) : u.next;
    if (add_once(seen, advice)) out.push_back(shown(u.joint) + ": " + advice);
  }
  return out;
}

std::string shape_words(const Spec& spec, const Unidentified& u) { return row_of(u.shape).words({spec, u}); }

std::string arc_text(double angle) {
  const double size = std::abs(angle) / degree;
  if (size >= 1) return significant(angle / degree, 3) + " deg";
  if (size >= 1.0 / 60) return significant(angle / degree * 60, 3) + " arcmin";
  return significant(angle / degree * 3600, 3) + " arcsec";
}

std::string curve_picture(const Spec& spec, const std::string& joint, const ResidualCurve& curve,
                          const Style& style) {
  if (curve.at.empty()) return "";
  const Encoder* encoder = encoder_of(spec, joint);
  std::vector<double> values = curve.residual;
  values.insert(values.end(), curve.fit.begin(), curve.fit.end());
  const PrefixedUnit prefix = prefixed(largest(values), coordinate_unit(spec, joint));
  const AxisUnit x = axis_unit(curve.at, curve.unit);
  const AxisUnit y = encoder ? AxisUnit{encoder->resolution, "counts"} : AxisUnit{prefix.factor, prefix.unit};
  return text_picture({divided(curve.at, x.factor), divided(curve.residual, y.factor),
                       divided(curve.fit, y.factor), curve.fit.empty() ? "residual" : "residual without this",
                       "fit", y.name, curve.against + (x.name.empty() ? "" : " [" + x.name + "]")},
                      style);
}

}  // namespace qerr
