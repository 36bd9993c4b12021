#include "diagnose/verdict/cause_report.hpp"

#include <cmath>
#include <numbers>
#include <set>

#include "core/statistics.hpp"
#include "diagnose/inference/found_parameters.hpp"
#include "diagnose/inference/model_choice.hpp"
#include "diagnose/verdict/record_advice.hpp"
#include "qerr/kinematics/jacobian.hpp"

namespace qerr {

namespace {

std::optional<double> order_of(const Effect& e) {
  return e.numbers.count("order") ? std::optional(e.number("order")) : std::nullopt;
}

std::optional<double> frequency_of(const Effect& e) {
  return e.numbers.count("frequency") ? std::optional(e.number("frequency")) : std::nullopt;
}

/// What is the same by its nature, whatever was recorded.
std::vector<std::string> twins(const Effect& effect, const Evidence& e, bool loaded) {
  const bool half = std::abs(effect.number_or("offset", 0) + 0.5 * e.step()) < 0.1 * e.step();
  if (effect.type == "offset" && half && e.encoder.rounding == Rounding::nearest) return {"truncation"};
  if (effect.type == "reference_error") return {"transmission_error"};
  // Within the one period of a resolver its sine and cosine make what an eccentric disc makes.
  const double period = e.encoder.counts_per_period * e.step() * std::abs(e.encoder.shaft_ratio);
  const bool one_period =
      e.encoder.counts_per_period > 4 && std::abs(period / (2 * std::numbers::pi) - 1) < 1e-6;
  if (effect.type == "subdivision_error" && one_period && effect.number("clipping") == 1)
    return {"eccentricity"};
  if (effect.type != "eccentricity" && effect.type != "transmission_error") return {};
  std::vector<std::string> same;
  const double order = std::abs(wave_number(effect, e.encoder));
  // Steppers, the usual references, err at 50 and 100 periods a turn.
  if (std::abs(std::remainder(order, 50)) < 1e-3 && order > 1) same.push_back("reference_error");
  // A weight that nobody has measured goes with the cosine of the angle.
  if (std::abs(order - 1) < 1e-6 && e.effort.size() == 0 && loaded) same.push_back("compliance");
  if (one_period) same.push_back("subdivision_error");
  return same;
}

/// One encoder's causes, alternatives and remainders.
class Account {
 public:
  Account(Diagnosis& d, const Evidence& e, const Gain& gain, bool loaded)
      : d_(d), e_(e), gain_(gain), loaded_(loaded) {}

  void of_terms(const Selection& s, const Scatter& scatter) {
    const auto parameters = found_parameters(e_, s.model);
    for (std::size_t i = 0; i < s.model.terms().size(); ++i) {
      const Term& t = s.model.terms()[i];
      Effect effect = t.effect;
      t.fill(effect, s.model.coefficients(i));
      if (!t.named()) {
        d_.unexplained.push_back({e_.joint, t.unnamed, order_of(effect), frequency_of(effect),
                                  std::sqrt(2.0) * size_of(s.model, i)});
        continue;
      }
      // Unequal states have a mean of their own.
      if (effect.type == "offset" && scatter.effect && scatter.effect->type == "state_width") continue;
      std::vector<std::string> others = twins(effect, e_, loaded_);
      for (const Alternative& other : s.alternatives)
        if (other.term == i) others.push_back(other.effect.type);
      Cause cause{effect, parameters[i], s.p_values[i], gain_};
      cause.rms = rms(addition(t, s.model.coefficients(i)));
      add(std::move(cause), others);
    }
  }

  void of_scatter(const Scatter& scatter) {
    // Beside something that has no name, what scatters is its remainder.
    double unnamed = 0;
    for (const Unidentified& u : d_.unexplained)
      if (u.joint == e_.joint) unnamed = std::max(unnamed, u.amplitude);
    if (scatter.size < unnamed) return;
    if (scatter.effect) {
      Cause cause{*scatter.effect, {}, scatter.p_value, gain_};
      for (const auto& [name, value] : scatter.effect->numbers) {
        const double half = scatter.relative_error * std::abs(value);
        cause.parameters.push_back({name, value, value - half, value + half});
      }
      std::vector<std::string> others;
      if (scatter.alternative) others.push_back(scatter.alternative->type);
      add(std::move(cause), others);
    } else if (!scatter.structure.empty() && scatter.size > 0.25 * e_.step()) {
      d_.unexplained.push_back({e_.joint, scatter.structure, {}, {}, scatter.size});
    }
  }

 private:
  void add(Cause cause, const std::vector<std::string>& others) {
    std::set<std::string> told{cause.effect.type};
    for (const std::string& other : others)
      if (told.insert(other).second)
        d_.alternatives.push_back(
            {cause.effect.type, other, e_.joint, record_advice(cause.effect.type, other)});
    d_.causes.push_back(std::move(cause));
  }

  Diagnosis& d_;
  const Evidence& e_;
  const Gain& gain_;
  bool loaded_;  ///< the joint feels its weight
};

}  // namespace

void add(Diagnosis& d, const Finding& f, const Gain& gain, bool loaded) {
  Account account(d, f.evidence, gain, loaded);
  account.of_terms(*f.selection, f.scatter);
  account.of_scatter(f.scatter);
}

/// Whether a joint's own weight can turn it: where its axis is not upright.
bool feels_gravity(const OperationalModel& model, const Log& log, Eigen::Index joint) {
  const std::size_t n = model.chain.independent.size();
  Eigen::VectorXd q(static_cast<Eigen::Index>(n));
  for (std::size_t i = 0; i < n; ++i) {
    const auto column = log.find(LogSignal::reference, i);
    if (!column) return true;
    q[static_cast<Eigen::Index>(i)] = log.values(0, *column);
  }
  const Eigen::Vector3d axis = jacobian(model.chain, q).bottomRows<3>().col(joint);
  return axis.head<2>().norm() > 0.1 * axis.norm();
}

}  // namespace qerr
