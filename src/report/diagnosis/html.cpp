#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/statistics.hpp"
#include "core/text.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "report/analysis/figures.hpp"
#include "report/analysis/tables.hpp"
#include "report/diagnosis/parts.hpp"
#include "report/formats.hpp"
#include "report/page/page.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

using Points = ResidualPicture::Points;

/// Least and largest residual over time, or over the row if the record has no order.
void draw_in_time(const JointResidual& r, std::size_t intervals, ResidualPicture& p) {
  const Evidence& e = r.evidence;
  const Eigen::Index last = e.rows() - 1;
  page::Envelope before(e.time[0], e.time[last], intervals), after = before;
  for (Eigen::Index k = 0; k <= last; ++k) before.add(e.time[k], r.before[k]);
  for (Eigen::Index k = 0; p.corrected && k <= last; ++k) after.add(e.time[k], r.after[k]);
  p.before = before.points();
  if (p.corrected) p.after = after.points();
}

/// IntervalMeans in equal intervals.
class IntervalMeans {
 public:
  IntervalMeans(double from, double to, std::size_t intervals)
      : from_(from),
        per_unit_(static_cast<double>(intervals) / (to - from)),
        sums_(intervals),
        counts_(intervals) {}

  void add(double x, double y) {
    const auto i = std::min(sums_.size() - 1, static_cast<std::size_t>((x - from_) * per_unit_));
    sums_[i] += y, counts_[i] += 1;
  }
  Points points() const {
    Points all;
    for (std::size_t i = 0; i < sums_.size(); ++i)
      if (counts_[i] > 0)
        all.emplace_back(from_ + (static_cast<double>(i) + 0.5) / per_unit_, sums_[i] / counts_[i]);
    return all;
  }

 private:
  double from_, per_unit_;
  std::vector<double> sums_, counts_;
};

void draw_by_position(const JointResidual& r, std::size_t intervals, ResidualPicture& p) {
  const Evidence& e = r.evidence;
  const double from = e.reference.minCoeff(), to = e.reference.maxCoeff();
  if (!(to > from)) return;
  const page::Envelope none(from, to, intervals);
  std::array before{none, none, none}, after = before;
  const IntervalMeans no_rows(from, to, intervals);
  std::array mean{no_rows, no_rows, no_rows}, fit = mean;
  for (Eigen::Index k = 0; k < e.rows(); ++k) {
    const double direction = e.direction.size() > 0 ? e.direction[k] : 0;
    const std::size_t side = direction > 0 ? 0 : direction < 0 ? 1 : 2;
    before[side].add(e.reference[k], r.before[k]);
    mean[side].add(e.reference[k], r.before[k]);
    if (!p.corrected) continue;
    after[side].add(e.reference[k], r.after[k]);
    fit[side].add(e.reference[k], r.before[k] - r.after[k]);
  }
  for (std::size_t side = 0; side < p.sides.size(); ++side)
    p.sides[side] = {before[side].points(), after[side].points(), fit[side].points(), mean[side].points()};
}

void draw_by_count(const JointResidual& r, ResidualPicture& p) {
  const Evidence& e = r.evidence;
  if (e.measured.maxCoeff() - e.measured.minCoeff() < count_cycle * p.resolution) return;
  std::array<double, count_cycle> before{}, after{}, readings{};
  for (Eigen::Index k = 0; k < e.rows(); ++k) {
    const double count = std::round(e.measured[k] / p.resolution);
    const auto i = static_cast<std::size_t>(count - count_cycle * std::floor(count / count_cycle));
    before[i] += r.before[k], after[i] += r.after[k], readings[i] += 1;
  }
  for (std::size_t i = 0; i < count_cycle; ++i) {
    if (readings[i] == 0) continue;
    p.by_count_before.emplace_back(i, before[i] / readings[i]);
    if (p.corrected) p.by_count_after.emplace_back(i, after[i] / readings[i]);
  }
}

/// The largest amplitude in each of equal intervals of the order's logarithm.
Points peaks(const std::vector<double>& order, const std::vector<double>& amplitude, std::size_t intervals) {
  const double from = std::log(order.front()),
               width = (std::log(order.back()) - from) / static_cast<double>(intervals);
  Points all;
  double end = -INFINITY;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (std::log(order[i]) >= end) {
      end = from + width * (std::floor((std::log(order[i]) - from) / width) + 1);
      all.emplace_back(order[i], amplitude[i]);
    } else if (amplitude[i] > all.back().second) {
      all.back() = {order[i], amplitude[i]};
    }
  }
  return all;
}

