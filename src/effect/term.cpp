#include "effect/term.hpp"

#include <stdexcept>
#include <utility>

#include "qerr/effect/effect_kind.hpp"

namespace qerr {

Eigen::ArrayXd addition(const Term& t, const Eigen::VectorXd& coefficients) {
  Eigen::ArrayXd added = (t.columns.matrix() * coefficients).array();
  if (t.fixed.size() > 0) added += t.fixed;
  return added;
}

Term with_columns(Term t, Eigen::ArrayXXd columns) {
  t.columns = std::move(columns);
  t.fixed.resize(0);
  t.reshaped = nullptr;
  t.relinearized = nullptr;
  t.along = nullptr;
  return t;
}

Term linear_term(const RecordSignals& s, std::string_view effect, Eigen::ArrayXd column,
                 void (*fill)(Effect&, const Eigen::VectorXd&)) {
  Term t;
  t.effect = {std::string(effect), s.joint, {}, {}};
  t.columns = std::move(column);
  t.fill = fill;
  return t;
}

std::vector<Term> named_terms(const RecordSignals& s) {
  std::vector<Term> all;
  for (const EffectKind& kind : effect_kinds())
    if (kind.terms)
      for (Term& t : kind.terms(s)) all.push_back(std::move(t));
  return all;
}

Term step_term(const RecordSignals& s, double time) {
  for (const EffectKind& kind : effect_kinds())
    if (kind.step_at) return kind.step_at(s, time);
  throw std::logic_error("no effect has a step term");
}

}  // namespace qerr
