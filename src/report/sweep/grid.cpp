#include "report/sweep/grid.hpp"

#include "input/spec_format.hpp"
#include "qerr/core/quantity.hpp"
#include "report/analysis/requirements.hpp"
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

}  // namespace qerr
