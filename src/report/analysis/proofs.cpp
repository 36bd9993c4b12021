#include "report/analysis/proofs.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "bound/proven/reached.hpp"
#include "core/text.hpp"
#include "qerr/kinematics/coordinates.hpp"
#include "report/analysis/tables.hpp"
#include "report/fitted_table.hpp"
#include "report/text_table.hpp"
#include "report/wrapped_text.hpp"

namespace qerr {

namespace {

using Bound = ProvenFigure::Bound;

/// Every worst case and sigma whose figures are known.
std::vector<ProvenFigure> all_figures(const Analysis& a) {
  std::vector<ProvenFigure> figures;
  const std::size_t coordinates = a.workspace.coordinates.size();
  for (std::size_t c = 0; c < coordinates; ++c)
    for (const Bound bound : {Bound::worst_case, Bound::sigma}) figures.push_back({c, -1, bound});
  for (std::size_t f = 0; f < a.spec.filters.size(); ++f)
    for (std::size_t c = 0; c < coordinates; ++c) {
      const auto filter = static_cast<std::ptrdiff_t>(f);
      figures.push_back({c, filter, Bound::worst_case});
      if (a.workspace.derivatives[f][c].sigma) figures.push_back({c, filter, Bound::sigma});
    }
  return figures;
}

const Statistic& sampled(const Analysis& a, const ProvenFigure& figure) {
  if (figure.filter >= 0) {
    const DerivativeStatistics& d =
        a.workspace.derivatives[static_cast<std::size_t>(figure.filter)][figure.coordinate];
    return figure.bound == Bound::worst_case ? d.worst_case
           : figure.bound == Bound::sigma    ? *d.sigma
                                             : *d.sigma_in_motion;
  }
  const CoordinateStatistics& c = a.workspace.coordinates[figure.coordinate];
  return figure.bound == Bound::worst_case ? c.worst_case
         : figure.bound == Bound::sigma    ? c.sigma
                                           : c.worst_case_rigorous;
}

/// The limits of requirements on the proven maxima of figures, infinite where one has another relation.
std::vector<double> limits_of(const Analysis& a, const std::vector<ProvenFigure>& figures) {
  std::vector<double> limits;
  for (const ProvenFigure& figure : figures) {
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

void prove(Analysis& a, const std::vector<ProvenFigure>& figures, ProofOptions options, bool verdicts_only) {
  if (verdicts_only) options.limits = limits_of(a, figures);
  for (const ProvenFigure& figure : figures)
    if (const Eigen::VectorXd& at = sampled(a, figure).at_max; at.size() > 0) options.starts.push_back(at);
  const std::vector<ProvenMaximum> maxima =
      proven_maxima(a.spec.model, filter_norms(a.spec), a.spec.configurations.ranges, figures, options);
  for (std::size_t i = 0; i < figures.size(); ++i) {
    ProvenMaximum maximum = maxima[i];
    // Of configurations that are equal but for rounding the sample reports the first one.
    set_reached(maximum, std::max(maximum.lower, sampled(a, figures[i]).max));
    const auto known = std::find_if(a.proofs.begin(), a.proofs.end(),
                                    [&](const ProvenResult& p) { return p.figure == figures[i]; });
    if (known == a.proofs.end())
      a.proofs.push_back({figures[i], std::move(maximum), options.gap});
    else
      *known = {figures[i], std::move(maximum), options.gap};
  }
}

/// Repeats the proofs of figures whose requirements are undecided.
void refine(Analysis& a, ProofOptions options, bool verdicts_only) {
  std::map<ProvenFigure, double> gaps;
  for (const Requirement& r : a.spec.requirements) {
    if (!r.proven) continue;
    const ProvenFigure figure = proven_figure(r, a.spec.model);
    const ProvenMaximum& proven = *find_proof(a, figure);
    if (!evaluate(r, proven).undecided) continue;
    const double gap = deciding_gap(r, proven, options.gap);
    const auto [known, fresh] = gaps.emplace(figure, gap);
    if (!fresh) known->second = std::min(known->second, gap);
  }
  for (const auto& [figure, gap] : gaps) {
    options.gap = gap;
    options.starts = {find_proof(a, figure)->at};
    prove(a, {figure}, options, verdicts_only);
  }
}

std::string quantity_of(const Analysis& a, const ProvenFigure& figure) {
  static const std::map<Bound, std::string> names{{Bound::worst_case, ".worst_case"},
                                                  {Bound::worst_case_rigorous, ".worst_case_rigorous"},
                                                  {Bound::sigma, ".sigma"},
                                                  {Bound::sigma_in_motion, ".sigma_in_motion"}};
  const std::string signal =
      figure.filter < 0 ? "position" : a.spec.filters[static_cast<std::size_t>(figure.filter)].name;
  return signal + '.' + std::string(info(coordinates_and_lengths(a.spec.model)[figure.coordinate]).name) +
         names.at(figure.bound);
}

std::string unit_of(const Analysis& a, const ProvenFigure& figure) {
  const Coordinate c = coordinates_and_lengths(a.spec.model)[figure.coordinate];
  return figure.filter < 0 ? std::string(info(c).unit)
                           : shown_unit(c, a.spec.filters[static_cast<std::size_t>(figure.filter)].filter);
}

/// A figure that is the rounding of a zero: less than 1e-12 of the largest one of its unit.
bool is_zero(const Analysis& a, const ProvenResult& proof) {
  constexpr double rounding = 1e-12;
  double largest = 0;
  for (const ProvenResult& other : a.proofs)
    if (unit_of(a, other.figure) == unit_of(a, proof.figure))
      largest = std::max(largest, other.maximum.lower);
  return proof.maximum.upper <= rounding * largest;
}

void warn_of_gaps(Analysis& a) {
  std::vector<std::string> wide, unbounded;
  for (const ProvenResult& proof : a.proofs) {
    const double gap = proof.maximum.gap();
    if (!(gap > proof.gap) || is_zero(a, proof)) continue;
    if (std::isinf(proof.maximum.upper))
      unbounded.push_back(quantity_of(a, proof.figure));
    else
      wide.push_back(quantity_of(a, proof.figure) + ' ' + percent(gap));
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
  const std::string si = unit_of(a, proof.figure);
  const PrefixedUnit unit = prefixed(cleaned(std::isfinite(m.upper) ? m.upper : m.lower), si);
  const auto cell = [&](double value) {
    return std::isinf(value) ? "inf" : significant(cleaned(value) / unit.factor, 5);
  };
  return {quantity_of(a, proof.figure),
          unit.unit,
          cell(sampled(a, proof.figure).max),
          cell(m.lower),
          cell(m.upper),
          is_zero(a, proof)     ? "-"
          : std::isinf(m.gap()) ? "inf"
                                : percent(m.gap())};
}

/// `a1 0.12 rad, a2 -1.5 rad`. Joints without influence end where rounding leaves them.
std::string place_of(const Analysis& a, const Eigen::VectorXd& q) {
  constexpr double least_shown = 1e-6;
  std::string out;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const IndependentJoint& joint = a.spec.model.chain.independent[static_cast<std::size_t>(i)];
    out += (i ? ", " : "") + shown(joint.name) + ' ' +
           readable(std::abs(q[i]) < least_shown ? 0 : q[i], joint.prismatic() ? "m" : "rad");
  }
  return out;
}

}  // namespace

const ProvenMaximum* find_proof(const Analysis& a, const ProvenFigure& figure) {
  for (const ProvenResult& proof : a.proofs)
    if (proof.figure == figure) return &proof.maximum;
  return nullptr;
}

void add_proofs(Analysis& a, const ProofRequest& request, unsigned threads) {
  std::vector<ProvenFigure> figures;
  if (request.all) figures = all_figures(a);
  for (const Requirement& r : a.spec.requirements) {
    if (!r.proven) continue;
    const ProvenFigure figure = proven_figure(r, a.spec.model);
    if (std::find(figures.begin(), figures.end(), figure) == figures.end()) figures.push_back(figure);
  }
  if (figures.empty()) return;
  const ProofOptions options{.gap = request.gap,
                             .threads = threads,
                             .progress = request.progress,
                             .noise_in_motion = a.noise_in_motion};
  prove(a, figures, options, request.verdicts_only);
  refine(a, options, request.verdicts_only);
  if (!request.verdicts_only) warn_of_gaps(a);
}

std::string proof_table(const Analysis& a, const Style& style) {
  if (a.proofs.empty()) return "";
  std::vector<std::vector<std::string>> rows{{"", "", "sampled", "reached", "proven bound", "gap"}};
  for (const ProvenResult& proof : a.proofs) rows.push_back(row_of(a, proof));
  std::string out =
      heading("Maximum over the whole joint ranges, proven", style) + fitted_table(rows, style.width);
  std::vector<std::string> told;
  for (const ProvenResult& proof : a.proofs) {
    const std::string place = place_of(a, proof.maximum.at);
    if (is_zero(a, proof) || std::find(told.begin(), told.end(), place) != told.end()) continue;
    told.push_back(place);
    out += wrapped(quantity_of(a, proof.figure) + " at " + place, style.width, "    ", "  ");
  }
  return out;
}

}  // namespace qerr
