#include <algorithm>
#include <array>
#include <map>
#include <mutex>

#include "core/parallel.hpp"
#include "input/read_sections.hpp"
#include "qerr/core/quantity.hpp"
#include "report/analysis/effects.hpp"
#include "report/analysis/figures.hpp"
#include "report/analysis/tables.hpp"
#include "report/sweep/sweep.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

SweepColumn sweep_column(const SweepAxis& axis, std::size_t number, std::size_t key) {
  SweepColumn column{axis.keys[key], {}, number, {}};
  std::optional<Dimension> dimension;
  std::vector<double> values;
  for (const SweepStep& step : axis.steps) {
    const bool entry = key < step.changes.size() && step.changes[key].second.starts_with('{');
    std::string why;
    const auto q = entry ? std::nullopt : parse_quantity(step.names[key], why);
    if (!q || (dimension && q->dimension && *dimension != *q->dimension)) return column;
    if (q->dimension) dimension = q->dimension;
    values.push_back(q->value);
  }
  if (!dimension) dimension = spec_format::dimension_of(column.key);
  column.values = std::move(values);
  column.unit = dimension ? unit_name(*dimension) : "";
  return column;
}

/// The first fault, without its place, which is the same for many variants.
std::string fault_text(const Error& error) {
  Fault fault = error.faults().front();
  fault.place = {};
  const std::string text = format({fault});
  constexpr std::string_view program = "qerr: ";  // in place of a place
  return text.starts_with(program) ? text.substr(program.size()) : text;
}

/// @param evaluate  what can fail
/// @returns whether it failed, because of the input
template <class Evaluate>
bool failed(SweptVariant& v, Evaluate evaluate) {
  try {
    evaluate();
    return false;
  } catch (const Error& e) {
    if (e.trouble() != Trouble::input) throw;
    v.fault = fault_text(e);
    return true;
  }
}

/// Building columns takes the time of about 2 variants, or 20 where frames are needed (ErrorColumns).
constexpr std::uint64_t fewest_sharing = 8;
/// Bytes of the columns of one robot.
constexpr double most_memory = 4e8;
/// Variants that are tried to find one that can be read.
constexpr std::uint64_t most_tried = 100;

/// Sections on which the columns do not depend.
bool is_light(const SweepAxis& axis) {
  constexpr std::array<std::string_view, 6> light{"encoders",  "filters", "requirements",
                                                  "threshold", "motion",  "effects"};
  return std::ranges::all_of(axis.keys, [&](const std::string& key) {
    return contains(light, key.substr(0, key.find_first_of(".[")));
  });
}

bool adds_effects(const SweepAxis& axis) {
  return std::ranges::any_of(axis.keys, [](const std::string& key) { return key.starts_with("effects"); }) ||
         std::ranges::any_of(axis.steps, [](const auto& s) { return !s.effects.empty(); });
}

/// The wanted statistics and those of the requirements; all of them where requirements vary.
std::vector<const StatisticKind*> with_requirements(std::vector<const StatisticKind*> wanted,
                                                    const Spec& spec, const SweepGrid& grid) {
  for (const std::string& key : grid.keys())
    if (key.starts_with("requirements")) return all_statistics();
  for (const Requirement& r : spec.requirements)
    for (const StatisticKind& kind : statistic_kinds())
      if (kind.value == r.value) wanted.push_back(&kind);
  return wanted;
}

struct Waiting {
  std::vector<SweptVariant*> variants;
  std::vector<std::vector<Norms>> norms;

  void evaluate(const ErrorColumns& columns, const ColumnStatistics& statistics) {
    std::vector<ColumnModel> models;
    for (std::size_t i = 0; i < variants.size(); ++i) {
      const Analysis& a = variants[i]->check->analysis;
      models.push_back(
          {&a.spec.model, &norms[i], error_weights(columns, a.spec.model, norms[i], a.noise_in_motion)});
    }
    std::vector<Workspace> results = workspaces(statistics, models);
    for (std::size_t i = 0; i < variants.size(); ++i)
      variants[i]->check->analysis.workspace = std::move(results[i]);
  }
};

constexpr std::size_t named_faults = 3, most_faults = 1000;

