#include "problem.hpp"

#include <filesystem>
#include <numbers>

#include "core/random.hpp"
#include "qerr/input/first_spec.hpp"
#include "qerr/input/spec.hpp"

namespace qerr::bench {

namespace {

/// Range of a joint without limits in its file.
Limits default_range(const IndependentJoint& joint) {
  const double reach = joint.prismatic() ? 1.0 : std::numbers::pi;
  return joint.limits.value_or(Limits{-reach, reach});
}

/// make_chain() for a command line: its errors refer to keys of a spec.
Chain chain_of(const RobotModel& robot, const std::string& base, const std::string& tip) try {
  return make_chain(robot, base, tip);
} catch (const Error& e) {
  std::vector<Fault> faults = e.faults();
  for (Fault& fault : faults)
    for (std::string* text : {&fault.key, &fault.rule, &fault.remedy})
      for (std::size_t at; (at = text->find("robot.")) != std::string::npos;) text->replace(at, 6, "--");
  throw Error(std::move(faults), e.trouble());
}

Problem from_urdf(const std::string& file, const std::string& base, const std::string& tip) {
  Problem p;
  p.model.chain = chain_of(read_urdf(file), base, tip);
  const auto n = static_cast<Eigen::Index>(p.model.chain.independent.size());
  p.model.transmission.coupling = Eigen::MatrixXd::Identity(n, n);
  for (const IndependentJoint& joint : p.model.chain.independent) {
    p.model.transmission.encoders.push_back({joint.prismatic() ? 1e-5 : 2 * std::numbers::pi / 65536});
    p.configurations.ranges.push_back(default_range(joint));
  }
  return p;
}

Problem from_spec(const std::string& file) {
  Spec spec = read_spec(file);
  Problem p;
  p.model = std::move(spec.model);
  p.model.sources.clear();
  for (Encoder& encoder : p.model.transmission.encoders) encoder.rounding = Rounding::nearest;
  p.configurations.ranges = std::move(spec.configurations.ranges);
  if (p.configurations.ranges.size() != p.model.chain.independent.size()) {  // a list of points has no ranges
    p.configurations.ranges.clear();
    for (const IndependentJoint& joint : p.model.chain.independent)
      p.configurations.ranges.push_back(default_range(joint));
  }
  return p;
}

/// Name of the folder for `NAME/spec.yaml`, otherwise that of the file.
std::string name_of(const std::filesystem::path& file) {
  const std::string stem = file.stem().string();
  const std::string folder = std::filesystem::absolute(file).parent_path().filename().string();
  return stem == "spec" ? folder : stem;
}

}  // namespace

Problem read_problem(const std::string& file, const std::string& base, const std::string& tip,
                     std::uint64_t count) {
  const std::string ending = std::filesystem::path(file).extension().string();
  Problem p = ending == ".urdf" || ending == ".xml" ? from_urdf(file, base, tip) : from_spec(file);
  p.name = name_of(file);
  p.model.coordinates = {Coordinate::x,  Coordinate::y,  Coordinate::z,
                         Coordinate::rx, Coordinate::ry, Coordinate::rz};
  p.configurations.count = count;
  p.points = draw(p.configurations, 0, count);

  const Chain& chain = p.model.chain;
  const auto joints = static_cast<Eigen::Index>(chain.joints.size());
  p.motions.resize(joints, p.points.cols());
  for (Eigen::Index k = 0; k < joints; ++k) {
    const ChainJoint& joint = chain.joints[static_cast<std::size_t>(k)];
    const auto master = static_cast<Eigen::Index>(joint.coordinate);
    p.motions.row(k) = (joint.multiplier * p.points.row(master).array() + joint.offset).matrix();
  }
  p.fold = to_independent(chain, Eigen::MatrixXd::Identity(joints, joints));
  p.weights = p.model.transmission.coupling.dense() * resolutions(p.model.transmission).asDiagonal();
  return p;
}

Problem calibrated(Problem p) {
  std::uint64_t drawn = 0;
  const auto within = [&](double size) {
    return Eigen::Vector3d::NullaryExpr(
               [&] { return 2 * unit_interval(random_bits(2026, drawn++, 6)) - 1; }) *
           size;
  };
  const auto perturb = [&](Eigen::Isometry3d& fixed) {
    const Eigen::Vector3d turn = within(1e-3), shift = within(1e-4);
    fixed.translate(shift);
    fixed.rotate(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
  };
  for (ChainJoint& joint : p.model.chain.joints) perturb(joint.origin);
  perturb(p.model.chain.tip_offset);
  p.name += " calibrated";
  return p;
}

}  // namespace qerr::bench
