#include <algorithm>
#include <vector>

#include "cli/command.hpp"
#include "core/output_file.hpp"
#include "core/run_files.hpp"
#include "fuzz/schema_mutation.hpp"
#include "fuzz/target.hpp"
#include "qerr/input/spec.hpp"

/// The first byte chooses command lines, the others are the spec that they run with.
namespace {

using namespace qerr::fuzz;
using Words = std::vector<std::string>;

const std::string spec_file = folder().file("spec.yaml"), log_file = folder().file("log.csv");
constexpr const char* nowhere = "/dev/null";

/// Each is one way through the program; of several command lines, the later read what the earlier wrote.
const std::vector<std::vector<Words>>& uses() {
  static const std::vector<std::vector<Words>> all = {
      {{"analyze", "-q", spec_file, "-o", nowhere}},
      {{"analyze", "-q", spec_file, "--format", "json", "-o", nowhere}},
      {{"check", "-q", spec_file, "-o", nowhere}},
      {{"filter", "-q", spec_file, "-o", nowhere}},
      {{"threshold", "-q", spec_file, "-o", nowhere}},
      {{"simulate", "-q", spec_file, "-o", nowhere, "--log", log_file},
       {"diagnose", "-q", spec_file, log_file, "-o", nowhere}},
      {{"sweep", "-q", spec_file, "-o", nowhere}},
  };
  return all;
}

/// Whether a spec asks for little enough work: the search is for defects, not for time.
bool quick(const qerr::Spec& spec) {
  double variants = 1;
  for (const qerr::SweepAxis& axis : spec.sweep) variants *= static_cast<double>(axis.steps.size());
  const double rows = spec.motion ? spec.motion->sample_rate * spec.motion->duration : 0;
  return qerr::size(spec.configurations) <= 200 && variants <= 20 && rows <= 500;
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return -1;
  const std::string text = text_of(data + 1, size - 1);
  try {
    if (!quick(qerr::parse_spec(text, spec_file))) return -1;
  } catch (const qerr::Error&) {
    return -1;  // what fuzz_spec is for
  }
  folder().write("spec.yaml", data + 1, size - 1);
  accept_or_refuse([&] {
    for (const Words& words : uses()[data[0] % uses().size()]) {
      const qerr::RunFiles files;
      const int code = qerr::cli::run_command_line(words);
      if (code != 0 && code != 1) std::abort();
    }
  });
  return 0;
}

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

/// Three of four changes know the format; libFuzzer's own change bytes.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most,
                                               unsigned seed) {
  if (size < 2 || seed % 4 == 0) return LLVMFuzzerMutate(data, size, most);
  if (seed % 8 == 1) data[0] = static_cast<std::uint8_t>(seed >> 8);
  const std::string changed = changed_by_schema(text_of(data + 1, size - 1), seed / 8);
  if (changed.empty() || changed.size() + 1 > most) return LLVMFuzzerMutate(data, size, most);
  std::copy(changed.begin(), changed.end(), data + 1);
  return changed.size() + 1;
}