/// Faults, each with the first variant that has it, whatever the order in which threads meet them.
class Failures {
 public:
  explicit Failures(const SweepGrid& grid) : grid_(grid) {}

  void add(const SweptVariant& v) {
    const std::lock_guard lock(mutex_);
    const auto known = first_.find(v.fault);
    if (known != first_.end())
      known->second = std::min(known->second, v.variant);
    else if (first_.size() < most_faults)
      first_.emplace(v.fault, v.variant);
  }

  std::vector<std::string> some() const {
    std::vector<std::string> some;
    std::map<std::uint64_t, std::string> by_variant;
    for (const auto& [fault, variant] : first_) by_variant.emplace(variant, fault);
    for (const auto& [variant, fault] : by_variant)
      if (some.size() < named_faults)
        some.push_back("variant " + std::to_string(variant) + " (" + grid_.description(variant) +
                       "): " + fault);
    return some;
  }

 private:
  const SweepGrid& grid_;
  std::mutex mutex_;
  std::map<std::string, std::uint64_t> first_;
};

constexpr char end_of_verdicts = ' ';  // between those of a batch and its text

}  // namespace

SweepGrid::SweepGrid(const Spec& spec) : axes_(spec.sweep) {
  if (axes_.empty())
    throw spec_error(
        spec, "sweep", "the spec has none: there is nothing to vary", "",
        "add e.g. sweep: [{key: encoders.elbow.bits, values: [13, 15, 17]}] (qerr help variants)");
  double total = 1;
  for (const SweepAxis& axis : axes_) total *= static_cast<double>(axis.steps.size());
  if (total > 0x1p53)
    throw spec_error(spec, "sweep", "has more than 2^53 variants", "",
                     "let keys vary together (keys: [a, b], values: [[1, 2], [3, 4]]), or give fewer values");
  for (const SweepAxis& axis : axes_) {
    const auto number = static_cast<std::size_t>(&axis - axes_.data());
    for (std::size_t k = 0; k < axis.keys.size(); ++k) columns_.push_back(sweep_column(axis, number, k));
    count_ *= axis.steps.size();
    std::vector<Changes>& steps = changes_.emplace_back();
    for (const SweepStep& step : axis.steps) {
      Changes& changes = steps.emplace_back();
      for (const auto& [key, value] : step.changes)
        changes.values.push_back(spec_change(key, value, "sweep"));
      for (const std::string& effect : step.effects) changes.effects.push_back(parse_yaml(effect, "sweep"));
    }
  }
}

std::vector<std::string> SweepGrid::keys() const {
  std::vector<std::string> keys;
  for (const SweepAxis& axis : axes_) keys.insert(keys.end(), axis.keys.begin(), axis.keys.end());
  return keys;
}

std::vector<std::size_t> SweepGrid::steps(std::uint64_t variant) const {
  std::vector<std::size_t> steps(axes_.size());
  for (std::size_t a = axes_.size(); a-- > 0;) {
    steps[a] = variant % axes_[a].steps.size();
    variant /= axes_[a].steps.size();
  }
  return steps;
}

std::vector<std::string> SweepGrid::names(std::uint64_t variant) const {
  std::vector<std::string> names;
  const std::vector<std::size_t> chosen = steps(variant);
  for (std::size_t a = 0; a < axes_.size(); ++a) {
    const SweepStep& step = axes_[a].steps[chosen[a]];
    names.insert(names.end(), step.names.begin(), step.names.end());
  }
  return names;
}

std::string SweepGrid::description(std::uint64_t variant,
                                   const std::function<std::string(const std::string&)>& text) const {
  const std::vector<std::string> all_keys = keys(), values = names(variant);
  std::vector<std::string> all;
  for (std::size_t k = 0; k < all_keys.size(); ++k) all.push_back(all_keys[k] + " = " + text(values[k]));
  return joined(all);
}

Spec SweepGrid::spec(const SpecVariants& variants, const std::vector<std::size_t>& steps) const {
  std::vector<SpecChange> values;
  std::vector<Node> effects;
  for (std::size_t a = 0; a < axes_.size(); ++a) {
    const Changes& step = changes_[a][steps[a]];
    values.insert(values.end(), step.values.begin(), step.values.end());
    effects.insert(effects.end(), step.effects.begin(), step.effects.end());
  }
  return variants.variant(values, effects);
}

