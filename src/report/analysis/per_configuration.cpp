#include "report/analysis/per_configuration.hpp"

#include <cmath>
#include <limits>

#include "bound/figure_column.hpp"
#include "qerr/report/analysis.hpp"
#include "report/analysis/figure_names.hpp"
#include "report/csv_text.hpp"

namespace qerr {

namespace {

std::string unit_in_brackets(const std::string& unit) { return " [" + unit + ']'; }

/// The figures of the columns.
std::vector<FigureName> figures_of(const Spec& spec, const std::vector<Eigen::VectorXd>& noise) {
  std::vector<FigureName> figures = all_figures(spec);
  std::erase_if(figures, [&](const FigureName& name) {
    const auto [signal, filter, bound] = name.figure;
    return bound == Bound::sigma_quantization ||
           (bound == Bound::sigma_in_motion && !is_known(noise, static_cast<std::size_t>(filter)));
  });
  return figures;
}

}  // namespace

std::vector<std::string> per_configuration_names(const Spec& spec,
                                                 const std::vector<Eigen::VectorXd>& noise) {
  std::vector<std::string> names, positions;
  for (const IndependentJoint& joint : spec.model.chain.independent)
    names.push_back(joint.name + unit_in_brackets(joint.prismatic() ? "m" : "rad"));
  for (const FigureName& name : figures_of(spec, noise)) {
    names.push_back(name.quantity() + unit_in_brackets(name.unit));
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
  Eigen::VectorXd q(static_cast<Eigen::Index>(spec.model.chain.independent.size()));
  for (std::size_t i = 0; i < batch.count; ++i) {
    for (Eigen::Index j = 0; j < q.size(); ++j)
      numbers.push_back(q[j] = batch.q[static_cast<std::size_t>(j) * batch_size + i]);
    positions.clear();
    for (const FigureName& name : figures) {
      const Figure& f = name.figure;
      const FigureColumn column = figure_column(f, norms, batch.layout);
      const bool known = f.filter < 0 || !is_sigma(f.bound) ||
                         sigma_is_known(spec.model.sources, static_cast<std::size_t>(f.filter));
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
  std::string out;
  for (const std::string& name : per_configuration_names(spec, noise))
    out += (out.empty() ? "" : ",") + csv_cell(name);
  return out + "\r\n";
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
