#include "report/analysis/per_configuration.hpp"

#include "bound/configuration_batch.hpp"
#include "qerr/kinematics/coordinates.hpp"
#include "qerr/report/analysis.hpp"
#include "report/csv_text.hpp"

namespace qerr {

namespace {

std::string unit_in_brackets(const IndependentJoint& joint) { return joint.prismatic() ? " [m]" : " [rad]"; }

}  // namespace

std::string per_configuration_header(const Spec& spec, const std::vector<Eigen::VectorXd>& noise) {
  const std::vector<Coordinate> coordinates = coordinates_and_lengths(spec.model);
  std::string out;
  for (const IndependentJoint& joint : spec.model.chain.independent)
    out += (out.empty() ? "" : ",") + csv_cell(joint.name + unit_in_brackets(joint));
  for (const Coordinate c : coordinates)
    for (const char* bound : {"worst_case", "worst_case_rigorous", "sigma"})
      out += ",position." + std::string(info(c).name) + '.' + bound + " [" + std::string(info(c).unit) + ']';
  for (std::size_t f = 0; f < spec.filters.size(); ++f)
    for (const Coordinate c : coordinates)
      for (const char* bound : {"worst_case", "sigma", "sigma_in_motion"})
        if (bound != std::string("sigma_in_motion") || is_known(noise, f))
          out += ',' + csv_cell(spec.filters[f].name + '.' + std::string(info(c).name) + '.' + bound + " [" +
                                derivative_unit(c, spec.filters[f].filter) + ']');
  for (const Coordinate c : coordinates)  // the names before version 2
    for (const char* bound : {"worst_case", "worst_case_rigorous", "sigma"})
      out += ',' + std::string(info(c).name) + '.' + bound + " [" + std::string(info(c).unit) + ']';
  return out + ",tip.x [m],tip.y [m],tip.z [m]\r\n";
}

std::string per_configuration_rows(const Spec& spec, const std::vector<Eigen::VectorXd>& noise,
                                   const ConfigurationBatch& batch) {
  const FigureLayout& at = batch.layout;
  const bool own_worst = at.filtered_sigma > at.filtered_worst, own_sigma = at.in_motion > at.filtered_sigma;
  std::string out;
  Eigen::VectorXd q(static_cast<Eigen::Index>(spec.model.chain.independent.size()));
  for (std::size_t i = 0; i < batch.count; ++i) {
    const auto figure = [&](std::size_t f) { return batch.figures[f * batch_size + i]; };
    for (std::size_t j = 0; j < spec.model.chain.independent.size(); ++j)
      out += (j ? "," : "") + csv_number(batch.q[j * batch_size + i]);
    std::string positions;
    for (std::size_t c = 0; c < at.coordinates; ++c)
      for (const std::size_t of : {at.worst_case, at.rigorous, at.sigma})
        positions += ',' + csv_number(figure(of + c));
    out += positions;
    for (std::size_t f = 0; f < spec.filters.size(); ++f)
      for (std::size_t c = 0; c < at.coordinates; ++c) {
        const Norms& norms = spec.filters[f].norms;
        const std::size_t filtered = f * at.coordinates + c;
        out += ',' + csv_number(own_worst ? figure(at.filtered_worst + filtered)
                                          : norms.l1.upper * figure(at.worst_case + c));
        const bool known = sigma_is_known(spec.model.sources, f);  // else the cell is empty
        out += ',';
        if (known)
          out +=
              csv_number(own_sigma ? figure(at.filtered_sigma + filtered) : norms.h2 * figure(at.sigma + c));
        if (is_known(noise, f)) out += ',' + (known ? csv_number(figure(at.in_motion + filtered)) : "");
      }
    out += positions;
    for (Eigen::Index j = 0; j < q.size(); ++j) q[j] = batch.q[static_cast<std::size_t>(j) * batch_size + i];
    const Eigen::Vector3d tip = forward_kinematics(spec.model.chain, q).translation();
    for (const double x : tip) out += ',' + csv_number(x);
    out += "\r\n";
  }
  return out;
}

}  // namespace qerr
