#include <algorithm>
#include <cmath>
#include <map>

#include "core/text.hpp"
#include "qerr/bound/proven_maximum.hpp"
#include "report/analysis/figures.hpp"
#include "report/analysis/tables.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

/// Every worst case and sigma whose figures are known.
std::vector<Figure> provable_figures(const Analysis& a) {
  std::vector<Figure> figures;
  for (const FigureName& name : all_figures(a.spec)) {
    const Figure& f = name.figure;
    if (is_closed(all_signals(a.spec.model)[f.signal])) continue;  // no bound over boxes of joints is known
    if ((f.bound == Bound::worst_case || f.bound == Bound::sigma) && statistic_of(a.workspace, f))
      figures.push_back(f);
  }
  return figures;
}

/// The limits of requirements on the proven maxima of figures, infinite where one has another relation.
std::vector<double> limits_of(const Analysis& a, const std::vector<Figure>& figures) {
  std::vector<double> limits;
  for (const Figure& figure : figures) {
    // Limits of several requirements need the proof itself.
    double limit = std::numeric_limits<double>::infinity();
    std::size_t count = 0;
    for (const Requirement& r : a.spec.requirements) {
      if (!r.proven || proven_figure(r, a.spec.model) != figure) continue;
      ++count;
      // Any bound decides an infinite limit.
      if (!r.at_least) limit = std::min(r.limit, std::numeric_limits<double>::max());
    }
    limits.push_back(count == 1 ? limit : std::numeric_limits<double>::infinity());
  }
  return limits;
}

void prove(Analysis& a, const std::vector<Figure>& figures, ProofOptions options) {
  if (options.of_distance > 0) options.limits = limits_of(a, figures);
  for (const Figure& figure : figures)
    if (const Eigen::VectorXd& at = statistic_of(a.workspace, figure)->at_max; at.size() > 0)
      options.starts.push_back(at);
  const std::vector<ProvenMaximum> maxima =
      proven_maxima(a.spec.model, filter_norms(a.spec), a.spec.configurations.ranges, figures, options);
  for (std::size_t i = 0; i < figures.size(); ++i) {
    ProvenMaximum maximum = maxima[i];
    // Of configurations that are equal but for rounding the sample reports the first one.
    set_reached(maximum, std::max(maximum.lower, statistic_of(a.workspace, figures[i])->max));
    const auto known =
        std::ranges::find_if(a.proofs, [&](const ProvenResult& p) { return p.figure == figures[i]; });
    if (known == a.proofs.end())
      a.proofs.push_back({figures[i], std::move(maximum)});
    else
      *known = {figures[i], std::move(maximum)};
  }
}

/// Repeats the proofs of figures whose requirements are undecided.
void refine(Analysis& a, ProofOptions options) {
  std::map<Figure, double> gaps;
  for (const Requirement& r : a.spec.requirements) {
    if (!r.proven) continue;
    const Figure figure = proven_figure(r, a.spec.model);
    const ProvenMaximum& proven = *find_proof(a, figure);
    if (!evaluate(r, proven).undecided) continue;
    const double gap = deciding_gap(r, proven, options.gap);
    const auto [known, fresh] = gaps.emplace(figure, gap);
    if (!fresh) known->second = std::min(known->second, gap);
  }
  for (const auto& [figure, gap] : gaps) {
    options.gap = gap;
    options.starts = {find_proof(a, figure)->at};
    prove(a, {figure}, options);
  }
}

/// A figure that is the rounding of a zero: less than 1e-12 of the largest one of its unit.
bool is_zero(const Analysis& a, const ProvenResult& proof) {
  constexpr double rounding = 1e-12;
  double largest = 0;
  for (const ProvenResult& other : a.proofs)
    if (name_of(a.spec, other.figure).shown_unit == name_of(a.spec, proof.figure).shown_unit)
      largest = std::max(largest, other.maximum.lower);
  return proof.maximum.upper <= rounding * largest;
}

