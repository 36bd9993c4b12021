#include <algorithm>

#include "cli/shared.hpp"
#include "core/run_files.hpp"
#include "fuzz/table_mutation.hpp"
#include "fuzz/target.hpp"

using namespace qerr::fuzz;

/// The bytes are the log of a robot with two joints, in which causes are sought. An odd number of them asks
/// for a page, an even one for JSON.
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string spec = folder().text(
      "spec.yaml", "qerr: 1\nrobot: {urdf: ../two_joints.urdf}\nencoders: {'*': {counts_per_rev: 4096}}\n");
  const std::string log = folder().write("log.csv", data, size);
  accept_or_refuse([&] {
    const qerr::RunFiles files;
    const int code = qerr::cli::run_command_line(
        {"diagnose", "-q", spec, log, "--format", size % 2 == 1 ? "html" : "json", "-o", "/dev/null",
         "--write-model", folder().file("model.yaml"), "--threads", "1"});
    if (code != 0) std::abort();
  });
  return 0;
}

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

/// Three of four changes know columns and rows; libFuzzer's own change bytes.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most,
                                               unsigned seed) {
  const std::string changed = seed % 4 == 0 ? "" : changed_table(text_of(data, size), seed / 4);
  if (changed.empty() || changed.size() > most) return LLVMFuzzerMutate(data, size, most);
  std::copy(changed.begin(), changed.end(), data);
  return changed.size();
}
