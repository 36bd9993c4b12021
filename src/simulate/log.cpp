#include "qerr/simulate/log.hpp"

#include <algorithm>
#include <cmath>

namespace qerr {

namespace {

/// Whether the log has the counts of every encoder that the joint depends on.
bool has_counts(const Log& log, const Transmission& t, std::size_t joint) {
  for (std::size_t i = 0; i < t.encoders.size(); ++i)
    if (t.coupling(joint, i) != 0 && !log.find(LogSignal::counts, i)) return false;
  return true;
}

}  // namespace

double LogColumn::step() const { return scale.in_si(std::pow(10.0, -text.most_decimals)); }

std::uint64_t Log::row_number(Eigen::Index row) const {
  if (!file_rows.empty()) return file_rows[row];
  if (stretches.empty()) return static_cast<std::uint64_t>(row);
  return stretches[row / stretch_rows] + static_cast<std::uint64_t>(row % stretch_rows);
}

std::vector<Eigen::Index> Log::rows_at_samples(std::size_t column) const {
  std::vector<Eigen::Index> next;
  const auto stamps = find(LogSignal::time);
  if (!columns[column].samples || !stamps) return next;
  const auto time = values.col(*stamps);
  Eigen::Index k = 0;
  for (const double sample : columns[column].samples->time) {
    while (k + 1 < time.size() && std::abs(time[k + 1] - sample) <= std::abs(time[k] - sample)) ++k;
    if (next.empty() || next.back() != k) next.push_back(k);
  }
  return next;
}

std::optional<Eigen::Index> Log::find(LogSignal signal, std::size_t index) const {
  for (std::size_t i = 0; i < columns.size(); ++i)
    if (columns[i].signal == signal && columns[i].index == index) return i;
  return std::nullopt;
}

bool is_measured(const Log& log, const Transmission& t, std::size_t joint) {
  return has_counts(log, t, joint) || log.find(LogSignal::measured, joint);
}

std::optional<Eigen::ArrayXd> measured_joint(const Log& log, const Eigen::ArrayXXd& rows,
                                             const Transmission& t, std::size_t joint) {
  if (has_counts(log, t, joint)) {
    Eigen::ArrayXd position = Eigen::ArrayXd::Zero(rows.rows());
    for (std::size_t i = 0; i < t.encoders.size(); ++i) {
      const double factor = t.coupling(joint, i);
      if (factor != 0)
        position += factor * (t.encoders[i].resolution * rows.col(*log.find(LogSignal::counts, i)));
    }
    return position;
  }
  const auto measured = log.find(LogSignal::measured, joint);
  if (!measured) return std::nullopt;
  return rows.col(*measured);
}

}  // namespace qerr
