#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace qerr::bench {

/// Peak rate of multiply-add instructions of one core, one row per vector width.
struct FmaPeak {
  std::string instruction_set;  ///< as Contestant::instruction_set
  int lanes;                    ///< doubles in a vector
  const char* instruction;      ///< what is counted
  bool runs_here;
  double (*chains)(std::uint64_t rounds);

  /// Multiply-adds in one round.
  static constexpr double per_round = 12;
};

/// Every row of this build, narrowest first, including those that this machine cannot run.
std::vector<FmaPeak> fma_peaks();

}  // namespace qerr::bench
