#include "fuzz/target.hpp"
#include "qerr/input/spec.hpp"

/// The bytes are a spec.
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace qerr::fuzz;
  accept_or_refuse([&] { qerr::parse_spec(text_of(data, size), folder().file("spec.yaml")); });
  return 0;
}
