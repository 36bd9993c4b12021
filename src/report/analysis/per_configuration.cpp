#include "report/analysis/per_configuration.hpp"

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

std::string per_configuration_header(const Spec& spec, const std::vector<Eigen::VectorXd>& noise) {
  std::string out, positions;
  for (const IndependentJoint& joint : spec.model.chain.independent)
    out +=
        (out.empty() ? "" : ",") + csv_cell(joint.name + unit_in_brackets(joint.prismatic() ? "m" : "rad"));
  for (const FigureName& name : figures_of(spec, noise)) {
    const std::string column = name.quantity() + unit_in_brackets(name.unit);
    out += ',' + csv_cell(column);
    if (name.signal == "position") positions += ',' + csv_cell(column.substr(name.signal.size() + 1));
  }
  return out + positions + ",tip.x [m],tip.y [m],tip.z [m]\r\n";  // `positions`: the names before version 2
}

std::string per_configuration_rows(const Spec& spec, const std::vector<Eigen::VectorXd>& noise,
                                   const ConfigurationBatch& batch) {
  const std::vector<FigureName> figures = figures_of(spec, noise);
  const std::vector<Norms> norms = filter_norms(spec);
  std::string out;
  Eigen::VectorXd q(static_cast<Eigen::Index>(spec.model.chain.independent.size()));
  for (std::size_t i = 0; i < batch.count; ++i) {
    for (Eigen::Index j = 0; j < q.size(); ++j) {
      q[j] = batch.q[static_cast<std::size_t>(j) * batch_size + i];
      out += (j ? "," : "") + csv_number(q[j]);
    }
    std::string positions;
    for (const FigureName& name : figures) {
      const Figure& f = name.figure;
      const FigureColumn column = figure_column(f, norms, batch.layout);
      out += ',';
      if (f.filter >= 0 && is_sigma(f.bound) &&
          !sigma_is_known(spec.model.sources, static_cast<std::size_t>(f.filter)))
        continue;  // an empty cell
      const std::string cell = csv_number(column.factor * batch.figures[column.figure * batch_size + i]);
      out += cell;
      if (name.signal == "position") positions += ',' + cell;
    }
    out += positions;
    for (const double x : forward_kinematics(spec.model.chain, q).translation().eval())
      out += ',' + csv_number(x);
    out += "\r\n";
  }
  return out;
}

}  // namespace qerr
