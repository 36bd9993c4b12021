#include "bound/batched_error.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "bound/error_plan.hpp"
#include "bound/length_errors.hpp"
#include "bound/signal_errors.hpp"
#include "lanes/batch.hpp"

namespace qerr {

struct BatchedError::Plan {
  PlannedError error;
  const BoundKernels& kernels;
  OperationalModel model;
  ErrorFigures requested;
  InstructionSet set;
};

namespace {

/// Adds the error along a motion to the figures of a batch.
class AlongMotion {
 public:
  AlongMotion(const FigureLayout& layout, double* figures) : layout_(layout), figures_(figures) {}

  void add(const ErrorAlongMotion& error, const ErrorPlan& plan) {
    const std::size_t m = layout_.coordinates;
    for (std::size_t c = 0; c < plan.coordinates; ++c) {
      const auto row = static_cast<Eigen::Index>(c);
      widen(layout_.worst_case + c, error.tip.peak[row]);
      if (plan.rigorous) widen(layout_.rigorous + c, error.tip.peak[row]);
      if (!plan.keep_covariance) scatter(layout_.sigma + c, error.tip.covariance(row, row));
      for (std::size_t f = 0; f < plan.filters; ++f) {
        const SignalMoments& behind = error.filtered[f];
        widen(layout_.filtered_worst + f * m + c, behind.peak[row]);
        scatter(layout_.filtered_sigma + f * m + c, behind.covariance(row, row));
        if (layout_.in_motion < layout_.trace)
          scatter(layout_.in_motion + f * m + c, behind.covariance(row, row));
      }
    }
  }

 private:
  void widen(std::size_t figure, double by) {
    for (std::size_t i = 0; i < batch_size; ++i) figures_[figure * batch_size + i] += by;
  }
  void scatter(std::size_t figure, double variance) {
    for (std::size_t i = 0; i < batch_size; ++i) {
      double& sigma = figures_[figure * batch_size + i];
      sigma = std::sqrt(sigma * sigma + variance);
    }
  }

  const FigureLayout& layout_;
  double* figures_;
};

}  // namespace

struct BatchedError::Work {
  AlignedNumbers scratch, sums;
  std::optional<LengthErrors> lengths;
  std::optional<SignalErrors> signals;

  explicit Work(const Plan& p)
      : scratch(p.kernels.scratch(p.error.plan())), sums(p.error.plan().sums.count * p.kernels.lanes) {
    const FigureLayout& layout = p.error.plan().figures;
    if (layout.coordinates == p.error.plan().coordinates) return;
    if (!p.model.lengths.empty()) lengths.emplace(p.model, p.requested, layout, p.set);
    if (!p.model.signals.empty()) signals.emplace(p.model, p.requested, layout);
  }
};

BatchedError::BatchedError(const OperationalModel& model, const ErrorFigures& requested, InstructionSet set)
    : plan_(new Plan{{model, requested}, select_kernels<BoundKernels>(set), model, requested, set}),
      work_(std::make_unique<Work>(*plan_)) {}

BatchedError::BatchedError(const BatchedError& other)
    : plan_(other.plan_), work_(std::make_unique<Work>(*plan_)) {}

BatchedError::~BatchedError() = default;

const FigureLayout& BatchedError::figures() const { return plan_->error.plan().figures; }
const SumLayout& BatchedError::sums() const { return plan_->error.plan().sums; }
bool BatchedError::own_worst_case() const { return plan_->error.plan().filtered_worst; }
bool BatchedError::has_sources() const { return plan_->error.plan().quantization_parts; }
bool BatchedError::own_sigma() const { return plan_->error.plan().filtered_sigma; }

void BatchedError::operator()(const double* q, double* figures) {
  plan_->kernels.errors(plan_->error.plan(), q, figures, work_->sums.data(), work_->scratch.data());
  if (plan_->model.along_motion)
    AlongMotion(this->figures(), figures).add(*plan_->model.along_motion, plan_->error.plan());
  if (work_->lengths) (*work_->lengths)(q, figures);
  if (work_->signals) (*work_->signals)(q, figures);
}

std::vector<double> BatchedError::take_sums() {
  const std::size_t lanes = plan_->kernels.lanes;
  std::vector<double> sums(this->sums().count);
  for (std::size_t s = 0; s < sums.size(); ++s)
    for (std::size_t i = 0; i < lanes; ++i) {
      double& lane = work_->sums[s * lanes + i];
      sums[s] = s < this->sums().arms ? sums[s] + lane : std::max(sums[s], lane);
      lane = 0;
    }
  return sums;
}

}  // namespace qerr
