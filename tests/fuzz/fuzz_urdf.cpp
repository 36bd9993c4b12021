#include "fuzz/target.hpp"
#include "qerr/input/first_spec.hpp"

/// The bytes are a URDF.
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace qerr::fuzz;
  accept_or_refuse([&] { qerr::parse_urdf(text_of(data, size), "robot.urdf"); });
  return 0;
}
