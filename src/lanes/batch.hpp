#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>

namespace qerr {

/// Number of configurations in one batch of the kernels. Batches are channel-major: the 64 numbers of one
/// joint, or of one figure, are contiguous, and all of a small arm fits in the first-level cache.
inline constexpr std::size_t batch_size = 64;

/// Array of doubles aligned to 64 bytes, the widest vector of the batched kernels; initially zero.
class AlignedNumbers {
 public:
  AlignedNumbers() = default;
  explicit AlignedNumbers(std::size_t count) : count_(count) {
    const std::size_t bytes = (count * sizeof(double) + 63) / 64 * 64;
    if (bytes == 0) return;
    numbers_.reset(static_cast<double*>(std::aligned_alloc(64, bytes)));
    if (!numbers_) throw std::bad_alloc();
    for (std::size_t i = 0; i < count; ++i) numbers_[i] = 0;
  }
  double* data() const { return numbers_.get(); }
  std::size_t size() const { return count_; }
  double& operator[](std::size_t i) const { return numbers_[i]; }

 private:
  struct Free {
    void operator()(double* p) const { std::free(p); }
  };
  std::unique_ptr<double[], Free> numbers_;
  std::size_t count_ = 0;
};

}  // namespace qerr
