#include "self_test.hpp"

namespace qerr::bench {

namespace {

/// Modifies the results of one run; no Recording at the stage `full`, no Summaries below.
using Spoil = std::function<void(Recording*, Summaries&)>;

Contestant spoiled(const Contestant& right, const std::string& figure, const Spoil& spoil) {
  Contestant wrong = right;
  wrong.name = "wrong " + figure;
  wrong.prepare = [right, spoil](const Problem& p) -> Run {
    return [run = right.prepare(p), spoil](Stage stage, std::uint64_t count, Recording* r) {
      Summaries s = run(stage, count, r);
      spoil(r, s);
      return s;
    };
  };
  return wrong;
}

/// Changes one entry of the last configuration by 1e-10, relative.
void nudge(Eigen::MatrixXd& figures) {
  if (figures.size() == 0) return;
  auto last = figures.col(figures.cols() - 1);
  Eigen::Index largest = 0;
  last.cwiseAbs().maxCoeff(&largest);
  last[largest] *= 1 + 1e-10;
}

}  // namespace

std::vector<Contestant> spoiled(const Contestant& right) {
  const auto recorded = [](Eigen::MatrixXd Recording::*figures) -> Spoil {
    return [figures](Recording* r, Summaries&) {
      if (r) nudge(r->*figures);
    };
  };
  const auto summed = [](double Summary::*figure, double factor) -> Spoil {
    return [=](Recording*, Summaries& s) {
      if (!s.empty()) s.front().*figure *= factor;
    };
  };
  const Spoil misplace = [](Recording*, Summaries& s) {
    if (!s.empty()) s.front().at_max *= 0.9;
  };
  return {spoiled(right, "Jacobian", recorded(&Recording::jacobians)),
          spoiled(right, "worst case", recorded(&Recording::worst_cases)),
          spoiled(right, "covariance", recorded(&Recording::covariances)),
          spoiled(right, "max", summed(&Summary::max, 1 + 1e-10)),
          spoiled(right, "mean", summed(&Summary::mean, 1 - 1e-10)),
          spoiled(right, "quantile", summed(&Summary::p95, 1.03)),
          spoiled(right, "arg max", misplace)};
}

}  // namespace qerr::bench
