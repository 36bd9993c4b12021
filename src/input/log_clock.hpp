#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "input/csv.hpp"
#include "qerr/core/quantity.hpp"

namespace qerr {

/// A time stamp, exact to 1e-18 s; both parts have one sign.
struct TimeStamp {
  std::int64_t seconds = 0, attoseconds = 0;
};

/// The unit of a stamp without one that counts from 1970, by its size: `ms`, `us` or `ns`, or `100 ns` from
/// 1601 or the year 1; "" for a smaller one, in seconds.
std::string epoch_unit(double stamp);

/// A date as days since 1970. In `11/05/2026` day and month may be exchanged, then the other reading, too.
struct CalendarDate {
  std::int64_t days = 0;
  std::optional<std::int64_t> exchanged;
  bool month_first = false;  ///< as the numbers say: `11/26/2026`
};

/// A date with the number of its month in place of the name: `14-Mar-2026` is `14-3-2026`; other texts are
/// returned as they are.
std::string with_month_number(std::string_view text);

/// The time stamps of a log, in seconds after one origin.
///
/// A double resolves 1 ns up to 2^23 s (97 days). A log whose first stamp lies beyond counts from an epoch:
/// this stamp becomes the origin, and it is subtracted before a stamp is rounded to double.
class LogClock {
 public:
  /// @param text  a decimal number in `unit` or, for a unit of 1 s, `2026-05-01T12:00:00.5Z` (ISO 8601),
  /// `26.11.2026 17:16:42,123`, `14-Mar-2026 17:16:42`, or a time of day, of the next day (`mm:ss.5` of the
  /// next hour) where it falls by more than half of one; a counter of 32 bits may roll over. With slashes the
  /// day is first, unless a stamp says or the next date shows that the month is; memory as of
  /// CsvReader::chosen_text
  /// @returns empty if it is none, or out of the range of double
  std::optional<double> seconds(std::string_view text, const Unit&, WrittenNumbers&);

  double seconds(const TimeStamp&);
  double seconds(double stamp);  ///< [s]

  /// What the stamps are taken for that are no plain time: "" or "they run over midnight".
  const std::string& remark() const { return remark_; }
  /// Recorded time of the origin [s].
  double origin() const;

 private:
  double unwrapped(double number, const Unit&);
  std::int64_t days(const CalendarDate&);

  std::optional<TimeStamp> origin_;
  std::optional<CalendarDate> last_date_;
  bool month_first_ = false;
  std::int64_t shift_ = 0;  ///< days by which dates before `month_first_` was known were read too late

  std::optional<std::int64_t> last_time_of_day_;  ///< [s], over all days
  double last_number_ = 0, rollovers_ = 0;        ///< of a counter of 32 bits
  std::string remark_;
};

}  // namespace qerr
