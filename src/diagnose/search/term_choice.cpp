#include "diagnose/search/term_choice.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace qerr {

namespace {

/// Part of what all terms explain that the leading names must reach to come first, and what makes a leading
/// name.
constexpr double named_share = 0.7, leading_part = 0.05;

/// 1 + 2 sum of the autocorrelation (initial positive sequence, Geyer 1992).
double integrated_correlation(const Eigen::ArrayXd& x) {
  const Eigen::Index n = x.size(), longest = n / 16;
  const double power = x.square().sum();
  if (!(power > 0)) return 1;
  const auto product = [&](Eigen::Index lag) { return (x.head(n - lag) * x.tail(n - lag)).sum(); };
  double sum = 1;
  for (Eigen::Index lag = 1; lag + 1 <= longest; lag += 2) {
    const double pair = (product(lag) + product(lag + 1)) / power;
    if (pair <= 0) break;
    sum += 2 * pair;
  }
  return std::clamp(sum, 1.0, std::max(1.0, static_cast<double>(longest)));
}

template <typename Which>
void allow(ErrorModel& m, const ChoiceHistory& history, Which which) {
  m.allow([&](std::size_t i) {
    const std::vector<std::string>& refuted = history.refuted;
    if (!history.names && m.term(i).named()) return false;
    return which(i) && std::find(refuted.begin(), refuted.end(), m.candidate(i).family) == refuted.end();
  });
}

/// The allowed groups of the families that the previous pass has found.
LinearModel::Set previous(const ErrorModel& m, const ChoiceHistory& history) {
  LinearModel::Set set;
  for (const std::string& family : history.found)
    for (std::size_t i = 0; i < m.candidates().size(); ++i)
      if (m.candidate(i).family == family && m.group(i).allowed) {
        set.push_back(i);
        break;
      }
  return m.possible(set, m.fit(set)) ? set : LinearModel::Set{};
}

/// Number of causes, of which all orders of a shaft are one.
std::size_t count_causes(const ErrorModel& m, const LinearModel::Set& set) {
  std::vector<std::string> causes;
  std::size_t steps = 0;
  for (const std::size_t g : set) {
    const Term& t = m.term(g);
    if (t.constant) continue;
    if (t.step) {
      ++steps;
      continue;
    }
    const auto shaft = t.effect.choices.find("shaft");
    const std::string cause =
        t.harmonic && shaft != t.effect.choices.end() ? "shaft " + shaft->second : t.effect.type;
    if (std::find(causes.begin(), causes.end(), cause) == causes.end()) causes.push_back(cause);
  }
  return causes.size() + steps;
}

/// The names that come first where nothing explains everything: those that explain a twentieth of what names
/// can explain, if they are few and explain nearly as much as the best model. Real errors differ from the
/// textbook's shapes, and a table of any curve fits better than a name; but it tells nothing.
LinearModel::Set leading_names(const ErrorModel& m, const LinearModel::Set& names,
                               const LinearModel::Set& best) {
  const double nothing = m.fit({}).rss, with_names = m.fit(names).rss, all = nothing - m.fit(best).rss;
  LinearModel::Set core;
  for (std::size_t i = 0; i < names.size(); ++i) {
    // Steps and exponentials are functions of time alone, of which a table is only the better version.
    const Term& t = m.term(names[i]);
    if (t.step || t.reshaped) continue;
    LinearModel::Set without = names;
    without.erase(without.begin() + static_cast<std::ptrdiff_t>(i));
    if (m.fit(without).rss - with_names > leading_part * (nothing - with_names)) core.push_back(names[i]);
  }
  const double explained = nothing - m.fit(core).rss;
  if (explained < named_share * all || count_causes(m, core) > best.size()) return {};
  return core;
}

/// The best of the sets that the search reaches from nothing, from the best named terms and from what the
/// previous pass has found: a table can take the place of any one of several named terms that together need
/// fewer coefficients.
LinearModel::Set best_of_starts(ErrorModel& m, const ChoiceHistory& history, double independent) {
  const auto better = [&](LinearModel::Set a, LinearModel::Set b) {
    return m.criterion(a, independent) <= m.criterion(b, independent) ? a : b;
  };
  m.price(independent, history.worth_of_shapes, history.worth_of_shapes);
  allow(m, history, [&](std::size_t i) { return m.term(i).named(); });
  const LinearModel::Set names =
      better(m.search(previous(m, history), 0, independent), m.search({}, 0, independent));
  m.price(independent, history.worth, history.worth_of_shapes);
  allow(m, history, [](std::size_t) { return true; });
  LinearModel::Set best = better(m.search(names, 0, independent), m.search({}, 0, independent));
  if (!history.found.empty()) best = better(std::move(best), m.search(previous(m, history), 0, independent));
  if (m.is_complete(best)) return best;
  const LinearModel::Set core = leading_names(m, names, best);
  if (core.empty()) return best;
  m.price(independent, history.worth_of_shapes, history.worth_of_shapes);
  return m.search(core, core.size(), independent);
}

}  // namespace

Choice choose_terms(ErrorModel& m, const ChoiceHistory& history) {
  Choice c;
  c.richest = best_of_starts(m, history, m.rows());
  const Eigen::ArrayXd residual = m.residual(c.richest, m.fit(c.richest)) * m.weight().sqrt();
  c.correlation = m.sampled().ordered ? integrated_correlation(residual) : 1;
  c.chosen = !m.sampled().ordered || c.correlation < 1.5
                 ? c.richest
                 : best_of_starts(m, history, m.rows() / c.correlation);
  c.fit = m.fit(c.chosen);
  c.residual = m.residual(c.chosen, c.fit);
  return c;
}

}  // namespace qerr
