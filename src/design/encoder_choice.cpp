#include "design/encoder_choice.hpp"

#include <algorithm>

#include "core/lists.hpp"

namespace qerr {

namespace {

OptionChoice first_permitted(const std::vector<std::size_t>& offsets, const PermittedOptions& permitted) {
  OptionChoice choice;
  for (std::size_t j = 0; j + 1 < offsets.size(); ++j) {
    std::size_t o = offsets[j];
    while (!permitted[o]) ++o;
    choice.push_back(o - offsets[j]);
  }
  return choice;
}

std::size_t permitted_count(const std::vector<std::size_t>& offsets, const PermittedOptions& permitted,
                            std::size_t joint) {
  return std::count(permitted.begin() + offsets[joint], permitted.begin() + (offsets[joint + 1]), char{1});
}

}  // namespace

EncoderSearch::EncoderSearch(const ChoiceProblem& problem)
    : problem_(problem),
      offsets_(option_offsets(problem)),
      cuts_(problem),
      last_failure_(problem.figures.size()) {
  for (const ChoiceFigure& f : problem.figures) samples_.emplace_back(f, problem.configurations);
  cuts_.begin(std::vector<double>(problem.figures.size(), std::numeric_limits<double>::infinity()),
              PermittedOptions(offsets_.back(), 1));
}

/// Whether option a is no dearer than b, no coarser in any column, and precedes it in the order of choices.
/// Figures that only `judge` knows do not tell.
bool EncoderSearch::dominates(std::size_t joint, std::size_t a, std::size_t b) const {
  const auto& prices = problem_.prices[joint];
  if (prices[a] > prices[b] || (prices[a] == prices[b] && a > b)) return false;
  for (const ChoiceFigure& figure : problem_.figures) {
    if (!figure.monotone || figure.sums.empty()) return false;
    for (const WeightedSum& sum : figure.sums)
      for (const WeightedColumn& c : sum.columns)
        if (c.joint == joint && c.weights[a] > c.weights[b]) return false;
  }
  return true;
}

/// Without the options that as many others dominate as choices are looked for: each of these others gives a
/// choice that precedes. Those that dominate precede, and as many of them are kept themselves, since what
/// dominates one that is not kept dominates the option, too.
PermittedOptions EncoderSearch::undominated(std::size_t kept) const {
  PermittedOptions permitted(offsets_.back(), 0);
  for (std::size_t j = 0; j < problem_.joints(); ++j) {
    std::vector<std::size_t> options;
    for (std::size_t b = 0; b < problem_.prices[j].size(); ++b) {
      std::size_t dominating = 0;
      for (std::size_t a = 0; a < options.size() && dominating < kept; ++a)
        dominating += dominates(j, options[a], b);
      if (dominating >= kept) continue;
      options.push_back(b);
      permitted[offsets_[j] + b] = 1;
    }
  }
  return permitted;
}

void EncoderSearch::begin(const ChoiceRequest& request) {
  request_ = request;
  best_.clear();
  ended_ = false;
  work_ = 0;
  cuts_at_refresh_ = 0;
  open_bound_ = std::numeric_limits<std::int64_t>::max();
  all_ = undominated(request.wanted + request.excluded.size());
  cuts_.begin(request.limits, all_);
}

std::int64_t EncoderSearch::most() const {
  return best_.size() < request_.wanted ? request_.most : std::min(request_.most, best_.back().first);
}

/// Keeps a choice that meets the limits if it is among the best ones.
bool EncoderSearch::keep(const OptionChoice& choice) {
  const Priced priced{price_of(problem_, choice), choice};
  if (priced.first > request_.most || contains(best_, priced) || contains(request_.excluded, choice))
    return false;
  best_.insert(std::ranges::upper_bound(best_, priced), priced);
  if (best_.size() <= request_.wanted) return true;
  const bool kept = best_.back() != priced;
  best_.pop_back();
  return kept;
}

void EncoderSearch::learn(std::size_t f, const SumWeights& weights, const LimitTest& test) {
  const ChoiceFigure& figure = problem_.figures[f];
  switch (figure.over) {
    case ChoiceFigure::Over::largest:
      last_failure_[f] = test.worst;
      cuts_.add(cut_at_configuration(figure, f, problem_, weights, test.worst));
      break;
    case ChoiceFigure::Over::mean:
      cuts_.add(tangent_of_mean(figure, f, problem_, weights));
      work_ += static_cast<double>(problem_.configurations * problem_.joints());
      break;
    case ChoiceFigure::Over::percentile:
      samples_[f].add(test.beyond);
      cuts_.add(cut_at_configuration(figure, f, problem_, weights, test.worst), true);
      break;
    case ChoiceFigure::Over::least:
      break;
  }
}

bool EncoderSearch::meets(std::size_t f, const OptionChoice& choice, double limit, bool learning) {
  const auto known = compared_.find(choice);
  if (known != compared_.end()) {
    if (limit >= known->second[f].met) return true;
    if (limit <= known->second[f].failed) return false;
  }
  const ChoiceFigure& figure = problem_.figures[f];
  const SumWeights weights = weights_of(figure, choice);
  for (const auto& of_sum : weights) work_ += static_cast<double>(problem_.configurations * of_sum.size());
  const LimitTest test =
      compare_with_limit(figure, weights, limit, problem_.configurations, last_failure_[f]);
  if (test.met && known != compared_.end()) known->second[f].met = limit;
  if (!test.met && learning) {
    if (known != compared_.end()) known->second[f].failed = limit;
    learn(f, weights, test);
  }
  return test.met;
}

EncoderSearch::Leaf EncoderSearch::evaluate(const OptionChoice& choice) {
  bool judged = false;
  const std::size_t figures = problem_.figures.size();
  for (std::size_t i = 0, first = failed_; i < figures; ++i) {
    const std::size_t f = (first + i) % figures;
    const ChoiceFigure& figure = problem_.figures[f];
    const double limit = request_.limits[f];
    if (limit == std::numeric_limits<double>::infinity()) continue;
    judged = judged || figure.sums.empty() || figure.bound;
    if (figure.sums.empty() || meets(f, choice, limit * (1 - figure.tolerance), false)) continue;
    judged = true;  // near a limit, rounding decides: the figures of the report do
    if (meets(f, choice, limit * (1 + figure.tolerance), true)) continue;
    failed_ = f;
    return Leaf::failed;
  }
  if (judged && problem_.judge) {
    ChoiceProblem::Verdict verdict = problem_.judge(choice, request_.limits);
    work_ += verdict.work;
    for (ChoiceCut& cut : verdict.cuts) cuts_.add(std::move(cut));
    if (!verdict.met) return Leaf::failed;
  }
  compared_.try_emplace(choice, figures);
  return Leaf::met;
}

bool EncoderSearch::restrict(PermittedOptions& permitted, std::int64_t& bound) {
  constexpr int most_rounds = 2;
  for (int round = 0; round < most_rounds; ++round) {
    if (!cuts_.restrict(permitted, most(), bound, work_)) return false;
    const PermittedOptions before = permitted;
    for (std::size_t f = 0; f < samples_.size(); ++f)
      if (!samples_[f].restrict(request_.limits[f], offsets_, permitted, work_)) return false;
    if (permitted == before) break;
  }
  // The last removal by a sample may have taken a joint's last option.
  for (std::size_t j = 0; j < problem_.joints(); ++j)
    if (permitted_count(offsets_, permitted, j) == 0) return false;
  return true;
}

bool EncoderSearch::cannot_precede(const PermittedOptions& permitted, std::int64_t bound) const {
  if (best_.size() < request_.wanted) return false;
  return bound > best_.back().first ||
         (bound == best_.back().first && first_permitted(offsets_, permitted) >= best_.back().second);
}

void EncoderSearch::refresh_multipliers() {
  if (cuts_.size() < cuts_at_refresh_ + std::max<std::size_t>(10, cuts_at_refresh_ / 4)) return;
  cuts_at_refresh_ = cuts_.size();
  cuts_.improve_multipliers(all_, best_.empty() ? std::nullopt : std::optional(best_.back().first), work_);
}

void EncoderSearch::explore(PermittedOptions permitted) {
  if (request_.progress) request_.progress(work_ / request_.work);
  std::int64_t bound = 0;
  if (!restrict(permitted, bound) || cannot_precede(permitted, bound)) return;
  if (ended_ || work_ > request_.work) {
    ended_ = true;
    open_bound_ = std::min(open_bound_, bound);
    return;
  }
  std::size_t joint = 0;
  while (joint < problem_.joints() && permitted_count(offsets_, permitted, joint) == 1) ++joint;
  if (joint == problem_.joints()) {
    const OptionChoice choice = first_permitted(offsets_, permitted);
    if (evaluate(choice) == Leaf::met) keep(choice);
    refresh_multipliers();
    return;
  }
  for (std::size_t o = offsets_[joint]; o < offsets_[joint + 1]; ++o) {
    if (!permitted[o]) continue;
    PermittedOptions child = permitted;
    for (std::size_t other = offsets_[joint]; other < offsets_[joint + 1]; ++other) child[other] = other == o;
    explore(std::move(child));
  }
}

/// From the finest permitted options, the cheapest steps that cuts and guides allow, most saving for its
/// usage first. Empty if even the finest options are beyond a cut.
std::optional<OptionChoice> EncoderSearch::guided_choice(const PermittedOptions& permitted) const {
  OptionChoice choice;
  for (std::size_t j = 0; j < problem_.joints(); ++j) {
    std::size_t last = problem_.prices[j].size();
    while (!permitted[offsets_[j] + --last]) {
    }
    choice.push_back(last);
  }
  double used = cuts_.usage(choice);
  if (used > 1) return std::nullopt;
  while (true) {
    double best_worth = 0, best_usage = 0;
    std::size_t joint = 0, option = 0;
    for (std::size_t j = 0; j < choice.size(); ++j)
      for (std::size_t o = 0; o < problem_.prices[j].size(); ++o) {
        const auto saving = static_cast<double>(problem_.prices[j][choice[j]] - problem_.prices[j][o]);
        if (!permitted[offsets_[j] + o] || saving <= 0) continue;
        OptionChoice changed = choice;
        changed[j] = o;
        const double usage = cuts_.usage(changed);
        constexpr double free = 1e-3;  // of a limit: steps that use less compare by their saving
        const double worth = saving / (std::max(usage - used, 0.0) + free);
        if (usage <= 1 && worth > best_worth) {
          best_worth = worth;
          best_usage = usage;
          joint = j;
          option = o;
        }
      }
    if (best_worth == 0) return choice;
    choice[joint] = option;
    used = best_usage;
  }
}

/// Replaces single options of the best choice by cheaper ones as long as the limits are met.
void EncoderSearch::cheapen() {
  for (bool better = true; better && !best_.empty();) {
    better = false;
    const OptionChoice best = best_.front().second;
    for (std::size_t j = 0; j < problem_.joints() && !better; ++j)
      for (std::size_t o = 0; o < best[j] && !better; ++o) {
        OptionChoice changed = best;
        changed[j] = o;
        if (!all_[offsets_[j] + o] || price_of(problem_, changed) >= best_.front().first) continue;
        if (cuts_.usage(changed) > 1.02) continue;  // guides are near the percentile, not at it
        better = evaluate(changed) == Leaf::met && keep(changed);
      }
    if (work_ > request_.work / 4) return;
  }
}

/// A good choice to begin with, which the bounds are compared with.
void EncoderSearch::find_first(const PermittedOptions& permitted) {
  constexpr int most_attempts = 100;
  for (int i = 0; i < most_attempts && work_ < request_.work / 4; ++i) {
    const auto choice = guided_choice(permitted);
    if (!choice) break;
    const std::size_t known = cuts_.size();
    if (evaluate(*choice) == Leaf::met) {
      keep(*choice);
      break;
    }
    if (cuts_.size() == known) break;
  }
  cheapen();
}

ChoiceResult EncoderSearch::find(const ChoiceRequest& request) {
  begin(request);
  for (const OptionChoice& choice : request.known)
    if (price_of(problem_, choice) <= request.most && evaluate(choice) == Leaf::met) keep(choice);
  PermittedOptions root = all_;
  std::int64_t bound = 0;
  if (restrict(root, bound)) {
    if (best_.empty()) find_first(root);
    cuts_at_refresh_ = 0;
    refresh_multipliers();
    explore(all_);
  }
  ChoiceResult result;
  for (const Priced& p : best_) result.best.push_back(p.second);
  result.proven = !ended_;
  result.work = work_;
  result.bound = result.proven   ? (best_.empty() ? 0 : best_.front().first)
                 : best_.empty() ? open_bound_
                                 : std::min(open_bound_, best_.front().first);
  return result;
}

}  // namespace qerr
