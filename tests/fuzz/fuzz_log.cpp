#include "fuzz/target.hpp"
#include "qerr/input/read_log.hpp"

/// The bytes are a measured log, which is read in blocks of a few bytes and rows, so that their ends are met.
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace qerr::fuzz;
  static const qerr::Spec spec =
      qerr::parse_spec(arm_spec("configurations: {count: 5, limits: {wrist: [-180 deg, 180 deg]}}\n"),
                       folder().file("spec.yaml"));
  const std::string log = folder().write("log.csv", data, size);
  accept_or_refuse([&] {
    qerr::LogReader reader(log, spec, {.block_bytes = 64, .longest_row = 4096, .block_rows = 4});
    for (Eigen::ArrayXXd rows; reader.next(rows);)
      if (!rows.isFinite().all()) std::abort();
  });
  return 0;
}
