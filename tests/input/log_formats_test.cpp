#include <cmath>
#include <cstdio>

#include "core/lists.hpp"
#include "input/log_table.hpp"
#include "support/log_file.hpp"

/// Logs as programs and spreadsheets write them: each is read as the plain table of the same numbers.
namespace qerr::log_formats_test {
namespace {

using LogFormats = qerr::testing::LogFile;

constexpr int rows = 40;

/// How a table is written.
struct Layout {
  char separator = ',', decimal = '.';
  bool quoted = false, trailing = false, carriage_returns = false;
  std::string before = "";         // lines before the header
  std::string encoding = "UTF-8";  // or UTF-8 with a byte-order mark, UTF-16LE, UTF-16BE, Windows-1252
};

std::string number(double value, int decimals, const Layout& l) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  std::string digits = text;
  if (const std::size_t point = digits.find('.'); point != std::string::npos) digits[point] = l.decimal;
  return l.quoted ? '"' + digits + '"' : digits;
}

std::string line(const std::vector<std::string>& cells, const Layout& l) {
  std::string text;
  for (const std::string& cell : cells) text += (text.empty() ? "" : std::string(1, l.separator)) + cell;
  if (l.trailing) text += l.separator;
  return text + (l.carriage_returns ? "\r\n" : "\n");
}

/// The bytes of an ASCII text with `°` and `é` in another encoding.
std::string encoded(const std::string& utf8, const std::string& encoding) {
  std::string out;
  const bool big = encoding == "UTF-16BE", wide = big || encoding == "UTF-16LE";
  if (encoding == "UTF-8 with a mark") out = "\xEF\xBB\xBF";
  if (wide) out = big ? "\xFE\xFF" : "\xFF\xFE";
  for (std::size_t i = 0; i < utf8.size(); ++i) {
    auto c = static_cast<unsigned char>(utf8[i]);
    if (c >= 0xC2 && !encoding.starts_with("UTF-8"))  // of two bytes: those of Latin-1
      c = static_cast<unsigned char>((c & 3) << 6 | (static_cast<unsigned char>(utf8[++i]) & 0x3F));
    if (wide && big) out += '\0';
    out += static_cast<char>(c);
    if (wide && !big) out += '\0';
  }
  return out;
}

std::string table(const std::vector<std::string>& header, const Layout& l) {
  std::string text = l.before + line(header, l);
  for (int i = 0; i < rows; ++i)
    text += line({number(0.01 * i, 2, l), number(7 * i - 100, 0, l), number(0.125 * i - 1, 3, l)}, l);
  return encoded(text, l.encoding);
}

const std::vector<std::string> plain_header{"time [s]", "shoulder.counts", "shoulder.reference [rad]"};

TEST_F(LogFormats, EverySeparatorDecimalMarkAndEncodingIsThePlainTable) {
  const Log plain = read(table(plain_header, {}));
  ASSERT_EQ(plain.rows, static_cast<std::uint64_t>(rows));
  ASSERT_TRUE(plain.warnings.empty());
  int tried = 0;
  for (const char separator : {',', ';', '\t', ' '})
    for (const char decimal : {'.', ','})
      for (const bool quoted : {false, true})
        for (const bool trailing : {false, true})
          for (const bool carriage_returns : {false, true})
            for (const std::string encoding : {"UTF-8", "UTF-8 with a mark", "UTF-16LE", "UTF-16BE"})
              for (const std::string before :
                   {"", "# a comment, with; marks\n", "Messung vom Montag\nGeraet;7\n\n"}) {
                if (separator == ',' && decimal == ',' && !quoted) continue;  // no reader could tell
                if (separator == ' ' && trailing) continue;
                Layout l{separator, decimal, quoted, trailing, carriage_returns, before, encoding};
                std::vector<std::string> header = plain_header;
                if (separator == ' ') header = {"time_s", "shoulder.counts", "shoulder.reference_rad"};
                const Log log = read(table(header, l));
                const std::string what = std::string(1, separator) + decimal + encoding + before +
                                         (quoted ? "q" : "") + (trailing ? "t" : "");
                ASSERT_EQ(log.rows, plain.rows) << what;
                ASSERT_TRUE((log.values == plain.values).all()) << what;
                ASSERT_EQ(log.columns[2].text.most_decimals, 3) << what;
                const bool said = separator != ',' || decimal == ',' || encoding.starts_with("UTF-16") ||
                                  before.starts_with('M');
                ASSERT_EQ(log.warnings.empty(), !said) << what;
                ++tried;
              }
  EXPECT_EQ(tried, 768 - 48 - 96);
}

TEST_F(LogFormats, AreReadInBlocksOfAnySize) {
  for (const Layout& l : {Layout{';', ',', false, true, true,
                                 "Pr\xC3\xBC"
                                 "fung\n",
                                 "Windows-1252"},
                          Layout{'\t', ',', false, false, true, "", "UTF-16LE"}, Layout{' ', '.'}}) {
    std::vector<std::string> header = plain_header;
    if (l.separator == ' ') header = {"t_s", "shoulder.counts", "shoulder.reference_rad"};
    const Log whole = read(table(header, l));
    ASSERT_EQ(whole.rows, static_cast<std::uint64_t>(rows));
    for (const std::size_t block : {1, 2, 3, 7, 64, 1000})
      ASSERT_TRUE((reread({.block_bytes = block, .block_rows = 7}).values == whole.values).all()) << block;
  }
}

TEST_F(LogFormats, LinesOfAnyLayoutAreTheirCells) {
  const Log plain = read(table(plain_header, {}));
  const auto written = [](const char* format) {
    std::string text;
    for (int i = 0; i < rows; ++i) {
      char line[200];
      std::snprintf(line, sizeof line, format, 0.01 * i, 7 * i - 100, 0.125 * i - 1);
      text += line;
    }
    return text;
  };
  struct Laid {
    std::string before;
    const char* format;
    bool by_number;
  };
  for (const Laid& l :
       {Laid{"", "{\"time [s]\": %.2f, \"shoulder.counts\": %d, \"shoulder.reference [rad]\": %.3f}\n",
             false},
        Laid{"", "time:%.2f,shoulder.counts:%d,shoulder.reference:%.3f\n", false},
        Laid{"", "time=%.2f shoulder.counts=%d shoulder.reference=%.3f\n", false},
        Laid{"time [s],shoulder.counts,shoulder.reference [rad]\r", "%.2f,%d,%.3f\r", false},
        Laid{"| time [s] | shoulder.counts | shoulder.reference [rad] |\n|---|---:|---|\n",
             "| %.2f | %d | %.3f |\n", false},
        Laid{"", "00:00:%05.2f -> shoulder.counts:%d,shoulder.reference:%.3f\n", false},
        Laid{"", "[%.2f, %d, %.3f]\n", true}, Laid{"", "00:00:%05.2f -> %d,%.3f\n", true}}) {
    spec = spec_with("'*': {counts_per_rev: 4096}, lift: {resolution: 10 um}");
    for (const char* column : {"time=column 1", "shoulder.counts=column 2", "shoulder.reference=column 3"})
      if (l.by_number) map_column(column, spec);
    for (const std::size_t block : {std::size_t{1} << 18, std::size_t{7}}) {
      const Log log = read(l.before + written(l.format), LogOptions{.block_bytes = block});
      ASSERT_EQ(log.rows, plain.rows) << l.format;
      ASSERT_LT((log.values - plain.values).abs().maxCoeff(), 1e-12) << l.format;
    }
  }
}

TEST_F(LogFormats, NumbersOfOtherNotations) {
  const Log log =
      read("time [s],shoulder.counts,shoulder.reference [rad]\n0.0D+00,0x1F,1.5D-03\n1.0D0,0X20,2.5d-3\n");
  EXPECT_EQ(values(log, LogSignal::time)[1], 1);
  EXPECT_EQ(values(log, LogSignal::counts)[0], 31);
  EXPECT_EQ(values(log, LogSignal::reference)[1] - values(log, LogSignal::reference)[0], 2.5e-3 - 1.5e-3);
}

TEST_F(LogFormats, SummariesBehindABlankLineAreLeftOut) {
  const std::string head = "time [s],shoulder.counts\n0,1\n1,2\n";
  const Log log = read(head + "\nMean,1.5\nMax,2\n\n");
  EXPECT_EQ(log.rows, 2u);
  ASSERT_EQ(log.warnings.size(), 1u);
  EXPECT_NE(log.warnings[0].find("2 lines of words"), std::string::npos) << log.warnings[0];
  EXPECT_NE(refusal(head + "Mean,1.5\n"), "accepted") << "a row among the rows is a fault";
}

struct Header {
  std::string time, reference;  // cells
  double time_unit, reference_unit;
};

TEST_F(LogFormats, UnitsInOtherWordsAreTheirUnits) {
  const double deg = std::acos(-1.0) / 180;
  for (const Header& h : std::vector<Header>{{"Time (ms)", "shoulder.reference (deg)", 1e-3, deg},
                                             {"t_us", "shoulder.reference [degrees]", 1e-6, deg},
                                             {"Zeit / s", "shoulder.reference (\xC2\xB0)", 1, deg},
                                             {"Zeit [Sekunden]", "shoulder.reference in Grad", 1, deg},
                                             {"Time [Sec]", "shoulder.reference [DEG]", 1, deg},
                                             {"Time [sek]", "shoulder.reference [mRad]", 1, 1e-3},
                                             {"temps (secondes)", "shoulder.reference_mrad", 1, 1e-3},
                                             {"timestamp [nanoseconds]", "shoulder.reference / rad", 1e-9, 1},
                                             {"__time", "shoulder.reference [arcseconds]", 1, deg / 3600},
                                             {"millis", "shoulder.reference (turns)", 1e-3, 360 * deg},
                                             {"Tiempo (segundos)", "shoulder.reference [gradi]", 1, deg},
                                             {"Time ms", "shoulder.reference mrad", 1e-3, 1e-3},
                                             {"msec", "shoulder.reference/turns", 1e-3, 360 * deg}}) {
    const Log log = read(table({h.time, "shoulder.counts", h.reference}, {';', '.'}));
    const Eigen::ArrayXd time = values(log, LogSignal::time), reference = values(log, LogSignal::reference);
    for (int i = 0; i < rows; ++i) {
      ASSERT_NEAR(time[i], 0.01 * i * h.time_unit, 1e-15) << h.time;
      // The reference may be whole turns from the counts.
      const double wanted = (0.125 * i - 1) * h.reference_unit;
      ASSERT_NEAR(std::remainder(reference[i] - wanted, 360 * deg), 0, 1e-12) << h.reference;
    }
  }
}

TEST_F(LogFormats, AUnitsRowBehindTheHeaderIsTheUnits) {
  for (const std::string units : {"ms;count;deg\n", "[ms];;[deg]\n", "(ms);-;(degrees)\n"}) {
    const Log log =
        read("Zeit;shoulder.counts;shoulder.reference\n" + units + "0;1;0,5\n10;2;1,5\n20;3;2,5\n");
    EXPECT_EQ(values(log, LogSignal::time)[2], 0.02) << units;
    EXPECT_NEAR(values(log, LogSignal::reference)[1], 1.5 * std::acos(-1.0) / 180, 1e-15) << units;
  }
}

struct Stamps {
  std::string header, first, second;
  double step;
};

TEST_F(LogFormats, StampsOfCalendarsAndEpochsAreSeconds) {
  for (const Stamps& s :
       std::vector<Stamps>{{"Zeit", "26.11.2026 17:16:42,123", "26.11.2026 17:16:42,133", 0.01},
                           {"horodatage", "26/11/2026 23:59:59,990", "27/11/2026 00:00:00,000", 0.01},
                           {"Timestamp", "2026-11-26T17:16:42.123+01:00", "2026-11-26T16:16:42.133Z", 0.01},
                           {"Time", "11/26/2026 5:16:42.25 PM", "11/26/2026 5:16:42.50 PM", 0.25},
                           {"Uhrzeit", "17:16:42,123", "17:16:43,125", 1.002},
                           {"time", "1700000000123", "1700000000133", 0.01},
                           {"time", "1700000000123456", "1700000000123556", 1e-4},
                           {"time", "1700000000123456789", "1700000000123456790", 1e-9},
                           {"stamp", "1700000000.25", "1700000000.75", 0.5},
                           {"timestamp", "5000", "6000", 1e-3},
                           {"timestamp", "20", "30", 0.01},
                           {"time", "8", "16", 0.008},
                           {"time", "30", "60", 30},
                           {"timestamp", "1764177402", "1764177412", 10},
                           {"time", "134087534020000000", "134087534020100000", 0.01},
                           {"time", "638000000000000000", "638000000000100000", 0.01},
                           {"Time", "2026/11/26-17:16:42:000", "2026/11/26-17:16:42:250", 0.25},
                           {"Time", "0.01 sec", "0.02 sec", 0.01},
                           {"", "0.00", "0.01", 0.01},
                           {"Datum/Uhrzeit", "26.11.2026 17:16:42", "26.11.2026 17:16:43", 1},
                           {"Messpunkt", "26.11.2026 17:16:42", "26.11.2026 17:16:43", 1},
                           {"Rel. Time", "0.5", "0.75", 0.25},
                           {"Sekunden", "0.5", "0.75", 0.25},
                           {"uptime_ms", "500", "750", 0.25},
                           {"ts", "0.5", "0.75", 0.25},
                           {"Time", "14-Mar-2026 17:16:42.25", "14-Mar-2026 17:16:42.50", 0.25},
                           {"Zeit", "14. M\u00e4rz 2026 17:16:42", "14. M\u00e4rz 2026 17:16:43", 1},
                           {"", "0 days 23:59:59.750000", "1 days 00:00:00.250000", 0.5},
                           {"time", "09:15:00:250", "09:15:00:500", 0.25},
                           {"Time", "11/05/2026 11:59:59 PM", "11/06/2026 12:00:00 AM", 1},
                           {"Time", "05/11/2026 23:59:59", "06/11/2026 00:00:00", 1},
                           {"Time", "11/12/2026 23:59:59", "11/13/2026 00:00:00", 1},
                           {"Time", "11/30/2026 23:59:59", "12/01/2026 00:00:00", 1}}) {
    const std::string third = s.second;
    const Log log = read(s.header + ";shoulder.counts\n" + s.first + ";1\n" + s.second + ";2\n");
    const Eigen::ArrayXd time = values(log, LogSignal::time);
    EXPECT_NEAR(time[1] - time[0], s.step, 1e-12) << s.first;
    EXPECT_FALSE(log.warnings.empty()) << s.first << ": is said";
  }
}

TEST_F(LogFormats, DatesOfExcelAreDays) {
  std::string text = "Time,shoulder.counts\n";
  for (int i = 0; i < 20; ++i) {
    char cell[40];
    std::snprintf(cell, sizeof cell, "%.10f,%d\n", 46352.3854166667 + 0.01 * i / 86400, i);
    text += cell;
  }
  const Log log = read(text);
  EXPECT_NEAR(values(log, LogSignal::time)[19] - values(log, LogSignal::time)[0], 0.19, 2e-5);
  EXPECT_NE(log.warnings[0].find("as Excel counts them"), std::string::npos) << log.warnings[0];
  const Log matlab =
      read("t,shoulder.counts\n740000.50000000,1\n740000.50000012,2\n740000.50000023,3\n740000.50000035,3\n");
  EXPECT_NEAR(values(matlab, LogSignal::time)[3] - values(matlab, LogSignal::time)[0], 0.03, 1e-3);
  EXPECT_EQ(values(read("Time,shoulder.counts\n46352.5,1\n46352.75,2\n46353,2\n"), LogSignal::time)[1],
            46352.75)
      << "the time since a controller was switched on";
}

TEST_F(LogFormats, SecondsAndNanosecondsAreOneStamp) {
  for (const char* header :
       {"header.stamp.sec,header.stamp.nanosec", "header_stamp_secs,header_stamp_nsecs", "sec,nanosec"}) {
    const Log log = read(std::string(header) + ",shoulder.counts\n1700000000,999999999,1\n1700000001,4,2\n");
    EXPECT_NEAR(values(log, LogSignal::time)[1] - values(log, LogSignal::time)[0], 5e-9, 1e-15) << header;
    EXPECT_EQ(log.warnings.size(), 1u) << header;
  }
  EXPECT_NE(refusal("sec,nanosec,shoulder.counts\n1,2,1\n1.5,4,2\n").find("not whole seconds"),
            std::string::npos);
}

TEST_F(LogFormats, ANameThatIsSeldomTheTimeIsItByItsValuesOnly) {
  const std::string tail = ",shoulder.counts,shoulder.reference [rad]\n";
  for (const char* rows : {"2,1,0.5\n2,2,1\n2,3,1.5\n", "2,1,0.5\n1,2,1\n3,3,1.5\n"})
    EXPECT_FALSE(read("duration" + tail + rows).has_time()) << rows;
  EXPECT_FALSE(read("Date" + tail + "2026-11-26,1,0.5\n2026-11-27,2,1\n").has_time()) << "days alone";
  EXPECT_TRUE(read("duration" + tail + "1,1,0.5\n1.5,2,1\n").has_time());
  // Static poses beside a column that may be the time: that is said.
  const Log log = read("instant" + tail + "0,1,0.5\n0.01,2,1\n0.02,3,1.5\n");
  EXPECT_NE(log.warnings[0].find("--column 'time=instant [s]'"), std::string::npos) << log.warnings[0];
}

TEST_F(LogFormats, Utf16WithoutAMarkIsRead) {
  for (const char* encoding : {"UTF-16LE", "UTF-16BE"}) {
    Layout l;
    l.encoding = encoding;
    EXPECT_EQ(read(table(plain_header, l).substr(2)).rows, static_cast<std::size_t>(rows)) << encoding;
  }
}

TEST_F(LogFormats, WordsOfExcelAndUnitsInCellsHaveARemedy) {
  const std::string head = "time [s],shoulder.counts,shoulder.reference [rad]\n0,1,0.5\n1,2,";
  for (const char* word : {"#DIV/0!", "#WERT!", "#NV", "#NAME?", "########"})
    EXPECT_NE(refusal(head + word + "\n2,3,0.75\n").find("--set log.missing=drop"), std::string::npos)
        << word;
  for (const char* cell : {"1.5 deg", "1.5deg", "1.5\u00b0"})
    EXPECT_NE(refusal(head + cell + "\n2,3,0.75\n").find("'shoulder.reference [deg]'"), std::string::npos)
        << cell;
}

TEST_F(LogFormats, APositionOfNoKnownUnitIsAsked) {
  EXPECT_NE(refusal("time [s],shoulder.counts,shoulder.reference\n0,1,100234\n1,2,100289\n")
                .find("are they counts?"),
            std::string::npos);
  EXPECT_NE(refusal("time [s],shoulder.counts,shoulder.reference (arc feet)\n0,1,3\n1,2,4\n")
                .find("unknown unit, found '(arc feet)'; such as [rad], or what one step is: [0.001 rad]"),
            std::string::npos);
}

TEST_F(LogFormats, ClocksThatBeginAgainGoOn) {
  for (const Stamps& s : std::vector<Stamps>{{"time", "23:59:59.75", "00:00:00.25", 0.5},
                                             {"time", "59:59.75", "00:00.25", 0.5},
                                             {"time [us]", "4294967290", "4", 1e-5},
                                             {"time [ms]", "4294967290", "4", 1e-2}}) {
    const Log log = read(s.header + ",shoulder.counts\n" + s.first + ",1\n" + s.second + ",2\n");
    EXPECT_NEAR(values(log, LogSignal::time)[1] - values(log, LogSignal::time)[0], s.step, 1e-9) << s.first;
    EXPECT_FALSE(log.warnings.empty()) << s.first << ": is said";
  }
  EXPECT_NE(refusal("time [s],shoulder.counts\n10,1\n4,2\n").find("must not decrease"), std::string::npos);
}

TEST_F(LogFormats, APointInATableOfDecimalCommasIsAsked) {
  const std::string head = "time [s];shoulder.counts;shoulder.reference [rad]\n";
  EXPECT_NE(refusal(head + "0,0;1;1,5\n0,1;2;1.234\n").find("of thousands, or of decimals?"),
            std::string::npos);
  const Log log = read(head + "0,0;1;1,5\n0,1;2;0.125\n0,2;1.234.567,0;-1.234,5\n");
  EXPECT_NE(refusal(head + "0,0;1.234;1,5\n0,1;2;1,25\n").find("of thousands, or of decimals?"),
            std::string::npos);
  EXPECT_EQ(values(log, LogSignal::counts)[2], 1234567);
  EXPECT_EQ(values(read(head + "0,0;1;-1.234,5\n0,1;1.234;0,125\n"), LogSignal::counts)[1], 1234)
      << "the points of this table are of thousands";
  EXPECT_EQ(values(log, LogSignal::reference)[1] - values(log, LogSignal::reference)[0], 0.125 - 1.5)
      << "0.125 can be no thousands";
  // English thousands in a table without any other decimals.
  std::string rows, german;
  for (int i = 0; i < 9; ++i) {
    rows += std::to_string(i) + ";" + std::to_string(i) + ";64,86" + std::to_string(i) + '\n';
    german += std::to_string(i) + ";" + std::to_string(i) + ";0,86" + std::to_string(i) + '\n';
  }
  EXPECT_NE(refusal(head + rows).find("of thousands, or of decimals?"), std::string::npos);
  EXPECT_EQ(values(read(head + german), LogSignal::reference)[1], 0.861);
}

TEST_F(LogFormats, GroupsOfThousandsAreReadWithAnyMark) {
  struct Written {
    std::string count, angle;
  };
  for (const Written& w : {Written{"1.234.567", "-1.234,5"},
                           {"1\u202f234\u202f567", "-1\u202f234,5"},
                           {"1\u00a0234\u00a0567", "-1\u00a0234,5"},
                           {"1 234 567", "-1 234,5"},
                           {"1'234'567", "-1'234.5"},
                           {"1\u2019234\u2019567", "-1\u2019234.5"},
                           {"1,234,567", "-1,234.5"}}) {
    // Two rows, as of a static calibration, have to tell the format, too.
    const Log log = read("time [s];shoulder.counts;shoulder.reference [deg]\n0;" + w.count + ';' + w.angle +
                         "\n1;" + w.count + ';' + w.angle + '\n');
    ASSERT_EQ(log.rows, 2u) << w.count;
    EXPECT_EQ(values(log, LogSignal::counts)[0], 1234567) << w.count;
    const double turns = std::round((-1234.5 / 360 - 1234567 / 4096.));  // are removed from a reference
    EXPECT_NEAR(values(log, LogSignal::reference)[1], (-1234.5 - 360 * turns) * std::acos(-1.0) / 180, 1e-9)
        << w.angle;
  }
  const Log log = read("time [ms];shoulder.counts\n900;1\n1'000;2\n1'100;3\n");
  EXPECT_NEAR(values(log, LogSignal::time)[2] - values(log, LogSignal::time)[0], 0.2, 1e-12);
}

TEST_F(LogFormats, ACommaBeforeAUnitSeparatesNoColumns) {
  const Log log = read("Bench 4\nTime, ms,shoulder.counts,shoulder.reference, deg\n0,1,0.5\n10,2,1.0\n");
  EXPECT_NEAR(values(log, LogSignal::time)[1], 0.01, 1e-15);
  EXPECT_EQ(values(log, LogSignal::counts)[1], 2);
  EXPECT_NEAR(values(log, LogSignal::reference)[1], std::acos(-1.0) / 180, 1e-15);
  // Where the rows have a cell for each of them they are columns.
  EXPECT_EQ(values(read("time [s],s,shoulder.counts\n0,1,7\n1,2,8\n"), LogSignal::counts)[1], 8);
}

TEST_F(LogFormats, DecimalCommasBehindTheSampleAreRead) {
  std::string text = "time [s];shoulder.counts;shoulder.reference [rad]\n";
  for (int i = 0; i < 9000; ++i) text += std::to_string(i) + ';' + std::to_string(i) + ";0\n";
  const Log log = read(text + "9000,5;7;0,25\n9001,5;7;0,5\n");
  EXPECT_EQ(values(log, LogSignal::time)[9001], 9001.5);
  EXPECT_EQ(values(log, LogSignal::reference)[9000], 0.25);
}

std::vector<double> list(const Log& log, LogSignal signal) {
  const Eigen::ArrayXd all = log.values.col(log.find(signal, 0).value());
  return {all.begin(), all.end()};
}

TEST_F(LogFormats, EmptyRowsAtTheEndAreNone) {
  const std::string head = "time [s];shoulder.counts;shoulder.reference [deg];;\n";
  std::string empty;
  for (int i = 0; i < 70000; ++i) empty += ";;;;\r\n";  // longer than a block
  for (const std::string& end : {std::string(";;;;"), empty, std::string("\"\"; ;;;\n\n;;;;\n")}) {
    const Log log = read(head + "0,0;1;1,5;;\n0,1;2;2,5;;\n" + end);
    EXPECT_EQ(list(log, LogSignal::counts), (std::vector<double>{1, 2}));
    EXPECT_NE(qerr::joined(log.warnings, "\n").find("at the end"), std::string::npos);
  }
  EXPECT_NE(refusal(head + "0,0;1;1,5;;\n;;;;\n0,1;2;2,5;;\n").find("the cell is empty"), std::string::npos);
  EXPECT_EQ(qerr::joined(read("time [s],shoulder.counts\n0,1\n1,2\n\n\n").warnings, "\n").find("at the end"),
            std::string::npos);
}

TEST_F(LogFormats, CellsMayHaveTextMarksAndUnits) {
  const Log marked = read("time [s];shoulder.counts;shoulder.reference [rad]\n0,00;'1;'-1,5\n0,01;'2;0,25\n");
  EXPECT_EQ(list(marked, LogSignal::counts), (std::vector<double>{1, 2}));
  const Log with_units =
      read("time;shoulder.counts;shoulder.reference\n0,0 ms;1;0,0 deg\n10,0 ms;2;180 deg\n");
  EXPECT_EQ(values(with_units, LogSignal::time)[1], 0.01);
  EXPECT_NEAR(values(with_units, LogSignal::reference)[1] - values(with_units, LogSignal::reference)[0],
              std::acos(-1.0), 1e-15);
  // Neither the unit of the header, nor that of the other rows.
  for (const std::string rows :
       {"shoulder.reference [rad]\n0;1;0 deg\n1;2;180 deg\n", "shoulder.reference\n0;1;0 deg\n1;2;3 mrad\n"})
    EXPECT_NE(refusal("time;shoulder.counts;" + rows).find("write the unit in the header"),
              std::string::npos);
}

TEST_F(LogFormats, PipesSeparateAndCommasEndNamesAboveBlanks) {
  const Log piped = read("time [s]|shoulder.counts [-]|shoulder.reference (rad)\n0|1|0.5\n0.1|2|0.25\n");
  EXPECT_EQ(list(piped, LogSignal::counts), (std::vector<double>{1, 2}));
  const Log blanks = read("% time, shoulder.counts, shoulder.reference\n 0 1 0.5\n 0.1 2 0.25\n");
  EXPECT_EQ(list(blanks, LogSignal::counts), (std::vector<double>{1, 2}));
  EXPECT_NE(refusal("[{\"time\": 0, \"shoulder.counts\": 1}]\n").find("jq -c"), std::string::npos);
}

TEST_F(LogFormats, AColumnMayHaveDecimalCommasBesidePoints) {
  const std::string head = "time [s];shoulder.counts;shoulder.reference [rad]\n";
  const Log log = read(head + "0,000;1;0.5\n0,010;2;0.25\n1,020;3;0.125\n");
  EXPECT_EQ(list(log, LogSignal::time), (std::vector<double>{0, 0.01, 1.02}));
  EXPECT_EQ(values(log, LogSignal::reference)[1], 0.25);
  EXPECT_NE(refusal(head + "0;1;0.5\n0.1;2;0,25\n").find("one decimal mark"), std::string::npos);
  EXPECT_NE(refusal(head + "0.1;1;0.5\n0,2;2;0.25\n").find("one decimal mark"), std::string::npos);
  // Of thousands, or of decimals; and what no row of a sample has shown.
  EXPECT_NE(refusal("time [s];shoulder.counts;shoulder.reference "
                    "[rad];a;b;c\n0,00;1,024;0.5;0.5;0.5;0.5\n0,01;2,048;0.2;0.5;0.5;0.5\n")
                .find("of thousands, or of decimals"),
            std::string::npos);
  std::string rows;
  for (int i = 0; i < 300; ++i) rows += "0," + std::to_string(1000 + i) + ";1;0.5\n";
  for (const std::string last : {"1.234", "1.234,5", "1,234,567"})
    EXPECT_NE(refusal(head + rows + last + ";1;0.5\n").find("without marks of thousands"), std::string::npos)
        << last;
}

TEST_F(LogFormats, ALastHexadecimalDigitIsNoUnit) {
  EXPECT_EQ(list(read("time [s],shoulder.counts\n0,0x6A\n1,0x6A\n2,0x6d\n"), LogSignal::counts),
            (std::vector<double>{0x6A, 0x6A, 0x6d}));
  EXPECT_EQ(list(read("time [s],shoulder.counts\n0,0x6d\n1,0x6d\n"), LogSignal::counts),
            (std::vector<double>{0x6d, 0x6d}));
}

TEST_F(LogFormats, CapitalUnitsAreReadWhereOneIsMeant) {
  const auto second = [&](const std::string& time, const std::string& angle) {
    const Log log =
        read("time [" + time + "],shoulder.counts,shoulder.reference [" + angle + "]\n0,0,0\n1,1,0.25\n");
    return std::pair(values(log, LogSignal::time)[1], values(log, LogSignal::reference)[1]);
  };
  constexpr double turn = 6.283185307179586;
  EXPECT_EQ(second("MS", "U"), std::pair(1e-3, turn / 4));
  EXPECT_NEAR(second("S", "GON").second, turn / 1600, 1e-15);
  EXPECT_EQ(second("Sek.", "RAD"), std::pair(1.0, 0.25));
  EXPECT_NE(refusal("time [Ms],shoulder.counts\n0,0\n1,1\n").find("did you mean [ms]?"), std::string::npos);
  EXPECT_NE(refusal("time,shoulder.counts,shoulder.reference [grad]\n0,0,0\n1,1,1\n").find("[gon]"),
            std::string::npos);
}

TEST_F(LogFormats, AMissingHeaderIsNumbered) {
  spec = spec_with("'*': {counts_per_rev: 4096}, lift: {resolution: 10 um}",
                   "log: {time: column 1, columns: {shoulder.counts: column 2, "
                   "shoulder.reference: {column: column 3, unit: deg}}}\n");
  const Log log = read("0.0 1 0.5\n0.1 2 1.0\n");
  EXPECT_EQ(values(log, LogSignal::counts)[1], 2);
  EXPECT_NEAR(values(log, LogSignal::reference)[1], std::acos(-1.0) / 180, 1e-15);
}

TEST_F(LogFormats, ACommentMayBeTheHeader) {
  const Log log = read("# time_ms shoulder.counts shoulder.reference_deg\n0.0 1 0.5\n100.0 2 1.0\n");
  EXPECT_EQ(values(log, LogSignal::time)[1], 0.1);
}

TEST_F(LogFormats, OtherBinariesAreNamedWithARemedy) {
  for (const auto& [head, fragment] : std::vector<std::pair<std::string, std::string>>{
           {"MATLAB 5.0 MAT-file, Platform: PCWIN64", "writetable"},
           {"\x89HDF\r\n\x1A\n", "HDF5"},
           {"PAR1", "read_parquet"},
           {"#ROSBAG V2.0\n", "mcap convert"},
           {"PK\x03\x04", "spreadsheet"},
           {"\x93NUMPY", "savetxt"}}) {
    const std::string message = refusal(head + std::string(100, 'x'));
    EXPECT_NE(message.find("the table must be a text; "), std::string::npos) << message;
    EXPECT_NE(message.find(fragment), std::string::npos) << message;
  }
}

}  // namespace
}  // namespace qerr::log_formats_test
