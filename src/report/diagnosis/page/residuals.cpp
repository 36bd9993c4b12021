#include <algorithm>
#include <array>
#include <cmath>

#include "core/text.hpp"
#include "report/diagnosis/page/pictures.hpp"
#include "report/diagnosis/page/residual_picture.hpp"
#include "report/page/page.hpp"
#include "report/page/plot.hpp"
#include "report/page/prose.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

using Curve = std::pair<std::string, const ResidualPicture::Points*>;

page::Plot residual_plot(const ResidualPicture& p, const std::string& title, const std::string& description,
                         const page::AxisRange& x, const std::vector<Curve>& curves) {
  page::Plot plot{page::isolated_runs(title), description, x, {"measured - reference", p.unit}, {}};
  for (const auto& [name, points] : curves)
    if (!points->empty()) plot.series.push_back({name, *points});
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
    out += figure(
        residual_plot(p, "Residual" + of_joint(p) + " by position" + way,
                      "Smallest and largest residual in each interval of the position, and the mean of "
                      "what the causes contribute.",
                      position_axis(p), {{"before", &side.before}, {"fit", &side.fit}}));
  }
  const page::Plot after = residual_plot(
      p, "Residual" + of_joint(p) + " by position, after", "The same after subtraction of the causes.",
      position_axis(p),
      sided ? std::vector<Curve>{{"forward", &p.sides[0].after}, {"backward", &p.sides[1].after}}
            : std::vector<Curve>{{"after", &p.sides[2].after}});
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
  std::stable_sort(all.begin(), all.end(), [](const ResidualPicture& a, const ResidualPicture& b) {
    if (a.corrected != b.corrected) return a.corrected;
    return a.rms_before / a.resolution > b.rms_before / b.resolution;
  });
}

/// Joints that are drawn, and the intervals of their lines.
struct Extent {
  std::size_t joints, intervals;
};

/// @param corrected  of the encoders, which are drawn first and have more lines
Extent extent(std::size_t bytes, std::size_t encoders, std::size_t corrected) {
  constexpr std::size_t fewest = 40, most = 320, per_point = 36;
  // Axes and legends of six figures or five, and the means by count; points of all lines in an interval.
  const auto fixed = [](bool with_fit) -> std::size_t { return with_fit ? 18000 : 13000; };
  const auto per_interval = [](bool with_fit) -> std::size_t { return per_point * (with_fit ? 18 : 8); };
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
  return static_cast<std::size_t>(
      std::count_if(joints.begin(), joints.end(), [&](const IndependentJoint& joint) {
        return std::any_of(r.diagnosis.causes.begin(), r.diagnosis.causes.end(),
                           [&](const Cause& c) { return c.effect.joint == joint.name; });
      }));
}

}  // namespace

std::string residuals_part(const DiagnosisReport& r, std::size_t bytes) {
  const std::size_t encoders = r.spec.model.transmission.encoders.size();
  if (encoders == 0 || r.log.values.size() == 0) return "";
  const Extent drawn = extent(bytes, encoders, joints_with_a_cause(r));
  std::vector<ResidualPicture> all(encoders);
  for_each_residual(r, [&](const JointResidual& residual) {
    all[static_cast<std::size_t>(residual.evidence.number)] = residual_picture(residual, drawn.intervals);
  });
  std::erase_if(all, [](const ResidualPicture& p) { return p.rows == 0; });
  if (all.empty()) return "";
  sort_by_interest(all);
  std::string out = page::paragraph(
      "The line of a record passes through the smallest and the largest value of each interval of the "
      "abscissa. Residuals are those of the log as it was recorded.");
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

}  // namespace qerr