void draw_spectrum(const JointResidual& r, std::size_t intervals, ResidualPicture& p) {
  const PositionSpectrum s = position_spectrum(r);
  if (s.order.empty()) return;
  p.spectrum_before = peaks(s.order, s.before, 2 * intervals);
  if (p.corrected) p.spectrum_after = peaks(s.order, s.after, 2 * intervals);
  // Nothing can be read from amplitudes far below the largest one.
  double largest = 0;
  for (const auto& [order, amplitude] : p.spectrum_before) largest = std::max(largest, amplitude);
  for (Points* points : {&p.spectrum_before, &p.spectrum_after})
    std::erase_if(*points, [&](const auto& point) { return point.second < 1e-4 * largest; });
  p.revolution = s.order.front() / s.encoder_order.front();
}

struct Curve {
  std::string name;
  const ResidualPicture::Points* points;
  bool dots = false;
};

page::Plot residual_plot(const ResidualPicture& p, const std::string& title, const std::string& description,
                         const page::AxisRange& x, const std::vector<Curve>& curves) {
  page::Plot plot{page::isolated_runs(title), description, x, {"measured - reference", p.unit}, {}};
  for (const auto& [name, points, dots] : curves)
    if (!points->empty()) {
      plot.series.push_back({name, *points});
      plot.series.back().dots = dots;
    }
  return plot;
}

std::string of_joint(const ResidualPicture& p) { return " of " + shown(p.joint); }

std::string time_figure(const ResidualPicture& p) {
  if (p.before.empty()) return "";
  const page::AxisRange x =
      p.in_time ? page::time_axis(p.before.back().first) : page::AxisRange{"row", "", false, false};
  return figure(
      residual_plot(p, "Residual" + of_joint(p) + (p.in_time ? " in time" : " by row"),
                    "Smallest and largest residual in each interval, before and after subtraction of "
                    "the causes.",
                    x, {{"before", &p.before}, {"after", &p.after}}));
}

page::AxisRange position_axis(const ResidualPicture& p) {
  return {p.prismatic ? "position" : "angle", p.unit, false, p.prismatic};
}

/// By direction of motion. Rows before the first motion have none: they are drawn only where all rows are so.
std::string position_figures(const ResidualPicture& p) {
  constexpr std::array<const char*, 3> directions{"forward", "backward", ""};
  const bool sided = !p.sides[0].before.empty() || !p.sides[1].before.empty();
  std::string out;
  for (std::size_t i = 0; i < p.sides.size(); ++i) {
    const ResidualPicture::Side& side = p.sides[i];
    if (side.before.empty() || (sided && i == 2)) continue;
    const std::string way = sided ? std::string(", ") + directions[i] : "";
    out += figure(residual_plot(
        p, "Residual" + of_joint(p) + " by position" + way,
        "Smallest and largest residual in each interval of the position as points, their mean, and "
        "the mean of what the causes contribute.",
        position_axis(p), {{"before", &side.before, true}, {"mean before", &side.mean}, {"fit", &side.fit}}));
  }
  const page::Plot after = residual_plot(
      p, "Residual" + of_joint(p) + " by position, after", "The same after subtraction of the causes.",
      position_axis(p),
      sided ? std::vector<Curve>{{"forward", &p.sides[0].after, true}, {"backward", &p.sides[1].after, true}}
            : std::vector<Curve>{{"after", &p.sides[2].after, true}});
  return out + (after.series.empty() ? "" : figure(after));
}

std::string count_figure(const ResidualPicture& p) {
  if (p.by_count_before.empty()) return "";
  const std::string cycle = std::to_string(count_cycle);
  return figure(
      residual_plot(p, "Residual" + of_joint(p) + " by count",
                    "Mean residual of the readings with the same remainder of the count by " + cycle + ".",
                    {"count modulo " + cycle, "", false, false},
                    {{"before", &p.by_count_before}, {"after", &p.by_count_after}}));
}

