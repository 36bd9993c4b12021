#include "support/log_file.hpp"

namespace qerr {
namespace {

using LogErrors = testing::LogFile;

struct Faulty {
  std::string text;
  std::string place;     // LINE:COLUMN
  std::string fragment;  // of the message
};

const std::string head = "time [s],shoulder.counts,shoulder.reference [rad]\n";

const std::vector<Faulty> faulty{
    // rows
    {head + "0,1,2\n1,2\n", "3:1", "found 2 cells; 3 cells"},
    {head + "0,1\n1,2,3\n", "2:1", "found 2 cells; 3 cells"},
    {head + "0,1,2,3\n", "2:1", "found 4 cells; 3 cells"},
    {head + "0,1,2\n0,1,2,\n", "3:1", "found 4 cells"},
    {head + "0,1,2,\n", "accepted", ""},
    {head + "0,1,2\n1,2", "3:1", "was the recording cut off?"},
    {head + "0,1,2\n# pause\n1,1,2\n", "accepted", ""},
    {head + "0,1,2\n" + head + "1,1,2\n", "accepted", ""},
    {head + "0,1,2\n1,,2\n", "3:3", "shoulder.counts: the cell is empty"},
    {head + "0,1,2\n1,1, \n", "3:6", "the cell is empty"},
    {head + "0,1,nan\n", "2:5", "shoulder.reference [rad]: not a finite decimal number, found 'nan'"},
    {head + "0,1,-inf\n", "2:5", "found '-inf'"},
    {head + "0,1,1e999\n", "2:5", "found '1e999'"},
    {head + "0,1,1e-999\n", "2:5", "found '1e-999'"},
    {head + "0,1,0x1G\n", "2:5", "found '0x1G'"},
    {head + "0,1,1e\n", "2:5", "found '1e'"},
    {head + "0,1,+-1\n", "2:5", "found '+-1'"},
    {head + "0,1,-\n", "2:5", "found '-'"},
    {head + "0,1,.\n", "2:5", "found '.'"},
    {head + "0,1,1 2\n", "2:5", "found '1 2'"},
    {head + "0,1,\xC3\xA9t\xC3\xA9\n", "2:5", "found '\xC3\xA9t\xC3\xA9'"},
    {head + "0,1,\x1B[2J\n", "2:5", "found '\\x1B[2J'"},
    {head + "0,1,\xFF\n", "2:5", "found '\xC3\xBF'"},  // Windows-1252
    {head + "0,\"1\n", "2:3", "a quotation mark is not closed"},
    {head + "0,\"1\"2,3\n", "2:6", "text follows the closing quote"},
    {head + "0,1,2\r1,1,2\n", "2:6", "a carriage return without a line feed"},
    {head + "0,1,2\r\r\n", "accepted", ""},
    {head + "0,1,2\n1,1,2\n0.5,1,2\n", "4:1", "time must not decrease, after 1 s, found '0.5'"},
    {head + "0,1,2\n0,1,2\n", "accepted", ""},
    {head + "0,1.2346,2\n1,7.3279,2\n", "2:3", "counts must be integers, found '1.2346'"},
    {head + "0,1.5,2\n", "accepted", ""},
    {head + "0,1e3,2\n1,4.000,2\n", "accepted", ""},
    {head + "0,9007199254740993,2\n", "accepted", ""},  // the double next to it is 2^53
    {head + "0,9007199254740994,2\n", "2:3", "beyond 2^53"},
    {head + "0,-18446744073709551615,2\n", "2:3", "beyond 2^53"},
    {"time [s],shoulder.counts,shoulder.reference [rev]\n0,1,1.7e308\n", "2:5", "too large"},
    {"n,time [s],shoulder.counts\n\"two\nlines\",0,x\n", "3:10", "found 'x'"},
    // headers
    {"", "1:1", "the file is empty"},
    {"\n\n", "3:1", "the file has no header"},
    {"# only this\n", "2:1", "the file has no header"},
    {head, "2:1", "the log has no rows"},
    {"0,1,2\n1,2,3\n", "1:1", "the log has no measured joint"},
    {std::string("\x7F"
                 "ELF\0\0\0\0\0\n",
                 10),
     "1:1", "is this a text file?"},
    {"\x1F\x8B\x08 gzip\n", "1:1", "gzip"},
    {std::string("\xFF\xFEt\0i\0m\0e\0", 10), "1:1", "the log has no measured joint"},
    {"# c\ntime [s],shoulder.counts,shoulder.counts\n0,1,2\n", "2:26", "duplicate column"},
    {"time [s],shoulder.counts,shoulder.reference [rad],shoulder.reference [deg]\n0,1,2,3\n", "1:51",
     "duplicate column"},
    {"time [m],shoulder.counts\n0,1\n", "1:1", "time [m]: the column has the wrong unit, found 'm'; use s"},
    {"time [s],shoulder.counts [rad]\n0,1\n", "1:10", "use count"},
    {"time [s],shoulder.counts [%]\n0,1\n", "1:10", "use count"},
    {"time [s],shoulder.measured [mm]\n0,1\n", "1:10", "use rad"},
    {"time [s],lift.measured [deg]\n0,1\n", "1:10", "use m"},
    {"time [s],lift.measured [furlong]\n0,1\n", "1:10", "unknown unit 'furlong'; such as [m]"},
    {"time [s],shoulder.counts,shoulder.velocity [m/s]\n0,1,2\n", "1:26", "use rad/s"},
    {"time [s],shoulder.counts,shoulder.effort [N]\n0,1,2\n", "1:26", "use N m, A, or 1"},
    {"time [s],shoulder.counts,shoulder.temperature [m]\n0,1,2\n", "1:26", "use K"},
    {"time [s],shoulder.counts,tip.x [rad]\n0,1,2\n", "1:26", "use m"},
    {"Time [s],shoulder.counts,stamp\n0,1,0\n", "1:1", "no column is called time, and several may be it"},
    // required combinations
    {"time [s],shoulder.reference [rad],sholder.counts\n0,1,2\n", "1:1",
     "shoulder: the joint has a reference but no measurement; add 'shoulder.counts' or "
     "'shoulder.measured [rad]'; is it 'sholder.counts'?"},
    {"time [s],lift.reference [m],shoulder.counts\n0,1,2\n", "1:1", "'lift.measured [m]'"},
    {"time [s],shoulder.counts,tip.x [m]\n0,1,2\n", "1:1", "elbow: the tip was tracked"},
    {"time [s],shoulder.effort [1]\n0,1\n", "1:1", "the log has no measured joint"},
};

TEST_F(LogErrors, HavePlaceRuleFoundAndRemedyForAnyBlockSize) {
  for (const Faulty& f : faulty) {
    const std::string message = refusal(f.text);
    if (f.place == "accepted") {
      EXPECT_EQ(message, "accepted") << f.text;
      continue;
    }
    EXPECT_EQ(message.substr(0, 9 + f.place.size()), "log.csv:" + f.place + ':') << message << '\n' << f.text;
    EXPECT_NE(message.find(f.fragment), std::string::npos) << message << '\n' << f.text;
    for (std::size_t block = 1; block <= f.text.size() + 1; block += 1 + block / 16)
      ASSERT_EQ(refused_again({.block_bytes = block, .block_rows = 10}), message) << block << '\n' << f.text;
  }
}

TEST_F(LogErrors, ALineThatIsTooLongIsRejectedBeforeItIsRead) {
  const LogOptions options{.block_bytes = 64, .longest_row = 200};
  const std::string rows = head + "0,1," + std::string(150, '0') + "2\n";
  EXPECT_EQ(refusal(rows, options), "accepted");
  EXPECT_EQ(refusal(rows + "1,1," + std::string(500, '0') + "2\n", options),
            "log.csv:3:1: a line is too long; at most 200 bytes");
  EXPECT_EQ(refusal(std::string(500, '#') + '\n' + head + "0,1,2\n", options),
            "log.csv:1:1: a line is too long; at most 200 bytes");
  EXPECT_EQ(refusal(head + "0,1,\"" + std::string(500, '\n'), options).substr(0, 44),
            "log.csv:2:5: a quotation mark is not closed;");
}

TEST_F(LogErrors, AFileThatCannotBeReadIsAFileSystemError) {
  for (const std::string& path : {folder.string(), (folder / "missing.csv").string()}) try {
      LogReader(path, spec);
      FAIL() << path;
    } catch (const Error& e) {
      EXPECT_EQ(e.trouble(), Trouble::file_system);
    }
}

}  // namespace
}  // namespace qerr
