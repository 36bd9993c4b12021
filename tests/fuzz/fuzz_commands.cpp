#include <algorithm>
#include <cstdio>
#include <vector>

#include "cli/shared.hpp"
#include "core/output_file.hpp"
#include "core/run_files.hpp"
#include "fuzz/schema_mutation.hpp"
#include "fuzz/target.hpp"
#include "qerr/input/spec.hpp"

/// The first byte chooses command lines, the others are the spec that they run with.
namespace {

using namespace qerr::fuzz;
using Words = std::vector<std::string>;

const std::string spec_file = folder().file("spec.yaml"), log_file = folder().file("log.csv"),
                  model_file = folder().file("model.yaml"), report_file = folder().file("report.json"),
                  sweep_file = folder().file("sweep.csv"), plots_folder = folder().file("plots");
const std::string spec_of_arm =
    folder().text("arm.yaml", arm_spec("configurations: {count: 5, limits: {wrist: [0, 1]}}\n"));
constexpr const char* nowhere = "/dev/null";

/// Each is one way through the program; of several command lines, the later read what the earlier wrote.
const std::vector<std::vector<Words>>& uses() {
  static const std::vector<std::vector<Words>> all = {
      {{"analyze", spec_file}},
      {{"analyze", spec_file, "--format", "html"}},
      {{"analyze", spec_file, "--format", "json", "-o", report_file}, {"compare", report_file, spec_of_arm}},
      {{"check", spec_file, "--format", "html"}},
      {{"filter", spec_file}},
      {{"filter", spec_file, "--format", "html"}},
      {{"threshold", spec_file, "--format", "csv"}},
      {{"simulate", spec_file, "--log", log_file, "--format", "html"},
       {"diagnose", spec_file, log_file, "--write-model", model_file, "--plots", plots_folder},
       {"analyze", model_file, "--format", "json"}},
      {{"diagnose", spec_file, "--plan"}},
      {{"sweep", spec_file, "--format", "csv", "-o", sweep_file}, {"merge", "--spec", spec_file, sweep_file}},
      {{"sweep", spec_file, "--format", "html"}},
      {{"design", spec_file, "--format", "html"}},
      {{"compare", spec_of_arm, spec_file, "--format", "html"}},
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
  for (const std::string& file : {log_file, model_file, report_file, sweep_file}) std::remove(file.c_str());
  accept_or_refuse([&] {
    for (Words words : uses()[data[0] % uses().size()]) {
      words.insert(words.end(), {"-q", "--threads", "1"});
      if (std::find(words.begin(), words.end(), "-o") == words.end())
        words.insert(words.end(), {"-o", nowhere});
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