std::string spectrum_figure(const ResidualPicture& p) {
  if (p.spectrum_before.empty()) return "";
  page::Plot plot =
      residual_plot(p, "Orders in the residual" + of_joint(p),
                    "Amplitude of each order of the position; the largest in each interval.",
                    {p.prismatic ? "periods per metre" : "periods per revolution of the joint", "", true},
                    {{"before", &p.spectrum_before}, {"after", &p.spectrum_after}});
  plot.y.label = "amplitude", plot.y.logarithmic = true;
  const double last = p.spectrum_before.back().first;
  if (p.spectrum_before.front().first < p.revolution && p.revolution < last)
    plot.markers.push_back({"one per revolution of the encoder", p.revolution});
  return figure(plot);
}

std::string summary(const ResidualPicture& p) {
  const auto size = [&](double rms) {
    return significant(rms / p.resolution, 3) + " counts (" + readable(rms, p.unit) + ")";
  };
  return shown(p.joint) + ": " + size(p.rms_before) + " rms as recorded" +
         (p.corrected ? ", " + size(p.rms_after) + " after subtraction of the causes"
                      : "; no cause to subtract") +
         ". One count is " + readable(p.resolution, p.unit) + ".";
}

/// Joints by the residual in counts, those with a cause first.
void sort_by_interest(std::vector<ResidualPicture>& all) {
  std::ranges::stable_sort(all, [](const ResidualPicture& a, const ResidualPicture& b) {
    if (a.corrected != b.corrected) return a.corrected;
    return a.rms_before / a.resolution > b.rms_before / b.resolution;
  });
}

struct Extent {
  std::size_t joints, intervals;
};

/// @param corrected  of the encoders, which are drawn first and have more lines
Extent extent(std::size_t bytes, std::size_t encoders, std::size_t corrected) {
  constexpr std::size_t fewest = 40, most = 320, per_point = 36;
  // Axes and legends of six figures or five, and the means by count; points of all lines in an interval.
  const auto fixed = [](bool with_fit) -> std::size_t { return with_fit ? 18000 : 13000; };
  const auto per_interval = [](bool with_fit) -> std::size_t { return per_point * (with_fit ? 20 : 10); };
  for (std::size_t joints = encoders;; --joints) {
    std::size_t needed = 0, of_intervals = 0;
    for (std::size_t i = 0; i < joints; ++i)
      needed += fixed(i < corrected), of_intervals += per_interval(i < corrected);
    if (joints > 1 && needed + fewest * of_intervals > bytes) continue;
    const std::size_t left = bytes > needed ? bytes - needed : 0;
    return {joints, std::clamp(left / of_intervals, fewest, most)};
  }
}

std::size_t joints_with_a_cause(const DiagnosisReport& r) {
  const auto& joints = r.spec.model.chain.independent;
  return std::ranges::count_if(joints, [&](const IndependentJoint& joint) {
    return std::ranges::any_of(r.diagnosis.causes,
                               [&](const Cause& c) { return c.effect.joint == joint.name; });
  });
}

/// Measured - reference of each joint before and after subtraction of the causes.
/// @param bytes  that it may take, about: joints beyond are named, but not drawn
std::string residuals_part(const DiagnosisReport& r, std::size_t bytes) {
  const std::size_t encoders = r.spec.model.transmission.encoders.size();
  if (encoders == 0 || r.log.values.size() == 0) return "";
  const Extent drawn = extent(bytes, encoders, joints_with_a_cause(r));
  std::vector<ResidualPicture> all(encoders);
  for_each_residual(r, [&](const JointResidual& residual) {
    all[residual.evidence.number] = residual_picture(residual, drawn.intervals);
  });
  std::erase_if(all, [](const ResidualPicture& p) { return p.rows == 0; });
  if (all.empty()) return "";
  sort_by_interest(all);
  std::string out = page::paragraph(
      "Of a long record, the smallest and the largest value of each interval of the abscissa are drawn: "
      "joined "
      "in time, as points by position. Residuals are those of the log as it was recorded.");
  if (all.size() > drawn.joints) {
    std::vector<std::string> left;
    for (std::size_t i = drawn.joints; i < all.size(); ++i) left.push_back(summary(all[i]));
    out += page::paragraph("Drawn: " + counted(drawn.joints, "joint") +
                           " with the largest residuals, those with a cause first. The others:") +
           page::list(left);
    all.resize(drawn.joints);
  }
  std::vector<std::pair<std::string, std::string>> figures;
  for (const ResidualPicture& p : all)
    figures.emplace_back(shown(p.joint), page::paragraph(summary(p)) +
                                             page::side_by_side(time_figure(p) + position_figures(p) +
                                                                count_figure(p) + spectrum_figure(p)));
  return out + page::choice("Joint", figures);
}

