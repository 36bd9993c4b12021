#include <cmath>

#include "core/text.hpp"
#include "report/analysis/tables.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

std::string table_of(const Exceedance& e, const std::string& base, const Style& style) {
  std::string out =
      heading(shown(e.quantity) + " above " + readable(e.limit, e.unit) + ": " + std::to_string(e.above) +
                  " of " + std::to_string(e.count) + " configurations, " +
                  percent(static_cast<double>(e.above) / static_cast<double>(e.count)),
              style);
  if (e.above == 0) return out;
  std::vector<std::vector<std::string>> rows{{"distance of the tip", "configurations", "above", "share"}};
  for (const Exceedance::Shell& s : e.by_distance)
    if (s.count > 0)
      rows.push_back({significant(s.from, 3) + " to " + significant(s.to, 3) + " m", std::to_string(s.count),
                      std::to_string(s.above),
                      percent(static_cast<double>(s.above) / static_cast<double>(s.count))});
  out += fitted_table(rows, style.width);
  std::string box = "distance: from the origin of " + escaped(base, 60) + "; above the limit the tip is at";
  const char* const names = "xyz";
  for (Eigen::Index i = 0; i < 3; ++i)
    box += std::string(i > 0 ? ", " : " ") + names[i] + ' ' + significant(e.lowest[i], 3) + " to " +
           significant(e.highest[i], 3) + " m";
  return out + wrapped(box, style.width, "  ");
}

}  // namespace

std::string exceedance_tables(const Analysis& a, const Style& style) {
  std::string out;
  for (const Exceedance& e : a.exceedances) out += table_of(e, a.spec.model.chain.base, style);
  return out;
}

}  // namespace qerr
