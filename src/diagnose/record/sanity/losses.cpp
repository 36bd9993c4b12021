#include <algorithm>
#include <cmath>
#include <vector>

#include "diagnose/record/sanity/sanity_steps.hpp"
#include "effect/effects/effects.hpp"

/// Losses of whole counts, from three on: the search for causes finds one or two, and takes many for a drift.
namespace qerr::sanity {

namespace {

constexpr Eigen::Index side = 16;  ///< rows on each side of a step, of which the medians are compared
constexpr Eigen::Index most_read = 1 << 18;  ///< rows: medians of more take seconds
constexpr std::size_t fewest_losses = 3;
constexpr double near_whole = 0.18;  ///< rms of what is left of whole numbers; by chance it is 1/sqrt(12)

struct Loss {
  Eigen::Index row;
  double jump, step;  ///< between two rows, and of the medians around them [counts]

  double counts() const { return std::round(step); }
};

double middle(const Eigen::ArrayXd& x) { return median({x.begin(), x.end()}); }

/// Whether the joint moves on in one direction around a row, and has done so for a distance beyond the step:
/// the play of a gear makes a step where the joint has moved by the play since a reversal.
bool moves_on(const Eigen::ArrayXd& motion, Eigen::Index k, double step) {
  const Eigen::ArrayXd path = motion.segment(k - side, 2 * side);
  const double net = path[path.size() - 1] - path[0];
  if (std::abs(net) < side / 4.0 ||
      std::abs(net) < 0.8 * (path.tail(path.size() - 1) - path.head(path.size() - 1)).abs().sum())
    return false;
  const double far = 2 * std::abs(step) + 2, forward = net > 0 ? 1 : -1;
  double farthest = 0;
  for (Eigen::Index i = k - side; i >= 0; --i) {
    const double gone = forward * (motion[k] - motion[i]);
    if (gone >= far) return true;
    if (gone < farthest - 1) return false;
    farthest = std::max(farthest, gone);
  }
  return false;
}

/// Difference of the medians after and before a row.
double step_at(const Eigen::ArrayXd& error, Eigen::Index k) {
  return middle(error.segment(k, side)) - middle(error.segment(k - side, side));
}

/// Whether steps go to and fro between two levels, as the drive of a joint that coasts between its flanks
/// does: losses of equal size would by chance once in 8 times.
bool is_to_and_fro(const std::vector<Loss>& losses) {
  constexpr std::size_t fewest = 4;
  if (losses.size() < fewest) return false;
  for (std::size_t i = 1; i < losses.size(); ++i)
    if (std::abs(losses[i].counts() + losses[i - 1].counts()) > 1) return false;
  return true;
}

/// Steps between two rows, while the joint moves on, that stand out of those of other rows; none if their
/// sizes are not those of whole numbers.
std::vector<Loss> losses_of(const Eigen::ArrayXd& error, const Eigen::ArrayXd& motion) {
  std::vector<double> others, jumps;
  for (Eigen::Index k = side; k + side <= error.size(); k += side) {
    others.push_back(std::abs(step_at(error, k)));
    jumps.push_back(std::abs(error[k] - error[k - 1]));
  }
  const double usual = median(jumps) / 0.6745, least = std::max(1.5, 8 * median(others) / 0.6745);
  std::vector<Loss> losses;
  for (Eigen::Index k = side; k + side <= error.size(); ++k) {
    const double jump = error[k] - error[k - 1];
    if (std::abs(jump) < 0.5 * least) continue;
    const double step = step_at(error, k);
    if (std::abs(step) < least || std::abs(jump - step) > 4 * usual + 0.5 || !moves_on(motion, k, step))
      continue;
    // The medians see the same step from its neighbours.
    const bool again = !losses.empty() && k < losses.back().row + side;
    if (again && std::abs(jump) <= std::abs(losses.back().jump)) continue;
    if (again) losses.pop_back();
    losses.push_back({k, jump, step});
  }
  double squares = 0;
  for (const Loss& l : losses) squares += std::pow(l.step - l.counts(), 2);
  const bool whole = squares <= near_whole * near_whole * static_cast<double>(losses.size());
  return whole && !is_to_and_fro(losses) ? losses : std::vector<Loss>{};
}

}  // namespace

void check_losses(Sanity& s, std::size_t encoder) {
  const auto stamps = s.log.find(LogSignal::time);
  const Eigen::Index rows = s.log.values.rows();
  if (!has_counts(s, encoder) || !has_reference(s, encoder) || !stamps || rows < 8 * side || rows > most_read)
    return;
  auto read = recorded_counts(s, encoder);
  const double resolution = s.model.transmission.encoders[encoder].resolution;
  const Eigen::ArrayXd motion = reference_in_counts(s, encoder);
  const double sign = direction(s.model.transmission.encoders[encoder]);
  const Eigen::ArrayXd time_of_row =
      s.log.values.col(*stamps) - s.log.values(0, *stamps);  // as effects count it
  Eigen::ArrayXd error = read->counts - motion;
  for (const Effect& e : s.present)
    if (e.type == missed_counts_effect().name && e.joint == s.model.chain.independent[encoder].name)
      error -= sign * e.number("counts") * (time_of_row >= e.number("time")).cast<double>();
  const std::vector<Loss> losses = losses_of(error, motion);
  if (losses.size() < fewest_losses) return;
  const double before = standard_deviation(error);
  for (const Loss& l : losses) {
    read->counts.tail(error.size() - l.row) -= l.counts();
    error.tail(error.size() - l.row) -= l.counts();
  }
  const double after = standard_deviation(error);
  if (!(after < 0.7 * before)) return;
  for (const Loss& l : losses) {
    const double time = 0.5 * (time_of_row[l.row] + time_of_row[l.row - 1]);
    Cause c =
        exact_cause(s, encoder, missed_counts_effect().name, {{"counts", sign * l.counts()}, {"time", time}},
                    0, before * resolution, after * resolution);
    c.parameters = {{"counts", sign * l.counts(), sign * l.counts(), sign * l.counts()},
                    {"time", time, time_of_row[l.row - 1], time_of_row[l.row]}};
    s.causes.push_back(std::move(c));
  }
  write_back(s, *read, encoder);
}

}  // namespace qerr::sanity