std::string probability_text(double p) { return p < 1e-15 ? "< 1e-15" : significant(p, 2); }

/// The curve with the fit, if it has one; "" without a curve.
/// @param joint  or coordinate of the tip
/// @param marks  the residual as marks, else as a line
std::string curve_figure(const Spec& spec, const std::string& title, const std::string& joint,
                         const ResidualCurve& curve, bool marks) {
  if (curve.at.empty()) return "";
  const std::string unit = curve.unit.starts_with("count") || curve.unit == "1" ? "" : curve.unit;
  page::Plot plot{
      page::isolated_runs(title),
      curve.fit.empty()
          ? "Mean residual in bins of the abscissa."
          : "Mean residual without this cause in bins of the abscissa, and the fitted contribution.",
      {curve.against + (unit.empty() && !curve.unit.empty() ? " [" + curve.unit + "]" : ""), unit, false,
       unit == "s" ? page::time_axis(curve.at.back()).prefix : !unit.starts_with("rad")},
      {"residual", coordinate_unit(spec, joint)},
      {}};
  page::Series residual{curve.fit.empty() ? "residual" : "residual without this", {}, marks, !marks};
  page::Series fit{"fit", {}};
  for (std::size_t i = 0; i < curve.at.size(); ++i) {
    residual.points.emplace_back(curve.at[i], curve.residual[i]);
    if (!curve.fit.empty()) fit.points.emplace_back(curve.at[i], curve.fit[i]);
  }
  plot.series.push_back(residual);
  if (!curve.fit.empty()) plot.series.push_back(fit);
  return figure(plot);
}

/// Whether the curves of all causes, and of what remains, may have marks, each of which takes as many bytes
/// as five points of a line.
bool has_few_curves(const Diagnosis& d) {
  constexpr std::ptrdiff_t few = 6;
  const auto drawn = [](const auto& part) { return !part.curve.at.empty(); };
  return std::ranges::count_if(d.causes, drawn) + std::ranges::count_if(d.unexplained, drawn) <= few;
}

/// Each cause with its size, remedy and alternatives, and its residual with the fit.
std::string causes_part(const DiagnosisReport& r) {
  const bool marks = has_few_curves(r.diagnosis);
  std::string out;
  for (const Cause& c : r.diagnosis.causes) {
    std::vector<std::string> facts;
    for (const std::string& fact : {size_words(r, c), loss_words(r, c)})
      if (!fact.empty()) facts.push_back(fact);
    if (const auto remedy = effect_kind(c.effect.type).remedy.text; !remedy.empty())
      facts.push_back("remedy: " + std::string(remedy));
    facts.push_back("probability of such a fit without it: " + probability_text(c.p_value));
    for (const std::string& other : alternatives_to(r.diagnosis, &c)) facts.push_back("or: " + other);
    out += "<div class=\"cause\">" + page::subtitle(label(c)) + page::list(facts) +
           curve_figure(r.spec, "Residual without " + label(c) + ", and its fit", c.effect.joint, c.curve,
                        marks) +
           "</div>\n";
  }
  return page::side_by_side(out) + page::list(alternatives_to(r.diagnosis, nullptr));
}

/// The parameters of all causes with their 95 % intervals, and how sure each cause is.
std::string parameters_part(const DiagnosisReport& r) {
  TableRows rows;
  for (const Cause& c : r.diagnosis.causes)
    for (const ReportedParameter& p : reported_parameters(r.spec, c))
      rows.push_back({label(c), p.figure.name, parameter_size(r.spec, c, p), probability_text(c.p_value)});
  if (rows.empty()) return "";
  return page::table({"cause", "parameter", "value with 95 % interval", "p of the cause"}, rows);
}

std::string remainder_part(const DiagnosisReport& r) {
  std::string out = page::list(remainder_lines(r.diagnosis)), curves;
  const bool marks = has_few_curves(r.diagnosis);
  std::vector<std::string> shapes;
  for (const Unidentified& u : r.diagnosis.unexplained) {
    shapes.push_back(shown(u.joint) + ": " + shape_words(r.spec, u));
    curves += curve_figure(r.spec, "Unidentified: " + shapes.back(), u.joint, u.curve, marks);
  }
  if (!shapes.empty()) out += page::subtitle("Significant, unidentified") + page::list(shapes);
  return out + page::side_by_side(curves);
}

