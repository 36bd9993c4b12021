#include "diagnose/search/cause_search.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/statistics.hpp"
#include "diagnose/search/contrast_test.hpp"
#include "diagnose/search/error_model.hpp"
#include "diagnose/search/found_causes.hpp"
#include "diagnose/search/refinement.hpp"
#include "diagnose/search/residual_scan.hpp"
#include "diagnose/search/rounding_test.hpp"
#include "diagnose/search/term_choice.hpp"
#include "qerr/effect/effect_kind.hpp"

namespace qerr {

namespace {

constexpr int most_passes = 7;

/// Smallest part of the largest error that is worth a term, since the shapes are idealizations: no gear has
/// exact sines.
constexpr double material_part = 0.012;

/// The smallest part for a table or polynomial, which follows a curve that is not its own only coarsely, and
/// of any uncatalogued term of a model that does not explain everything.
constexpr double material_part_of_table = 0.2;

/// Whether a term displaces the position on which the errors of gear teeth and disc depend.
bool acts_before_teeth(const Term& t) {
  if (!t.named() || t.constant) return false;
  const EffectKind& kind = effect_kind(t.effect.type);
  return kind.stage < Stage::gear || kind.first_in_stage;
}

/// At rest only a constant error is visible: one that rounding and noise do not have. It is a name.
FoundCauses at_rest(const Evidence& record, bool with_names) {
  const double mean = (record.measured - record.path).mean();
  if (!with_names || !record.encoder.zero_known || std::abs(mean) < record.step() + 4 * record.path_noise)
    return {};
  const auto constant = [](const RecordSignals& s) {
    std::vector<Term> all = named_terms(s);
    return *std::find_if(all.begin(), all.end(), [](const Term& t) { return t.constant; });
  };
  FoundCauses found;
  ChosenTerm offset;
  offset.candidate.term = constant(record);
  offset.candidate.family = offset.candidate.term.effect.type;
  offset.candidate.over = [constant](const Sampling& s) { return constant(s.evidence); };
  offset.coefficients = Eigen::VectorXd::Constant(1, mean);
  offset.p_value = 0;
  offset.lost = mean * mean, offset.rms = std::abs(mean);
  found.chosen.push_back(std::move(offset));
  return found;
}

class CauseSearch {
 public:
  CauseSearch(const Evidence& record, std::uint64_t seed, bool with_names)
      : record_(record),
        seed_(seed),
        samples_(error_samples(record, seed, most_samples)),
        dictionary_(samples_.sampling) {
    history_.names = with_names;
  }

  FoundCauses found() {
    if (samples_.size() < fewest_samples) return at_rest(record_, history_.names);
    history_.worth = history_.worth_of_shapes = material * record_.step();
    for (int pass = 0; pass < most_passes; ++pass) {
      model_.emplace(record_, samples_, dictionary_.candidates(scanned_, moved_), scanned_.events, excess_);
      choose();
      if (!learn(pass == 0)) break;
    }
    // Both loops end: no choice has a refuted family, and the dictionary has finitely many families.
    while (refute(without_contrast(*model_, choice_))) choose();
    while (refute(brought_by_rounding(*model_, choice_, seed_))) choose();
    distinguish_steps(*model_, choice_);
    return found_causes(*model_, choice_);
  }

 private:
  const Term& term(std::size_t i) const { return model_->term(choice_.chosen[i]); }
  Eigen::ArrayXd added(std::size_t i) const {
    return addition(term(i), model_->coefficients(choice_.chosen, choice_.fit, i));
  }
  std::vector<std::string> families(const LinearModel::Set& set) const {
    std::vector<std::string> names;
    for (const std::size_t g : set) names.push_back(model_->candidate(g).family);
    return names;
  }

  void choose() {
    choice_ = choose_terms(*model_, history_);
    history_.found = families(choice_.richest);
  }

  /// Updates what the next pass depends on.
  /// @returns whether anything changed
  bool learn(bool first) {
    bool changed = displace();
    changed |= reweigh();
    changed |= raise_worth();
    changed |= refine_shapes(*model_, choice_, scanned_);
    // Once a scan has added nothing to the model, another one would only find the same.
    std::vector<std::string> now = families(choice_.chosen);
    std::sort(now.begin(), now.end());
    if (first || now != families_) changed |= scan(first);
    families_ = std::move(now);
    return changed;
  }

