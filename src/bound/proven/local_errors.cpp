#include "bound/proven/local_errors.hpp"

#include <algorithm>
#include <cmath>

namespace qerr {

namespace {

void add_column(LocalError& e, double factor, bool prismatic, const Eigen::Vector3d& z,
                const Eigen::Vector3d& origin, double reach) {
  if (factor == 0) return;
  if (prismatic) {
    e.constant += factor * z;
    e.size += std::abs(factor);
    return;
  }
  e.axis += factor * z;
  e.constant -= factor * z.cross(origin);  // (u x z) . o = u . (z x o)
  e.size += std::abs(factor) * reach;
  e.moment += std::abs(factor);
}

bool of_neighbours(const DirectedError& e) { return e.last - e.first <= 1; }

/// The column of an error of one joint or of two neighbours, in the moved frame of the first.
LocalError local(const ChainForm& form, const std::vector<double>& reach, const DirectedError& e,
                 double width) {
  LocalError sum;
  sum.width = width;
  for (Eigen::Index k = e.first; k <= e.last; ++k) {
    const auto joint = static_cast<std::size_t>(k);
    const ChainStep& step = form.steps[joint];
    const bool next = k > e.first;
    add_column(sum, e.of_joints[k], step.prismatic,
               next ? Eigen::Vector3d(step.rotation.col(2)) : Eigen::Vector3d::UnitZ(),
               next ? step.translation : Eigen::Vector3d::Zero(), reach[joint + 1]);
  }
  return sum;
}

void add_own_column(const ChainForm& form, const std::vector<double>& reach, std::size_t joint, double factor,
                    LocalError& sum) {
  add_column(sum, factor, form.steps[joint].prismatic, Eigen::Vector3d::UnitZ(), Eigen::Vector3d::Zero(),
             reach[joint + 1]);
}

}  // namespace

std::vector<FrameErrors> worst_case_errors(const ChainForm& form, const std::vector<double>& distant_signs) {
  const std::vector<double> reach = form.reaches();
  std::vector<FrameErrors> frames(form.size() + 1);
  std::size_t distant = 0;
  for (const DirectedError& e : form.errors) {
    const bool near = of_neighbours(e);
    const double fixed = e.mean + (near ? 0 : distant_signs[distant++] * e.half_width);
    for (Eigen::Index k = e.first; k <= e.last; ++k) {
      const auto joint = static_cast<std::size_t>(k);
      add_own_column(form, reach, joint, fixed * e.of_joints[k], frames[joint + 1].fixed);
    }
    if (near && e.half_width > 0)
      frames[static_cast<std::size_t>(e.first) + 1].independent.push_back(
          local(form, reach, e, e.half_width));
  }
  return frames;
}

std::vector<FrameErrors> sigma_errors(const ChainForm& form) {
  const std::vector<double> reach = form.reaches();
  std::vector<FrameErrors> frames(form.size() + 1);
  for (const DirectedError& e : form.errors) {
    if (e.variance == 0) continue;
    if (of_neighbours(e)) {
      frames[static_cast<std::size_t>(e.first) + 1].independent.push_back(
          local(form, reach, e, std::sqrt(e.variance)));
      continue;
    }
    double whole = 0;
    std::vector<LocalError> parts(form.size());
    for (Eigen::Index k = e.first; k <= e.last; ++k) {
      const auto joint = static_cast<std::size_t>(k);
      add_own_column(form, reach, joint, e.of_joints[k], parts[joint]);
      whole += parts[joint].size;
    }
    for (std::size_t joint = 0; joint < parts.size(); ++joint) {
      if (parts[joint].size == 0) continue;
      parts[joint].width = std::sqrt(e.variance * whole / parts[joint].size);
      frames[joint + 1].independent.push_back(parts[joint]);
    }
  }
  return frames;
}

std::vector<double> reaches_before_motion(const ChainForm& form) {
  std::vector<double> reach = form.reaches();
  for (std::size_t k = 0; k < form.size(); ++k)
    if (form.steps[k].prismatic)
      reach[k + 1] += std::max(std::abs(form.steps[k].lower), std::abs(form.steps[k].upper));
  return reach;
}

}  // namespace qerr
