#include <cmath>

#include "bound/configuration_batch.hpp"
#include "qerr/kinematics/coordinates.hpp"
#include "report/writers.hpp"

namespace qerr {

namespace {

/// An unbounded figure is an empty cell: plotting tools read it as missing.
std::string number(double value) { return std::isfinite(value) ? shortest(value) : std::string(); }

void add_statistic(std::string& out, const std::string& prefix, const Statistic& s) {
  for (const StatisticKind& kind : statistic_kinds())
    out += prefix + ',' + std::string(kind.name) + ',' + number(s.*kind.value) + "\r\n";
}

std::string unit_in_brackets(const IndependentJoint& joint) { return joint.prismatic() ? " [m]" : " [rad]"; }

}  // namespace

std::string csv_cell(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

std::string to_csv(const Analysis& a) {
  std::string out = "signal,filter,coordinate,unit,bound,statistic,value\r\n";
  for (std::size_t i = 0; i < a.workspace.coordinates.size(); ++i) {
    const CoordinateInfo& c = info(a.spec.model.coordinates[i]);
    const std::string prefix = "position,," + std::string(c.name) + ',' + std::string(c.unit) + ',';
    add_statistic(out, prefix + "worst_case", a.workspace.coordinates[i].worst_case);
    if (std::isfinite(a.workspace.coordinates[i].worst_case_rigorous.min))
      add_statistic(out, prefix + "worst_case_rigorous", a.workspace.coordinates[i].worst_case_rigorous);
    add_statistic(out, prefix + "sigma", a.workspace.coordinates[i].sigma);
  }
  for (std::size_t f = 0; f < a.spec.filters.size(); ++f)
    for (std::size_t i = 0; i < a.workspace.coordinates.size(); ++i) {
      const Coordinate c = a.spec.model.coordinates[i];
      const std::string prefix = "derivative," + csv_cell(a.spec.filters[f].name) + ',' +
                                 std::string(info(c).name) + ',' +
                                 derivative_unit(c, a.spec.filters[f].filter.derivative) + ',';
      add_statistic(out, prefix + "worst_case", a.workspace.derivatives[f][i].worst_case);
      add_statistic(out, prefix + "sigma", a.workspace.derivatives[f][i].sigma);
      if (const auto& moving = a.workspace.derivatives[f][i].sigma_in_motion)
        add_statistic(out, prefix + "sigma_in_motion", *moving);
    }
  return out;
}

std::string check_csv(const Analysis& a) {
  std::string out = "quantity,statistic,at_most,value,unit,met\r\n";
  for (const Requirement& r : a.spec.requirements) {
    const RequirementResult result = evaluate(r, a.workspace);
    out += csv_cell(r.quantity) + ',' + r.statistic + ',' + number(r.at_most) + ',' + number(result.value) +
           ',' + r.unit + ',' + (result.met ? "true" : "false") + "\r\n";
  }
  return out;
}

std::string threshold_csv(const std::vector<ThresholdRow>& rows) {
  std::string out =
      "robot,counts_per_rev,gear_ratio,length_mm,sample_rate_hz,resolution_mm,threshold_velocity_mm_s,"
      "resolution_mm_as_printed,threshold_velocity_mm_s_as_printed\r\n";
  for (const ThresholdRow& r : rows) {
    out += csv_cell(r.robot);
    for (const double value : {r.counts_per_rev, r.gear_ratio, 1e3 * r.length, r.sample_rate,
                               1e3 * r.resolution, 1e3 * r.threshold_velocity(),
                               1e3 * r.resolution_as_printed, 1e3 * r.threshold_velocity_as_printed()})
      out += ',' + number(value);
    out += "\r\n";
  }
  return out;
}

std::string rows_csv(const std::vector<ListRow>& rows) {
  std::string out = "name,parameter,unit,default,meaning";
  for (const auto& note : rows.front().notes) out += ',' + note.first;
  out += "\r\n";
  for (const ListRow& row : rows) {
    out += csv_cell(row.name) + ",,,," + csv_cell(row.summary);
    for (const auto& note : row.notes) out += ',' + csv_cell(note.second);
    out += "\r\n";
    for (const Parameter& p : row.parameters)
      out += csv_cell(row.name) + ',' + std::string(p.name) + ',' + parameter_unit(p) + ',' +
             (p.fallback ? shortest(*p.fallback) : "") + ',' + csv_cell(std::string(p.meaning)) +
             std::string(row.notes.size(), ',') + "\r\n";
  }
  return out;
}

std::string per_configuration_header(const Spec& spec, const std::vector<Eigen::VectorXd>& noise) {
  std::string out;
  for (const IndependentJoint& joint : spec.model.chain.independent)
    out += (out.empty() ? "" : ",") + csv_cell(joint.name + unit_in_brackets(joint));
  for (const Coordinate c : spec.model.coordinates)
    for (const char* bound : {"worst_case", "worst_case_rigorous", "sigma"})
      out += ',' + std::string(info(c).name) + '.' + bound + " [" + std::string(info(c).unit) + ']';
  for (std::size_t f = 0; f < spec.filters.size(); ++f)
    for (const Coordinate c : spec.model.coordinates)
      for (const char* bound : {"worst_case", "sigma", "sigma_in_motion"})
        if (bound != std::string("sigma_in_motion") || is_known(noise, f))
          out += ',' + csv_cell(spec.filters[f].name + '.' + std::string(info(c).name) + '.' + bound + " [" +
                                derivative_unit(c, spec.filters[f].filter.derivative) + ']');
  return out + "\r\n";
}

std::string per_configuration_rows(const Spec& spec, const std::vector<Eigen::VectorXd>& noise,
                                   const ConfigurationBatch& batch) {
  const FigureLayout& at = batch.layout;
  const bool own_worst = at.filtered_sigma > at.filtered_worst, own_sigma = at.in_motion > at.filtered_sigma;
  std::string out;
  for (std::size_t i = 0; i < batch.count; ++i) {
    const auto figure = [&](std::size_t f) { return batch.figures[f * batch_size + i]; };
    for (std::size_t j = 0; j < spec.model.chain.independent.size(); ++j)
      out += (j ? "," : "") + number(batch.q[j * batch_size + i]);
    for (std::size_t c = 0; c < at.coordinates; ++c)
      for (const std::size_t of : {at.worst_case, at.rigorous, at.sigma}) out += ',' + number(figure(of + c));
    for (std::size_t f = 0; f < spec.filters.size(); ++f)
      for (std::size_t c = 0; c < at.coordinates; ++c) {
        const Norms& norms = spec.filters[f].norms;
        const std::size_t filtered = f * at.coordinates + c;
        out += ',' + number(own_worst ? figure(at.filtered_worst + filtered)
                                      : norms.l1.upper * figure(at.worst_case + c));
        out +=
            ',' + number(own_sigma ? figure(at.filtered_sigma + filtered) : norms.h2 * figure(at.sigma + c));
        if (is_known(noise, f)) out += ',' + number(figure(at.in_motion + filtered));
      }
    out += "\r\n";
  }
  return out;
}

}  // namespace qerr