std::optional<Spec> SweepGrid::readable(const SpecVariants& variants,
                                        const std::vector<std::size_t>& steps) const {
  try {
    return spec(variants, steps);
  } catch (const Error& e) {
    if (e.trouble() != Trouble::input) throw;
    return std::nullopt;
  }
}

ColumnSweep::ColumnSweep(const SpecVariants& variants, const SweepGrid& grid, bool judged,
                         std::vector<const StatisticKind*> wanted, unsigned threads)
    : variants_(variants),
      grid_(grid),
      judged_(judged),
      wanted_(WantedStatistics::of(judged ? with_requirements(std::move(wanted), variants.base(), grid)
                                          : std::move(wanted))),
      threads_(threads),
      first_light_(grid.axes().size()) {
  while (first_light_ > 0 && is_light(grid.axes()[first_light_ - 1]))
    shared_ *= grid.axes()[--first_light_].steps.size();
  if (shared_ < fewest_sharing) shared_ = 1;
}

/// The sources of a variant and of those that differ from it in one axis of effects.
std::vector<IndependentError> ColumnSweep::sources(std::vector<std::size_t> steps) const {
  std::vector<IndependentError> all;
  const auto add = [&] {
    const auto spec = grid_.readable(variants_, steps);
    if (!spec) return;
    append(all, effect_report(*spec).sources);
  };
  add();
  for (std::size_t a = first_light_; a < steps.size(); ++a) {
    if (!adds_effects(grid_.axes()[a])) continue;
    const std::size_t own = steps[a];
    for (steps[a] = 0; steps[a] < grid_.axes()[a].steps.size(); ++steps[a])
      if (steps[a] != own) add();
    steps[a] = own;
  }
  return all;
}

std::shared_ptr<const ColumnSweep::Shared> ColumnSweep::computed(std::uint64_t group) const {
  auto result = std::make_shared<Shared>();
  result->group = group;
  for (std::uint64_t i = 0; i < std::min(shared_, most_tried); ++i) {
    const std::vector<std::size_t> steps = grid_.steps(group * shared_ + i);
    const auto spec = grid_.readable(variants_, steps);
    if (!spec) continue;
    const std::vector<IndependentError> places = sources(steps);
    const double numbers = static_cast<double>(size(spec->configurations)) *
                           static_cast<double>(spec->model.coordinates.size()) *
                           static_cast<double>(spec->model.transmission.encoders.size() + places.size());
    if (numbers * sizeof(double) > most_memory || !have_columns(spec->model)) break;
    result->columns = std::make_unique<ErrorColumns>(spec->model, places, spec->configurations, threads_);
    result->statistics = std::make_unique<ColumnStatistics>(*result->columns, wanted_, threads_);
    break;
  }
  return result;
}

std::shared_ptr<const ColumnSweep::Shared> ColumnSweep::shared(std::uint64_t group) const {
  const std::lock_guard lock(mutex_);
  if (!last_ || last_->group != group) {
    last_.reset();  // its memory is free before the next is built
    last_ = computed(group);
  }
  return last_;
}

/// Reads a variant and evaluates it, as `analyze` and `check` do; where the shared columns serve it, without
/// the bounds over the configurations, and without the requirements.
SweptVariant ColumnSweep::evaluated(std::uint64_t variant, const WorkspaceOptions& options,
                                    const Shared* shared) const {
  SweptVariant v{variant, {}, {}};
  const bool no_figures = failed(v, [&] {
    const Spec spec = grid_.spec(variants_, grid_.steps(variant));
    EffectReport effects = effect_report(spec);
    v.check.emplace(
        SpecCheck{unbounded_analysis(spec, std::move(effects), noise_in_motion(spec, options.threads)), {}});
    Analysis& a = v.check->analysis;
    const OperationalModel& model = a.spec.model;
    if (shared && shared->columns && have_columns(model) &&
        std::ranges::all_of(model.sources,
                            [&](const IndependentError& s) { return shared->columns->has_column(s); }))
      return;
    WorkspaceOptions all = options;
    all.noise_in_motion = a.noise_in_motion;
    a.workspace = workspace_with_quantization(model, filter_norms(a.spec), a.spec.configurations, all);
  });
  if (no_figures) v.check.reset();
  if (v.check && v.check->analysis.workspace.count > 0) judge(v);
  return v;
}

