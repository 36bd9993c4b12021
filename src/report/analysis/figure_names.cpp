#include <cmath>
#include <limits>

#include "bound/batched_error.hpp"
#include "report/analysis/figures.hpp"
#include "report/analysis/tables.hpp"
#include "report/formats.hpp"

namespace qerr {

namespace {

FigureName name_of(const Spec& spec, const Signal& s, const Figure& f) {
  const NamedFilter* filter = f.filter < 0 ? nullptr : &spec.filters[f.filter];
  if (filter && filter->controller)
    return {f,
            "torque",
            "",
            s.name,
            derivative_unit(s.unit, filter->filter),
            name_of(f.bound),
            shown_unit(s.unit, filter->filter)};
  if (is_closed(s))  // closed_torque.a1
    return {f, s.kind->group, "", s.name.substr(s.kind->group.size() + 1), s.unit, name_of(f.bound), s.unit};
  return {f,
          filter ? "derivative" : "position",
          filter ? filter->name : "",
          s.name,
          filter ? derivative_unit(s.unit, filter->filter) : s.unit,
          name_of(f.bound),
          filter ? shown_unit(s.unit, filter->filter) : s.unit};
}

/// Whether the figures of a signal behind a filter (-1: none) exist.
bool is_passed(const Spec& spec, std::ptrdiff_t filter, const Signal& s) {
  return filter < 0 || is_filtered(spec.filters[filter], s);
}

std::vector<FigureName> figures_of(const Spec& spec, const std::vector<Eigen::VectorXd>& noise) {
  std::vector<FigureName> figures = all_figures(spec);
  std::erase_if(figures, [&](const FigureName& name) {
    const auto [signal, filter, bound] = name.figure;
    return bound == Bound::sigma_quantization ||
           (bound == Bound::sigma_in_motion && !is_known(noise, filter));
  });
  return figures;
}

}  // namespace

std::string FigureName::quantity() const {
  return (filter.empty() ? std::string(signal) : filter) + '.' + coordinate + '.' + std::string(bound);
}

FigureName name_of(const Spec& spec, const Figure& f) {
  return name_of(spec, all_signals(spec.model)[f.signal], f);
}

std::vector<FigureName> all_figures(const Spec& spec) {
  const std::vector<Signal> signals = all_signals(spec.model);
  std::vector<FigureName> figures;
  const auto add = [&](std::ptrdiff_t filter) {
    for (std::size_t s = 0; s < signals.size(); ++s)
      if (is_passed(spec, filter, signals[s]))
        for (const Bound bound : bounds_of(filter >= 0))
          if (bound != Bound::worst_case_rigorous || !is_closed(signals[s]))  // a loop is linear as it is
            figures.push_back(name_of(spec, signals[s], {s, filter, bound}));
  };
  for (std::ptrdiff_t f = -1; f < std::ssize(spec.filters); ++f) add(f);
  return figures;
}

void for_each_figure(const Analysis& a, const std::function<void(const FigureName&, const Statistic&)>& see) {
  for (const FigureName& name : all_figures(a.spec)) {
    const Statistic* const s = statistic_of(a.workspace, name.figure);
    if (s && (std::isfinite(s->min) || name.figure.bound != Bound::worst_case_rigorous)) see(name, *s);
  }
}

std::vector<SingleFigure> single_figures(const Analysis& a) {
  std::vector<SingleFigure> all;
  if (a.control) all = control_rows(a.spec, *a.control);
  EncoderSpeeds speeds;
  for (std::size_t i = 0; i < a.spec.encoder_figures.size(); ++i) {
    const std::optional<CountLimit> limit = count_limit(a.spec, i);
    if (!limit) continue;
    if (speeds.empty()) speeds = encoder_speeds(a.spec);
    const std::string encoder = "encoder." + a.spec.model.chain.independent[i].name;
    if (speeds[i]) all.push_back({encoder + ".count_rate", "1/s", "max", count_rate(a.spec, i, *speeds[i])});
    all.push_back({encoder + ".max_count_rate", "1/s", "max", limit->rate});
  }
  return all;
}

std::string to_csv(const Analysis& a, const Style&) {
  return std::string(analysis_csv_header) + "\r\n" + analysis_csv_rows(a, "", all_statistics());
}

std::vector<const StatisticKind*> all_statistics() {
  std::vector<const StatisticKind*> all;
  for (const StatisticKind& kind : statistic_kinds()) all.push_back(&kind);
  return all;
}

std::string analysis_csv_rows(const Analysis& a, const std::string& before,
                              const std::vector<const StatisticKind*>& statistics) {
  std::string out;
  for_each_figure(a, [&](const FigureName& name, const Statistic& s) {
    const std::string prefix = before + std::string(name.signal) + ',' + csv_cell(name.filter) + ',' +
                               csv_cell(name.coordinate) + ',' + name.unit + ',' + std::string(name.bound) +
                               ',';
    for (const StatisticKind* kind : statistics)
      out += prefix + std::string(kind->name) + ',' + csv_number(s.*kind->value) + "\r\n";
    const ProvenMaximum* const proven = find_proof(a, name.figure);
    if (!proven) return;
    out += prefix + "proven_lower," + csv_number(proven->lower) + "\r\n";
    out += prefix + std::string(proven_statistic) + ',' + csv_number(proven->upper) + "\r\n";
  });
  for (const StatisticKind* kind : statistics) {
    if (kind->name != "mean") continue;  // the encoders' parts of the mean variance
    const std::vector<double> budget = encoder_budget(a);
    for (std::size_t i = 0; i < budget.size(); ++i)
      out += before + "budget,," + csv_cell(a.spec.model.chain.independent[i].name) + ",,share,mean," +
             csv_number(budget[i]) + "\r\n";
  }
  for (const SingleFigure& f : single_figures(a)) {
    const std::size_t first = f.quantity.find('.'), last = f.quantity.rfind('.');
    out += before + f.quantity.substr(0, first) + ",," +
           csv_cell(f.quantity.substr(first + 1, last - first - 1)) + ',' + f.unit + ',' +
           f.quantity.substr(last + 1) + ',' + std::string(f.statistic) + ',' + csv_number(f.value) + "\r\n";
  }
  return out;
}

Eigen::VectorXd configuration_of(const ConfigurationBatch& batch, std::size_t i, const Chain& chain) {
  Eigen::VectorXd q(std::ssize(chain.independent));
  for (Eigen::Index j = 0; j < q.size(); ++j) q[j] = batch.q[static_cast<std::size_t>(j) * batch_size + i];
  return q;
}

std::vector<std::string> per_configuration_names(const Spec& spec,
                                                 const std::vector<Eigen::VectorXd>& noise) {
  std::vector<std::string> names, positions;
  for (const IndependentJoint& joint : spec.model.chain.independent)
    names.push_back(joint.name + (joint.prismatic() ? " [m]" : " [rad]"));
  for (const FigureName& name : figures_of(spec, noise)) {
    names.push_back(name.quantity() + " [" + name.unit + ']');
    if (name.signal == "position") positions.push_back(names.back().substr(name.signal.size() + 1));
  }
  names.insert(names.end(), positions.begin(), positions.end());  // the names before version 2
  for (const char* of_tip : {"tip.x [m]", "tip.y [m]", "tip.z [m]"}) names.emplace_back(of_tip);
  return names;
}

std::vector<double> per_configuration_numbers(const Spec& spec, const std::vector<Eigen::VectorXd>& noise,
                                              const ConfigurationBatch& batch) {
  const std::vector<FigureName> figures = figures_of(spec, noise);
  const std::vector<Norms> norms = filter_norms(spec);
  std::vector<double> numbers, positions;
  for (std::size_t i = 0; i < batch.count; ++i) {
    const Eigen::VectorXd q = configuration_of(batch, i, spec.model.chain);
    numbers.insert(numbers.end(), q.begin(), q.end());
    positions.clear();
    for (const FigureName& name : figures) {
      const Figure& f = name.figure;
      const FigureColumn column = figure_column(f, norms, batch.layout);
      const bool known = f.filter < 0 || !is_sigma(f.bound) || sigma_is_known(spec.model.sources, f.filter);
      numbers.push_back(known ? column.factor * batch.figures[column.figure * batch_size + i]
                              : std::numeric_limits<double>::quiet_NaN());
      if (name.signal == "position") positions.push_back(numbers.back());
    }
    numbers.insert(numbers.end(), positions.begin(), positions.end());
    for (const double x : forward_kinematics(spec.model.chain, q).translation().eval()) numbers.push_back(x);
  }
  return numbers;
}

std::string per_configuration_header(const Spec& spec, const std::vector<Eigen::VectorXd>& noise) {
  return joined(per_configuration_names(spec, noise), ",", csv_cell) + "\r\n";
}

std::string per_configuration_rows(const Spec& spec, const std::vector<Eigen::VectorXd>& noise,
                                   const ConfigurationBatch& batch) {
  const std::vector<double> numbers = per_configuration_numbers(spec, noise, batch);
  const std::size_t columns = batch.count > 0 ? numbers.size() / batch.count : 0;
  std::string out;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (!std::isnan(numbers[i])) out += csv_number(numbers[i]);
    out += (i + 1) % columns == 0 ? "\r\n" : ",";
  }
  return out;
}

}  // namespace qerr
