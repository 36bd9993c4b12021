#include "diagnose/verdict/verdict.hpp"

#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"
#include "core/statistics.hpp"

namespace qerr {

namespace {

constexpr Eigen::Index surrogates = 99;
constexpr Eigen::Index telling = 5;  ///< surrogates beyond the record, from which on their rank is a p-value

struct Judged {
  Comparison row;
  double distance;  ///< in standard deviations
};

double tail(const ResidualStatistic& s, double expected, double scatter) {
  const double observed = s.values[0];
  const auto others = s.values.tail(s.values.size() - 1);
  const auto count = static_cast<double>(others.size());
  if (s.tail == Tail::chi_squared) {
    const double square = others.square().mean() + s.degrees * s.least * s.least;
    return fisher_f_tail(observed * observed / square, s.degrees, s.degrees * count);
  }
  const double t = std::abs(observed - expected) / (scatter * std::sqrt(1 + 1 / count));
  return 2 * student_t_tail(t, count - 1);
}

Judged judged(const std::string& joint, const ResidualStatistic& s) {
  const auto others = s.values.tail(s.values.size() - 1);
  const auto count = static_cast<double>(others.size());
  const double expected = others.mean();
  const double scatter = std::hypot(std::sqrt((others - expected).square().sum() / (count - 1)), s.least);
  const double off = std::abs(s.values[0] - expected);
  const Eigen::Index beyond = s.tail == Tail::chi_squared ? (others >= s.values[0]).count()
                                                          : ((others - expected).abs() >= off).count();
  double p = tail(s, expected, scatter);
  if (beyond >= telling) p = std::max(p, (1 + static_cast<double>(beyond)) / (1 + count));
  return {{joint, s.name, s.values[0], expected, p}, off / scatter};
}

}  // namespace

std::vector<JointStatistics> joint_statistics(const std::vector<Evidence>& all,
                                              const std::vector<Filter>& filters,
                                              const DiagnoseOptions& options) {
  // Joints beside each other, as what a joint's surrogates share is one thread's work; threads beyond are
  // the surrogates'.
  const unsigned threads = thread_count(options.threads);
  const unsigned each = std::max(1u, threads / static_cast<unsigned>(std::max<std::size_t>(1, all.size())));
  std::vector<JointStatistics> joints(all.size());
  parallel_for(all.size(), threads, [&](std::size_t i) {
    const auto stream = options.seed * 64 + static_cast<std::uint64_t>(all[i].number);
    joints[i] = {all[i].joint, residual_statistics(all[i], filters, surrogates, stream, each)};
  });
  return joints;
}

std::vector<Comparison> comparison(const std::vector<JointStatistics>& joints) {
  std::vector<Judged> rows;
  for (const JointStatistics& j : joints)
    for (const ResidualStatistic& s : j.statistics) rows.push_back(judged(j.joint, s));
  std::stable_sort(rows.begin(), rows.end(), [](const Judged& a, const Judged& b) {
    return a.row.p_value != b.row.p_value ? a.row.p_value < b.row.p_value : a.distance > b.distance;
  });
  std::vector<Comparison> found;
  for (Judged& j : rows) {
    j.row.p_value = std::min(1.0, j.row.p_value * static_cast<double>(rows.size()));
    found.push_back(std::move(j.row));
  }
  return found;
}

namespace {

/// Whether an unidentified residual affects the verdict. If the causes of its joint explain more than 99 % of
/// the variance, and what they leave is near what their model predicts, it is only reported.
bool affects_verdict(const Unidentified& residual, const std::vector<Cause>& causes) {
  constexpr double worth = 0.1, near = 2;
  return std::none_of(causes.begin(), causes.end(), [&](const Cause& c) {
    return (c.gain.of_tip ? residual.joint == "tip" : c.effect.joint == residual.joint) &&
           residual.amplitude < worth * c.gain.rms_before && c.gain.rms_after < worth * c.gain.rms_before &&
           !(c.gain.sigma_ratio >= near);
  });
}

}  // namespace

Verdict verdict(const Diagnosis& d, bool judged) {
  const bool found = !d.causes.empty(), residual = !d.unexplained.empty();
  if (!judged && !found && !residual) return Verdict::cannot_judge;
  if (!found) return residual ? Verdict::unexplained : Verdict::nothing_wrong;
  if (!d.alternatives.empty()) return Verdict::ambiguous;
  const bool counting = std::any_of(d.unexplained.begin(), d.unexplained.end(),
                                    [&](const Unidentified& u) { return affects_verdict(u, d.causes); });
  const auto differs = [](const std::optional<Reproduction>& check) { return check && !check->agrees; };
  return counting || differs(d.check) || differs(d.tip_check) ? Verdict::partly_explained
                                                              : Verdict::explained;
}

}  // namespace qerr