/// Evaluates the requirements of a variant whose bounds are computed.
void ColumnSweep::judge(SweptVariant& v) const {
  if (!judged_) return;
  const bool undecided = failed(v, [&] {
    Analysis& a = v.check->analysis;
    require_known(a.spec, a.effects);
    add_proofs(a, {}, 1);  // variants are evaluated on all threads
    v.check->results = requirement_results(a);
  });
  if (undecided) v.check->results.clear();
}

std::vector<SweptVariant> ColumnSweep::evaluate(std::span<const std::uint64_t> variants,
                                                unsigned inner_threads) const {
  std::vector<SweptVariant> results(variants.size());
  WorkspaceOptions options;
  options.threads = inner_threads;
  if (shared_ == 1) {
    for (std::size_t i = 0; i < variants.size(); ++i) results[i] = evaluated(variants[i], options, nullptr);
    return results;
  }
  for (std::size_t begin = 0, end; begin < variants.size(); begin = end) {
    const std::uint64_t group = variants[begin] / shared_;
    for (end = begin; end < variants.size() && variants[end] / shared_ == group;) ++end;
    const auto columns = shared(group);
    Waiting waiting;
    for (std::size_t i = begin; i < end; ++i) {
      results[i] = evaluated(variants[i], options, columns.get());
      if (!results[i].check || results[i].check->analysis.workspace.count > 0) continue;
      waiting.norms.push_back(filter_norms(results[i].check->analysis.spec));
      waiting.variants.push_back(&results[i]);
    }
    if (waiting.variants.empty()) continue;
    waiting.evaluate(*columns->columns, *columns->statistics);
    for (SweptVariant* v : waiting.variants) judge(*v);
  }
  return results;
}

char verdict_of(const SweptVariant& v, bool judged) {
  if (!v.fault.empty()) return 'e';
  if (!judged) return 'u';
  return v.check->all_met() ? 'y' : 'n';
}

bool count_verdict(SweepCounts& counts, char verdict) {
  ++counts.variants;
  counts.failed += verdict == 'e';
  counts.unmet += verdict == 'n';
  counts.unjudged += verdict == 'u';
  return std::string_view("enuy").find(verdict) != std::string_view::npos;
}

SweepOutcome run_sweep(const SweepJob& job, const SweepCounts& before,
                       const std::function<void(const std::string&, const SweepCounts&)>& write,
                       const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
  const ColumnSweep engine(job.variants, job.grid, job.judged, job.statistics, job.threads);
  const std::uint64_t begin = before.variants, total = job.size(), count = total > begin ? total - begin : 0;
  const std::uint64_t threads = thread_count(job.threads);
  // The variants of a batch are spread over all threads where they are few.
  const std::uint64_t batch = std::clamp<std::uint64_t>(count / threads, 1, engine.batch());
  const std::uint64_t batches = (count + batch - 1) / batch;
  Failures failures(job.grid);
  SweepOutcome outcome{before, {}};
  const auto inner_threads = static_cast<unsigned>(threads / std::clamp<std::uint64_t>(batches, 1, threads));
  texts_in_order(
      batches, static_cast<unsigned>(threads),
      [&](std::uint64_t i) {
        std::vector<std::uint64_t> variants;
        for (std::uint64_t v = i * batch; v < std::min(count, (i + 1) * batch); ++v)
          variants.push_back(job.shard.variant(begin + v));
        std::string verdicts, text;
        for (const SweptVariant& v : engine.evaluate(variants, inner_threads)) {
          if (!v.fault.empty()) failures.add(v);
          verdicts += verdict_of(v, job.judged);
          text += job.text(v);
        }
        return verdicts + end_of_verdicts + text;
      },
      [&](std::uint64_t i, const std::string& batch_text) {
        const std::size_t end = batch_text.find(end_of_verdicts);
        for (const char verdict : batch_text.substr(0, end)) count_verdict(outcome.counts, verdict);
        write(batch_text.substr(end + 1), outcome.counts);
        if (progress) progress(std::min(total, begin + (i + 1) * batch), total);
      });
  outcome.faults = failures.some();
  return outcome;
}

}  // namespace qerr
