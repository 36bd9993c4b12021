#include <algorithm>

#include "core/text.hpp"
#include "report/analysis/tables.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

/// Whether the encoder's share is the largest, or equal to it in what is printed.
std::vector<bool> largest_of(const std::vector<double>& shares) {
  const double largest = *std::max_element(shares.begin(), shares.end());
  std::vector<bool> all;
  for (const double share : shares) all.push_back(share > 0 && percent(share) == percent(largest));
  return all;
}

}  // namespace

std::string encoder_table(const Analysis& a, const Style& style) {
  std::vector<double> budget = encoder_budget(a);
  budget.resize(a.spec.model.chain.independent.size());
  const std::vector<bool> largest = largest_of(budget);
  const auto first = std::count(largest.begin(), largest.end(), true);
  const bool of_tip = !a.spec.model.coordinates.empty();
  std::vector<std::vector<std::string>> rows{{"encoder", "resolution", "worst case", "sigma"}};
  if (of_tip) rows.front().emplace_back("share");
  for (std::size_t i = 0; i < budget.size(); ++i) {
    const IndependentJoint& joint = a.spec.model.chain.independent[i];
    const std::string unit = joint.prismatic() ? "m" : "rad";
    const auto row = static_cast<Eigen::Index>(i);
    rows.push_back({shortened(joint.name, 22), readable(a.resolutions[row], unit),
                    readable(a.joints.worst_case[row], unit), readable(a.joints.sigma[row], unit)});
    if (of_tip) rows.back().push_back(percent(budget[i]));
  }
  const std::string text = aligned(rows), mark = first == 1 ? "  <- first" : "  <- equal";
  std::size_t table_width = 0;
  for (std::size_t at = 0, end; at < text.size(); at = end + 1) {
    end = text.find('\n', at);
    table_width = std::max(table_width, display_width(text.substr(at, end - at)));
  }
  const std::size_t beside = table_width + 2 + mark.size();
  const int bar_width = beside + 3 > style.width ? 0 : std::min(12, static_cast<int>(style.width - beside));
  std::string out;
  std::size_t at = 0;
  for (std::size_t i = 0; at < text.size(); ++i) {
    const std::size_t end = text.find('\n', at);
    std::string line = text.substr(at, end - at);
    at = end + 1;
    const std::string share = i > 0 && bar_width > 0 ? bar(budget[i - 1], bar_width) : "";
    if (!share.empty()) line += "  " + share;
    if (i > 0 && largest[i - 1] && budget.size() > 1) line = painted(line + mark, Paint::yellow, style);
    out += line + '\n';
  }
  return out;
}

}  // namespace qerr
