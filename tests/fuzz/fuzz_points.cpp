#include "fuzz/target.hpp"
#include "qerr/input/spec.hpp"

/// The bytes are a table of configurations.
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace qerr::fuzz;
  folder().write("points.csv", data, size);
  accept_or_refuse([&] {
    qerr::parse_spec(arm_spec("configurations: {method: file, file: points.csv}\n"),
                     folder().file("spec.yaml"));
  });
  return 0;
}
