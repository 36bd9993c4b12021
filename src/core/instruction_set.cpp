#include "qerr/core/instruction_set.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string>

#include "core/suggest.hpp"
#include "qerr/core/error.hpp"

namespace qerr {

namespace {

constexpr std::array<std::string_view, 3> names{"portable", "avx2", "avx512"};

std::vector<InstructionSet> available() {
  std::vector<InstructionSet> sets{InstructionSet::portable};
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) return sets;
  sets.push_back(InstructionSet::avx2);
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw"))
    sets.push_back(InstructionSet::avx512);
#endif
  return sets;
}

InstructionSet chosen() {
  const std::vector<InstructionSet>& sets = available_instruction_sets();
  const char* const wish = std::getenv("QERR_INSTRUCTION_SET");
  if (!wish || !*wish) return sets.back();
  std::vector<std::string> known;
  for (const InstructionSet set : sets) {
    if (name_of(set) == wish) return set;
    known.emplace_back(name_of(set));
  }
  throw Error({{"", 0, 0},
               "QERR_INSTRUCTION_SET",
               "no such instruction set on this processor",
               "'" + std::string(wish) + "'",
               did_you_mean(wish, known)},
              Trouble::usage);
}

}  // namespace

std::string_view name_of(InstructionSet set) { return names[static_cast<std::size_t>(set)]; }

const std::vector<InstructionSet>& available_instruction_sets() {
  static const std::vector<InstructionSet> sets = available();
  return sets;
}

InstructionSet instruction_set() {
  static const InstructionSet set = chosen();
  return set;
}

}  // namespace qerr
