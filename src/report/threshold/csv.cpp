#include "report/csv_text.hpp"
#include "report/formats.hpp"
#include "report/output_schemas.hpp"

namespace qerr {

std::string to_csv(const ThresholdReport& r, const Style&) { return csv_of(r.rows, {"joint", "coupling"}); }

}  // namespace qerr
