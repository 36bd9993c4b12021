// Upper bounds along the chain: gap and seconds (one core: taskset -c 0).
//
//   bench_proven GAP ROBOT.urdf[:TIP]... [FIGURE...]
//
// FIGURE is COORDINATE.worst_case or COORDINATE.sigma; default: x.worst_case x.sigma xyz.worst_case xyz.sigma
// rx.worst_case. Every joint has an encoder of 2^17 counts per revolution, or of 10 um. Each row: the largest
// figure that a search finds, the proven bound, the gap between them, seconds. Robots of ../shared/robots or
// of configs/*.

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <numbers>
#include <string>

#include "qerr/input/first_spec.hpp"
#include "support/figure_search.hpp"

namespace {

using namespace qerr;

OperationalModel model_of(const std::string& path, std::vector<Limits>& ranges) {
  const std::size_t colon = path.rfind(".urdf:");
  const RobotModel robot = read_urdf(colon == std::string::npos ? path : path.substr(0, colon + 5));
  OperationalModel m{make_chain(robot, "", colon == std::string::npos ? "" : path.substr(colon + 6)), {}, {}};
  const auto n = static_cast<Eigen::Index>(m.chain.independent.size());
  m.transmission.coupling = Eigen::MatrixXd::Identity(n, n);
  for (const IndependentJoint& joint : m.chain.independent) {
    m.transmission.encoders.push_back({joint.prismatic() ? 1e-5 : 2 * std::numbers::pi / 131072});
    ranges.push_back(joint.limits.value_or(Limits{-std::numbers::pi, std::numbers::pi}));
  }
  m.coordinates = {Coordinate::x,  Coordinate::y,  Coordinate::z,
                   Coordinate::rx, Coordinate::ry, Coordinate::rz};
  m.lengths = {Coordinate::xyz, Coordinate::rxyz};
  if (std::getenv("TIP_FRAME")) m.frame = CoordinateFrame::tip;
  return m;
}

void row(const std::string& path, const std::string& figure, double gap) {
  std::vector<Limits> ranges;
  const OperationalModel m = model_of(path, ranges);
  const std::size_t dot = figure.find('.');
  const auto all = all_signals(m);
  const auto signal =
      std::find_if(all.begin(), all.end(), [&](const Signal& s) { return s.name == figure.substr(0, dot); });
  const Figure request{static_cast<std::size_t>(signal - all.begin()), -1,
                       figure.substr(dot + 1) == "sigma" ? Bound::sigma : Bound::worst_case};
  const double lower = testing::largest_figure(m, ranges, request, 20000, 1);
  const std::clock_t start = std::clock();  // of all threads
  const auto upper = chain_upper_bound(m, ranges, request, lower, gap);
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  std::printf("%-14s %zu  %-16s %.9g  %.9g  %8.4f %%  %7.3f s\n", path.substr(path.rfind('/') + 1).c_str(),
              m.chain.joints.size(), figure.c_str(), lower, upper.value_or(NAN),
              100 * (upper.value_or(NAN) / lower - 1), seconds);
  std::fflush(stdout);
}

}  // namespace

int main(int count, char** arguments) {
  std::vector<std::string> robots, figures;
  for (int i = 2; i < count; ++i)
    (std::strstr(arguments[i], ".urdf") ? robots : figures).push_back(arguments[i]);
  if (robots.empty()) return std::fputs("bench_proven GAP ROBOT.urdf... [FIGURE...]\n", stderr), 2;
  if (figures.empty()) figures = {"xyz.sigma", "x.worst_case", "xyz.worst_case", "rx.worst_case", "x.sigma"};
  for (const std::string& robot : robots)
    for (const std::string& figure : figures) row(robot, figure, std::atof(arguments[1]));
}
