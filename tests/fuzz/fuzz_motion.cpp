#include "fuzz/target.hpp"
#include "qerr/input/spec.hpp"

/// The bytes are a table of positions over time, which a spec's `motion` follows.
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace qerr::fuzz;
  folder().write("motion.csv", data, size);
  accept_or_refuse([&] {
    qerr::parse_spec(arm_spec("configurations: {count: 5, limits: {wrist: [-180 deg, 180 deg]}}\n"
                              "motion: {sample_rate: 100 Hz, file: motion.csv}\n"),
                     folder().file("spec.yaml"));
  });
  return 0;
}