void warn_of_gaps(Analysis& a) {
  std::vector<std::string> wide, unbounded;
  for (const ProvenResult& proof : a.proofs) {
    const double gap = proof.maximum.gap();
    if (!(gap > proof.maximum.wanted_gap) || is_zero(a, proof)) continue;
    if (std::isinf(proof.maximum.upper))
      unbounded.push_back(name_of(a.spec, proof.figure).quantity());
    else
      wide.push_back(name_of(a.spec, proof.figure).quantity() + ' ' + percent(gap));
  }
  constexpr std::size_t most_named = 6;
  const auto list = [&](std::vector<std::string> names) {
    const std::size_t count = names.size();
    if (count > most_named) names.resize(most_named);
    if (count > most_named) names.push_back(std::to_string(count - most_named) + " more");
    return listed(names);
  };
  if (!wide.empty())
    a.warnings.push_back("proven maxima with a wider gap than asked for, as the work is limited: " +
                         list(wide));
  if (!unbounded.empty())
    a.warnings.push_back("no upper bound over the joint ranges is known of " + list(unbounded));
}

std::vector<std::string> row_of(const Analysis& a, const ProvenResult& proof) {
  const ProvenMaximum& m = proof.maximum;
  const std::string si = name_of(a.spec, proof.figure).shown_unit;
  const PrefixedUnit unit = prefixed(cleaned(std::isfinite(m.upper) ? m.upper : m.lower), si);
  const auto cell = [&](double value) {
    return std::isinf(value) ? "inf" : significant(cleaned(value) / unit.factor, 5);
  };
  return {name_of(a.spec, proof.figure).quantity(),
          unit.unit,
          cell(statistic_of(a.workspace, proof.figure)->max),
          cell(m.lower),
          cell(m.upper),
          is_zero(a, proof)     ? "-"
          : std::isinf(m.gap()) ? "inf"
                                : percent(m.gap())};
}

/// Joints without influence end where rounding leaves them.
std::string place_of(const Analysis& a, const Eigen::VectorXd& q) {
  constexpr double least_shown = 1e-6;
  return configuration_text(a.spec.model.chain, (q.array().abs() < least_shown).select(0.0, q));
}

}  // namespace

const ProvenMaximum* find_proof(const Analysis& a, const Figure& figure) {
  for (const ProvenResult& proof : a.proofs)
    if (proof.figure == figure) return &proof.maximum;
  return nullptr;
}

void add_proofs(Analysis& a, const ProofRequest& request, unsigned threads) {
  std::vector<Figure> figures;
  if (request.all) figures = provable_figures(a);
  for (const Requirement& r : a.spec.requirements) {
    if (!r.proven) continue;
    const Figure figure = proven_figure(r, a.spec.model);
    add_once(figures, figure);
  }
  if (figures.empty()) return;
  const ProofOptions options{.gap = request.gap,
                             .threads = threads,
                             .progress = request.progress,
                             .noise_in_motion = a.noise_in_motion,
                             .of_distance = request.of_distance};
  prove(a, figures, options);
  refine(a, options);
  if (request.of_distance < 1) warn_of_gaps(a);
}

std::string proof_table(const Analysis& a, const Style& style) {
  if (a.proofs.empty()) return "";
  TableRows rows{{"", "", "sampled", "reached", "proven bound", "gap"}};
  for (const ProvenResult& proof : a.proofs) rows.push_back(row_of(a, proof));
  std::string out = table_section("Maximum over the whole joint ranges, proven", rows, style);
  std::vector<std::string> told;
  for (const ProvenResult& proof : a.proofs) {
    const std::string place = place_of(a, proof.maximum.at);
    if (is_zero(a, proof) || !add_once(told, place)) continue;
    out += wrapped(name_of(a.spec, proof.figure).quantity() + " at " + place, style.width, "    ", "  ");
  }
  return out;
}

}  // namespace qerr
