#include "simulate/kernels.hpp"
#include "simulate/sensing.hpp"

namespace qerr {

PathBatch::PathBatch(const Motion& motion, InstructionSet set)
    : path_(motion), sample_rate_(motion.sample_rate), set_(set) {}

void PathBatch::at(std::uint64_t first, std::size_t count) {
  if (time_.size() == 0) {  // allocated on first use: runs that share a batch do not need their own
    time_ = AlignedNumbers(batch_size);
    joints_ = AlignedNumbers(path_.joints() * batch_size);
  }
  first_ = first;
  count_ = count;
  select_kernels<SimulationKernels>(set_).times(static_cast<double>(first), count, sample_rate_,
                                                time_.data());
  for (std::size_t joint = 0; joint < path_.joints(); ++joint)
    path_.positions(joint, time_.data(), joints_.data() + joint * batch_size, set_);
}

}  // namespace qerr
