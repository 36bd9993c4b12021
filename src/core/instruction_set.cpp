#include "qerr/core/instruction_set.hpp"

#include <cstdlib>
#include <string>

#include "core/text.hpp"
#include "qerr/core/error.hpp"

namespace qerr {

namespace {

struct Row {
  InstructionSet set;
  std::string_view name;
  bool (*supported)();  ///< by this processor
};

constexpr Row rows[] = {
    {InstructionSet::portable, "portable", [] { return true; }},
#if defined(__x86_64__)
    {InstructionSet::avx2, "avx2",
     [] { return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"); }},
    {InstructionSet::avx512, "avx512",
     [] {
       return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
              __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw") &&
              __builtin_cpu_supports("fma");
     }},
#endif
};

std::vector<InstructionSet> supported_sets() {
#if defined(__x86_64__)
  __builtin_cpu_init();
#endif
  std::vector<InstructionSet> sets;
  for (const Row& row : rows)
    if (row.supported()) sets.push_back(row.set);
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
  throw Error({"", 0, 0}, "QERR_INSTRUCTION_SET", "no such instruction set on this processor",
              "'" + std::string(wish) + "'", did_you_mean(wish, known), Trouble::usage);
}

}  // namespace

std::string_view name_of(InstructionSet set) {
  for (const Row& row : rows)
    if (row.set == set) return row.name;
  return "not in this build";
}

const std::vector<InstructionSet>& available_instruction_sets() {
  static const std::vector<InstructionSet> sets = supported_sets();
  return sets;
}

InstructionSet instruction_set() {
  static const InstructionSet set = chosen();
  return set;
}

}  // namespace qerr