  bool displace() {
    Eigen::ArrayXd moved = Eigen::ArrayXd::Zero(samples_.size());
    for (std::size_t i = 0; i < choice_.chosen.size(); ++i)
      if (acts_before_teeth(term(i))) moved += added(i);
    const Eigen::ArrayXd before = moved_.size() > 0 ? moved_ : Eigen::ArrayXd::Zero(samples_.size());
    const bool changed = (moved - before).abs().maxCoeff() > 2 * record_.step();
    if (changed) moved_ = std::move(moved);
    return changed;
  }

  /// What is left beyond the stated variance: in its mean, and, where it is independent from row to row, as
  /// the slower and the faster half of the samples have it. A structure that is still to be found is no
  /// jitter.
  bool reweigh() {
    const Eigen::ArrayXd used = (model_->weight() > 0).cast<double>();
    const double rows = model_->rows(), free = static_cast<double>(choice_.fit.coefficients.size());
    const Eigen::ArrayXd squares =
        choice_.residual.square() * rows / std::max(1.0, rows - free) - samples_.variance;
    const Eigen::ArrayXd speed = samples_.sampling.evidence.velocity.square();
    const auto mean = [&](const Eigen::ArrayXd& x, const Eigen::ArrayXd& of) {
      return (x * of).sum() / std::max(1.0, of.sum());
    };
    ExcessVariance now{std::max(0.0, mean(squares, used)), 0};
    const double middle = median({speed.begin(), speed.end()});
    const Eigen::ArrayXd fast = used * (speed > middle).cast<double>(), slow = used - fast;
    const double apart = mean(speed, fast) - mean(speed, slow);
    if (choice_.correlation < 1.5 && apart > 0) {
      now.per_speed = std::max(0.0, (mean(squares, fast) - mean(squares, slow)) / apart);
      now.constant = std::max(0.0, mean(squares, slow) - now.per_speed * mean(speed, slow));
    }
    const double before = mean(excess_.at(samples_.sampling.evidence), used),
                 after = mean(now.at(samples_.sampling.evidence), used);
    const bool changed = std::abs(after - before) > 0.1 * (after + model_->mean_of_used(samples_.variance));
    excess_ = now;
    return changed;
  }

  bool raise_worth() {
    double worth = material * record_.step(), of_shapes = worth;
    const bool incomplete = !model_->is_complete(choice_.chosen);
    for (std::size_t i = 0; i < choice_.chosen.size(); ++i) {
      const Term& t = term(i);
      const bool table = model_->is_table(choice_.chosen[i]);
      if (!table && !t.harmonic && !t.reshaped && !t.hysteresis && !t.step && t.named()) continue;
      const double size = standard_deviation(added(i));
      const bool coarse = table || (incomplete && !t.named());
      worth = std::max(worth, (coarse ? material_part_of_table : material_part) * size);
      if (!table) of_shapes = std::max(of_shapes, material_part * size);
    }
    const bool changed = std::abs(worth - history_.worth) > 0.2 * history_.worth;
    history_.worth = worth, history_.worth_of_shapes = of_shapes;
    return changed;
  }

  /// Scans the residual; at first also the error itself, in which terms that imitate an event do not hide it.
  /// Tables are left out, which would absorb what a scan is to find.
  bool scan(bool first) {
    const bool any = first && scan_residual(*model_, model_->residual({}, model_->fit({})), scanned_);
    if (first && choice_.chosen.empty()) return any;
    LinearModel::Set curves;
    for (const std::size_t g : choice_.chosen)
      if (!model_->is_table(g)) curves.push_back(g);
    return scan_residual(*model_, model_->residual(curves, model_->fit(curves)), scanned_) || any;
  }

  bool refute(const std::vector<std::string>& refuted) {
    history_.refuted.insert(history_.refuted.end(), refuted.begin(), refuted.end());
    return !refuted.empty();
  }

  const Evidence& record_;
  std::uint64_t seed_;
  ErrorSamples samples_;
  Dictionary dictionary_;
  Scanned scanned_;
  ChoiceHistory history_;
  std::vector<std::string> families_;  ///< of the previous pass's choice
  Eigen::ArrayXd moved_;               ///< displacement on which the errors of teeth and disc depend
  ExcessVariance excess_;
  std::optional<ErrorModel> model_;
  Choice choice_;
};

}  // namespace

FoundCauses search_causes(const Evidence& record, std::uint64_t seed, bool with_names) {
  return CauseSearch(record, seed, with_names).found();
}

}  // namespace qerr
