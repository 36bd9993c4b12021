#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace qerr::bench {

/// How many multiply-add instructions one core can do, one row per vector width.
struct FmaPeak {
  std::string instruction_set;  ///< as Contestant::instruction_set
  int lanes;                    ///< doubles in a vector
  const char* instruction;      ///< what is counted
  bool runs_here;
  double (*chains)(std::uint64_t rounds);

  /// Multiply-adds in one round.
  static constexpr double per_round = 12;
};

/// Every row that this build has, narrowest first, also those that this machine cannot run.
std::vector<FmaPeak> fma_peaks();

}  // namespace qerr::bench
