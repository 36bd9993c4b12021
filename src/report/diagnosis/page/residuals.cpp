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
  page::Plot plot{title, description, x, {"measured - reference", p.unit}, {}};
  for (const auto& [name, points] : curves)
    if (!points->empty()) plot.series.push_back({name, *points});
  return plot;
}

std::string of_joint(const ResidualPicture& p) { return " of " + shown(p.joint); }

std::string time_figure(const ResidualPicture& p) {
  const page::AxisRange x =
      p.in_time ? page::AxisRange{"time", "s"} : page::AxisRange{"row", "", false, false};
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

constexpr std::size_t lines_per_joint = 16;  ///< with a cause: their points are two per interval
constexpr std::size_t fewest_intervals = 40, most_intervals = 320;

}  // namespace

std::string residuals_part(const DiagnosisReport& r, std::size_t points) {
  const std::size_t encoders = r.spec.model.transmission.encoders.size();
  const std::size_t most_joints = std::max<std::size_t>(1, points / (lines_per_joint * fewest_intervals));
  const std::size_t drawn = std::min(most_joints, encoders);
  const std::size_t intervals =
      std::clamp(points / (lines_per_joint * drawn), fewest_intervals, most_intervals);
  std::vector<ResidualPicture> of_encoder(encoders);
  for_each_residual(r, [&](const JointResidual& residual) {
    of_encoder[static_cast<std::size_t>(residual.evidence.number)] = residual_picture(residual, intervals);
  });
  std::erase_if(of_encoder, [](const ResidualPicture& p) { return p.rows == 0; });
  if (of_encoder.empty()) return "";
  sort_by_interest(of_encoder);
  std::string out = page::paragraph(
      "The line of a record passes through the smallest and the largest value of each interval of the "
      "abscissa. Residuals are those of the log as it was recorded.");
  if (of_encoder.size() > drawn) {
    std::vector<std::string> left;
    for (std::size_t i = drawn; i < of_encoder.size(); ++i) left.push_back(summary(of_encoder[i]));
    out += page::paragraph("Drawn are the " + std::to_string(drawn) +
                           " joints with the largest residuals, those with a cause first. The others:") +
           page::list(left);
    of_encoder.resize(drawn);
  }
  std::vector<std::pair<std::string, std::string>> figures;
  for (const ResidualPicture& p : of_encoder)
    figures.emplace_back(shown(p.joint), page::paragraph(summary(p)) +
                                             page::side_by_side(time_figure(p) + position_figures(p) +
                                                                count_figure(p) + spectrum_figure(p)));
  return out + page::choice("Joint", figures);
}

}  // namespace qerr
