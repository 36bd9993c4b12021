#include "bound/batched_error.hpp"

#include <algorithm>

#include "bound/error_plan.hpp"
#include "lanes/aligned.hpp"

namespace qerr {

struct BatchedError::Plan {
  PlannedError error;
  const BoundKernels& kernels;
};

struct BatchedError::Work {
  AlignedNumbers scratch, sums;
};

BatchedError::BatchedError(const OperationalModel& model, const ErrorFigures& requested, InstructionSet set)
    : plan_(new Plan{{model, requested}, select_kernels<BoundKernels>(set)}) {
  const ErrorPlan& plan = plan_->error.plan();
  work_ = std::make_unique<Work>(Work{AlignedNumbers(plan_->kernels.scratch(plan)),
                                      AlignedNumbers(plan.sums.count * plan_->kernels.lanes)});
}

BatchedError::BatchedError(const BatchedError& other)
    : plan_(other.plan_),
      work_(std::make_unique<Work>(
          Work{AlignedNumbers(other.work_->scratch.size()), AlignedNumbers(other.work_->sums.size())})) {}

BatchedError::~BatchedError() = default;

const FigureLayout& BatchedError::figures() const { return plan_->error.plan().figures; }
const SumLayout& BatchedError::sums() const { return plan_->error.plan().sums; }
bool BatchedError::own_worst_case() const { return plan_->error.plan().filtered_worst; }
bool BatchedError::own_sigma() const { return plan_->error.plan().filtered_sigma; }

void BatchedError::operator()(const double* q, double* figures) {
  plan_->kernels.errors(plan_->error.plan(), q, figures, work_->sums.data(), work_->scratch.data());
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