/// What to record or to inspect next, and what the motion of this record hides.
std::string next_part(const DiagnosisReport& r) {
  std::vector<std::string> items = advice_lines(r.diagnosis);
  ItemGroups remedies;  // the joints of each
  for (const DataFinding& f : r.diagnosis.data)
    if (!f.remedy.empty())
      add_to_group(remedies, f.remedy, f.joint.empty() ? "the whole record" : shown(f.joint));
  for (const auto& [remedy, joints] : remedies) items.push_back(joined(joints) + ": " + remedy);
  const std::vector<std::string> hidden = hidden_lines(r.diagnosis);
  if (hidden.empty()) return page::list(items);
  return page::list(items) + page::subtitle("What this motion hides") + page::list(hidden) +
         page::paragraph("qerr diagnose SPEC --plan proposes a motion that shows more.");
}

std::string record_part(const DiagnosisReport& r) {
  std::vector<std::string> items;
  for (const DataFinding& f : r.diagnosis.data) items.push_back(place_of(f) + ": " + f.what);
  return page::list(items);
}

std::string visible_part(const DiagnosisReport& r) {
  TableRows sizes = visible_sizes(r.diagnosis);
  if (sizes.empty()) return "";
  return page::paragraph("Each effect from this size on, had it been there:") + page::table(std::move(sizes));
}

std::string gain_part(const DiagnosisReport& r) {
  const Diagnosis& d = r.diagnosis;
  if (d.verdict == Verdict::cannot_judge && d.causes.empty()) return "";
  std::vector<std::string> remarks = prediction_lines(d.gain);
  if (d.gain.held_out) remarks.insert(remarks.begin(), "after: on held-out blocks of the log");
  return page::table(gain_rows(d)) + page::list(remarks);
}

/// Lines of a terminal's table as clauses of a sentence.
std::string in_one_line(const std::string& lines) {
  std::string out;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (lines[i] != '\n') {
      out += lines[i];
      continue;
    }
    out += "; ";
    i = std::min(lines.find_first_not_of(' ', i + 1), lines.size()) - 1;
  }
  return out;
}

}  // namespace

ResidualPicture residual_picture(const JointResidual& r, std::size_t intervals) {
  const Evidence& e = r.evidence;
  ResidualPicture p;
  p.joint = e.joint;
  p.prismatic = e.prismatic;
  p.unit = e.prismatic ? "m" : "rad";
  p.resolution = e.encoder.resolution;
  p.in_time = e.ordered;
  p.rows = e.rows();
  p.rms_before = rms(r.before);
  p.rms_after = rms(r.after);
  p.corrected = (r.before != r.after).any();
  draw_in_time(r, intervals, p);
  // At rest the reference's noise is all that moves: it has neither directions nor orders.
  if (e.is_stationary()) return p;
  draw_by_position(r, intervals, p);
  draw_by_count(r, p);
  draw_spectrum(r, intervals, p);
  return p;
}

page::Page page_of(const DiagnosisReport& r) {
  const Diagnosis& d = r.diagnosis;
  page::Page page{"Diagnosis of " + r.spec.robot_name,
                  page::isolated_runs(verdict_title(d) + ": " + verdict_words(r) + "."),
                  {},
                  r.warnings};
  describe(page, r.spec, verdicts_beside(r.spec));
  page.add("Causes", causes_part(r));
  page.add("Sizes of the causes", parameters_part(r));
  page.add("What to record next", next_part(r));
  const auto before_and_after = std::ssize(page.sections);
  page.add("What remains", remainder_part(r));
  page.add("What the record would have shown", visible_part(r));
  page.add("Gain", gain_part(r));
  page.add("The record", page::paragraph(in_one_line(record_words(r.log)) + "."));
  page.add("Faults of the record itself", record_part(r));
  if (std::string residuals = residuals_part(r, page::bytes_left(page)); !residuals.empty())
    page.sections.insert(page.sections.begin() + before_and_after,
                         {"Before and after", std::move(residuals)});
  return page;
}

}  // namespace qerr
