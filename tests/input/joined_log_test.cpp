#include "support/log_file.hpp"

namespace qerr {
namespace {

class JoinedLogs : public testing::LogFile {
 protected:
  std::string file(const std::string& name, const std::string& text) {
    std::ofstream(folder / name, std::ios::binary) << text;
    return (folder / name).string();
  }
  std::string fault(const LogFiles& files) {
    try {
      read_log(files, spec);
    } catch (const Error& e) {
      return e.what();
    }
    return "accepted";
  }
};

const std::string wide =
    "time [s],shoulder.counts,shoulder.reference [rad]\n0,1,0.5\n1,2,0.5\n2,2,0.7\n3,4,0.7\n";
const std::string interleaved =
    "time [s],signal,value\n-1,shoulder.counts,7\n0,shoulder.counts,1\n0,shoulder.reference [rad],0.5\n"
    "0,state,idle\n1,shoulder.counts,2\n2,shoulder.reference [rad],0.7\n3,shoulder.counts,4\n";

TEST_F(JoinedLogs, LongFormatGivesTheRowsOfTheWideOne) {
  const Log expected = read(wide), log = read(interleaved);
  ASSERT_EQ(log.values.rows(), 4);
  EXPECT_TRUE((log.values == expected.values).all());
  EXPECT_EQ(log.columns[2].unit, "rad");
  EXPECT_EQ(log.columns[2].text.most_decimals, 1);
  EXPECT_EQ(log.first_time, 0);
  EXPECT_NE(log.warnings.back().find("1 row before the first value"), std::string::npos);
}

TEST_F(JoinedLogs, SignalsOneAfterTheOtherAreSortedByTime) {
  const Log log = read(
      "value,unit,time [ms],signal\n1,count,0,shoulder.counts\n2,count,1000,shoulder.counts\n"
      "4,count,3000,shoulder.counts\n0.5,rad,0,shoulder.reference\n0.7,rad,2000,shoulder.reference\n");
  EXPECT_TRUE((log.values == read(wide).values).all());
  EXPECT_NE(log.warnings.back().find("sorted by time"), std::string::npos);
}

TEST_F(JoinedLogs, FilesAreJoinedByTimeInTheirUnits) {
  const std::string counts = file("counts.csv", "time [s],shoulder.counts\n0,1\n1,2\n3,4\n");
  const std::string reference =
      file("reference.csv",
           "time [ms],signal,value\n0,shoulder.reference [rad],0.5\n2000,shoulder.reference [rad],0.7\n");
  const Log log = read_log(LogFiles({counts, reference}), spec);
  EXPECT_TRUE((log.values == read(wide).values).all());
}

TEST_F(JoinedLogs, EmptyCellsAreHeldOnDemand) {
  const std::string path =
      file("wide.csv", "time [s],shoulder.counts,shoulder.reference [rad]\n0,1,0.5\n1,2,\n2,,0.7\n3,4,\n");
  EXPECT_TRUE((read_log(LogFiles({path}, true), spec).values == read(wide).values).all());
  EXPECT_NE(fault(path).find("--hold"), std::string::npos) << fault(path);
}

TEST_F(JoinedLogs, ErrorsNameThePlace) {
  const std::string counts = file("a.csv", "time [s],shoulder.counts\n0,1\n");
  const std::string again = file("b.csv", "time [s],shoulder.counts\n0,1\n");
  const std::string both = fault(LogFiles({counts, again}));
  EXPECT_NE(both.find("b.csv:1:10"), std::string::npos) << both;
  EXPECT_NE(both.find("also in"), std::string::npos) << both;
  const std::string untimed = fault(LogFiles({counts, file("c.csv", "elbow.counts\n1\n")}));
  EXPECT_NE(untimed.find("joined by time"), std::string::npos) << untimed;
  const std::string back =
      fault(file("d.csv", "time [s],signal,value\n1,shoulder.counts,1\n0,shoulder.counts,2\n"));
  EXPECT_NE(back.find("d.csv:3:1"), std::string::npos) << back;
  EXPECT_NE(back.find("within a signal"), std::string::npos) << back;
  const std::string text = fault(file("e.csv", "time [s],signal,value\n1,shoulder.counts,off\n"));
  EXPECT_NE(text.find("e.csv:2:19"), std::string::npos) << text;
}

}  // namespace
}  // namespace qerr
