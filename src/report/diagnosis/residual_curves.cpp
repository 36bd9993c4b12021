#include <vector>

#include "qerr/core/quantity.hpp"
#include "report/csv_text.hpp"
#include "report/diagnosis/joint_residual.hpp"

namespace qerr {

namespace {

std::string residual_rows(const JointResidual& residual) {
  const Evidence& e = residual.evidence;
  const std::string joint = csv_cell(e.joint) + ',', unit = e.prismatic ? ",m\r\n" : ",rad\r\n";
  std::string out;
  for (Eigen::Index k = 0; k < e.rows(); ++k)
    out += joint + (e.ordered ? shortest(e.time[k]) : "") + ',' + shortest(e.reference[k]) + ',' +
           shortest(e.direction.size() ? e.direction[k] : 0) + ',' + shortest(residual.before[k]) + ',' +
           shortest(residual.after[k]) + unit;
  return out;
}

std::string spectrum_rows(const JointResidual& residual) {
  const Evidence& e = residual.evidence;
  const std::string joint = csv_cell(e.joint) + ',', unit = e.prismatic ? ",m\r\n" : ",rad\r\n";
  const PositionSpectrum s = position_spectrum(residual);
  std::string out;
  for (std::size_t i = 0; i < s.order.size(); ++i)
    out += joint + shortest(s.order[i]) + ',' + shortest(s.encoder_order[i]) + ',' + shortest(s.before[i]) +
           ',' + shortest(s.after[i]) + unit;
  return out;
}

}  // namespace

ResidualCurves residual_curves(const DiagnosisReport& r) {
  std::vector<ResidualCurves> of_encoder(r.spec.model.transmission.encoders.size());
  for_each_residual(r, [&](const JointResidual& residual) {
    of_encoder[static_cast<std::size_t>(residual.evidence.number)] = {residual_rows(residual),
                                                                      spectrum_rows(residual)};
  });
  ResidualCurves out;
  for (const ResidualCurves& one : of_encoder) out.residual += one.residual, out.spectrum += one.spectrum;
  if (!out.residual.empty())
    out.residual.insert(0, "joint,time [s],reference,direction,before,after,unit\r\n");
  if (!out.spectrum.empty()) out.spectrum.insert(0, "joint,order,encoder_order,before,after,unit\r\n");
  return out;
}

}  // namespace qerr
