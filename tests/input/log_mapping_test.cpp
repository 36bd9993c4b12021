#include <cmath>
#include <cstdio>
#include <numbers>

#include "input/log_table.hpp"
#include "support/log_file.hpp"

/// Columns by a mapping of the spec or the command line, and the mapping that is proposed for a log of
/// unknown columns: it works when it is pasted.
namespace qerr::log_mapping_test {
namespace {

class LogMapping : public qerr::testing::LogFile {
 protected:
  Spec spec_of(const std::string& more) {
    return spec_with("'*': {counts_per_rev: 4096}, lift: {resolution: 10 um}", more);
  }
  /// The section `log:` that the refusal of a log proposes.
  std::string proposed(const std::string& text) {
    const std::string message = refusal(text);
    const std::size_t at = message.find("\nlog:\n");
    return at == std::string::npos ? "none: " + message : message.substr(at + 1) + '\n';
  }
};

const std::string strange = "t_ms,q1_motor,q1_link\n0,1,0.5\n10,2,1\n20,3,1.5\n";

TEST_F(LogMapping, OfTheSpecNamesColumnsAndUnits) {
  spec = spec_of(
      "log: {time: {column: t_ms, unit: ms}, columns: {shoulder.counts: q1_motor, shoulder.reference: "
      "{column: q1_link, unit: deg}}}\n");
  const Log log = read(strange);
  EXPECT_EQ(values(log, LogSignal::time)[2], 0.02);
  EXPECT_EQ(values(log, LogSignal::counts)[2], 3);
  EXPECT_NEAR(values(log, LogSignal::reference)[2], 1.5 * std::numbers::pi / 180, 1e-15);
}

TEST_F(LogMapping, OfTheCommandLineReplacesThatOfTheSpec) {
  spec = spec_of("log: {columns: {shoulder.counts: q1_link, shoulder.reference: nothing}}\n");
  map_column("shoulder.counts=q1_motor", spec);
  map_column("shoulder.reference=q1_link [deg]", spec);
  const Log log = read(strange);
  EXPECT_EQ(values(log, LogSignal::counts)[2], 3);
  EXPECT_NEAR(values(log, LogSignal::reference)[2], 1.5 * std::numbers::pi / 180, 1e-15);
  EXPECT_EQ(values(log, LogSignal::time)[2], 0.02) << "t_ms is recognized";
}

TEST_F(LogMapping, WrongOnesAreRefused) {
  for (const auto& [section, fragment] : std::vector<std::pair<std::string, std::string>>{
           {"{columns: {sholder.counts: q1}}", "did you mean 'shoulder.counts'?"},
           {"{columns: {shoulder.counts: {colum: q1}}}", "colum"},
           {"{columns: {shoulder.counts: {column: q1, unit: furlong}}}", "unknown unit 'furlong'"},
           {"{colums: {}}", "colums"}})
    try {
      spec_of("log: " + section + '\n');
      FAIL() << section;
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find(fragment), std::string::npos) << e.what();
    }
  EXPECT_THROW(map_column("shoulder.counts", spec), Error);
  EXPECT_THROW(map_column("arm.counts=x", spec), Error);
  spec = spec_of("log: {columns: {shoulder.counts: q1_moter}}\n");
  EXPECT_NE(refusal(strange).find("the log has no such column, found 'q1_moter'; did you mean 'q1_motor'?"),
            std::string::npos);
  spec = spec_of(
      "log: {columns: {shoulder.reference: {column: q1_link, unit: mm}, shoulder.counts: q1_motor}}\n");
  EXPECT_NE(refusal(strange).find("the column has the wrong unit, found 'mm'"), std::string::npos);
}

/// A log of a stranger's program, and the columns that are proposed for it.
struct Stranger {
  std::string source, text;
  std::vector<std::string> lines;  // of the proposal
};

/// Rows of a log: `format` with the values of a motion at each instant.
template <class Row>
std::string log_of(const std::string& header, Row row) {
  std::string text = header + '\n';
  for (int i = 0; i < 200; ++i) text += row(i) + '\n';
  return text;
}

std::string text_of(double x, int decimals = 6) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*f", decimals, x);
  return text;
}

/// Angles of a joint, as read at the motor, which is quantized, and at the load.
double load(int i, int joint) { return 0.5 * std::sin(0.02 * i + joint); }
double motor(int i, int joint) {
  return std::round(load(i, joint) * 4096 / (2 * std::numbers::pi)) * (2 * std::numbers::pi) / 4096;
}

std::string several(int i, const std::string& separator, double (*angle)(int, int), double scale = 1) {
  std::string text;
  for (int j = 0; j < 4; ++j) text += (j ? separator : "") + text_of(scale * angle(i, j));
  return text;
}

std::string numbered(const std::string& before, const std::string& behind, const std::string& separator,
                     int first) {
  std::string text;
  for (int j = 0; j < 4; ++j) text += (j ? separator : "") + before + std::to_string(first + j) + behind;
  return text;
}

std::vector<Stranger> strangers() {
  const double deg = 180 / std::numbers::pi;
  std::vector<Stranger> all;
  all.push_back({"PlotJuggler",
                 log_of("__time,/joint_states/shoulder/position,/motor_states/shoulder/position",
                        [](int i) {
                          return text_of(1.7e9 + 0.01 * i) + ',' + text_of(load(i, 0)) + ',' +
                                 text_of(motor(i, 0));
                        }),
                 {"shoulder.measured: {column: /motor_states/shoulder/position, unit: rad}",
                  "shoulder.reference: {column: /joint_states/shoulder/position, unit: rad}"}});
  all.push_back(
      {"UR record.py",
       log_of("timestamp " + numbered("actual_q_", "", " ", 0) + ' ' + numbered("target_q_", "", " ", 0) +
                  " actual_TCP_pose_0 actual_TCP_pose_1 actual_TCP_pose_2",
              [](int i) {
                return text_of(100 + 0.008 * i) + ' ' + several(i, " ", motor) + ' ' + several(i, " ", load) +
                       " 0.5 0.25 " + text_of(load(i, 0));
              }),
       {"shoulder.measured: {column: actual_q_0, unit: rad}",
        "elbow.measured: {column: actual_q_1, unit: rad}",
        "shoulder.command: {column: target_q_0, unit: rad}"}});
  all.push_back({"libfranka",
                 log_of("duration, success rate, " + numbered("q[", "]", ", ", 0) + ',' +
                            numbered("q_d[", "]", ", ", 0) + ',' + numbered("tau_J[", "]", ", ", 0) +
                            ",sent commands," + numbered("q_d[", "]", ", ", 0),
                        [](int i) {
                          return std::to_string(i) + ",1," + several(i, ",", motor) + ',' +
                                 several(i, ",", load) + ',' + several(i, ",", load) + ',' +
                                 several(i, ",", load);
                        }),
                 {"shoulder.measured: {column: 'q[0]', unit: rad}",
                  "elbow.command: {column: 'q_d[1]', unit: rad}", "elbow.effort: 'tau_J[1]'"}});
  all.push_back(
      {"Dynamixel",
       log_of("time_s,ID1_Present_Position,ID2_Present_Position,ID3_Present_Position,ID4_Present_Position,"
              "ID1_Goal_Position",
              [](int i) {
                std::string text = text_of(0.01 * i);
                for (int j = 0; j < 4; ++j)
                  text += ',' + std::to_string(2048 + std::lround(600 * load(i, j)));
                return text + ",2048";
              }),
       {"shoulder.counts: ID1_Present_Position", "wrist.counts: ID4_Present_Position"}});
  all.push_back(
      {"moteus",
       log_of("timestamp,1.mode,1.position,1.velocity,1.torque,1.q_current,1.fault,laser_1_deg",
              [](int i) {
                return text_of(0.01 * i) + ",10," + text_of(motor(i, 0) / (2 * std::numbers::pi)) +
                       ",0.1,0.25,0.125,0," + text_of(load(i, 0) * 180 / std::numbers::pi);
              }),
       {"shoulder.measured: {column: 1.position, unit: rev}",
        "shoulder.velocity: {column: 1.velocity, unit: rev/s}", "shoulder.reference: laser_1_deg"}});
  all.push_back({"Excel in German",
                 log_of("Datum;Uhrzeit;Winkel Motor 1 [\xB0];Winkel Abtrieb 1 [\xB0]",
                        [&](int i) {
                          std::string row = "10:00:" + text_of(10 + 0.1 * i, 3) + ';' +
                                            text_of(deg * motor(i, 0), 4) + ';' +
                                            text_of(deg * load(i, 0), 4);
                          std::replace(row.begin(), row.end(), '.', ',');
                          return "26.11.2026;" + row;
                        }),
                 {"shoulder.measured: 'Winkel Motor 1 [\xC2\xB0]'",
                  "shoulder.reference: 'Winkel Abtrieb 1 [\xC2\xB0]'"}});
  all.push_back({"Excel in French",
                 log_of("Temps (ms)\tPosition codeur 2 (deg)\tPosition sortie 2 (deg)",
                        [&](int i) {
                          std::string row = std::to_string(10 * i) + '\t' + text_of(deg * motor(i, 0), 4) +
                                            '\t' + text_of(deg * load(i, 0), 4);
                          std::replace(row.begin(), row.end(), '.', ',');
                          return row;
                        }),
                 {"elbow.measured: Position codeur 2 (deg)", "elbow.reference: Position sortie 2 (deg)"}});
  all.push_back({"a microcontroller",
                 log_of("micros,enc1,ref1",
                        [](int i) {
                          return std::to_string(1000 * i) + ',' +
                                 std::to_string(std::lround(motor(i, 0) * 4096 / (2 * std::numbers::pi))) +
                                 ',' + text_of(load(i, 0));
                        }),
                 {"shoulder.counts: enc1", "shoulder.reference: {column: ref1, unit: rad}"}});
  all.push_back({"rostopic echo -p",
                 log_of("%time,field.name0,field.name1,field.position0,field.position1",
                        [](int i) {
                          return std::to_string(1700000000000000000 + 10000000 * i) + ",shoulder,elbow," +
                                 text_of(motor(i, 0)) + ',' + text_of(motor(i, 1));
                        }),
                 {"shoulder.measured: {column: field.position0, unit: rad}",
                  "elbow.measured: {column: field.position1, unit: rad}"}});
  const auto counted = [](int i, int joint) {
    return text_of(motor(i, joint) * 4096 / (2 * std::numbers::pi), 0);
  };
  all.push_back({"underscores, remarks, a header that comes again",
                 log_of("t_ms,shoulder_counts,shoulder_ref_deg",
                        [&](int i) {
                          return std::string(i == 70 ? "# marker\n" : "") +
                                 (i == 90 ? "t_ms,shoulder_counts,shoulder_ref_deg\n" : "") +
                                 std::to_string(10 * i) + ',' + counted(i, 0) + ',' +
                                 text_of(deg * load(i, 0));
                        }),
                 {"shoulder.counts: shoulder_counts", "shoulder.reference: shoulder_ref_deg"}});
  all.push_back(
      {"joints in German",
       log_of("Zeit;Schulter Inkremente;Schulter Winkel [mrad];Ellbogen Inkremente;Ellbogen Winkel [mrad];"
              "Hub Inkremente;Hub Lage [mm];Handgelenk Inkremente;Handgelenk Winkel [mrad]",
              [&](int i) {
                std::string row = text_of(0.01 * i);
                for (int j = 0; j < 4; ++j) row += ';' + counted(i, j) + ';' + text_of(1e3 * load(i, j), 3);
                return row;
              }),
       {"shoulder.counts: Schulter Inkremente", "elbow.counts: Ellbogen Inkremente"}});
  all.push_back({"TwinCAT's Scope",
                 log_of("Name\tScope Project\nFile\tC:\\scope.svdx\nStarttime of "
                        "export\t133482938400000000\t2024-01-05 10:04\n\n"
                        "Name\tShoulder.Counts\tName\tShoulder.Ref\nSymbolName\tMAIN.c\tSymbolName\tMAIN.r\n"
                        "Port\t851\tPort\t851\nSampleTime[ms]\t10\tSampleTime[ms]\t10\nUnit\t\tUnit\tdeg\n",
                        [&](int i) {
                          const std::string stamp = std::to_string(10 * i) + '\t';
                          return stamp + counted(i, 0) + '\t' + stamp + text_of(deg * load(i, 0));
                        }),
                 {"shoulder.counts: Shoulder.Counts", "shoulder.reference: 'Shoulder.Ref [deg]'"}});
  all.push_back(
      {"no header",
       log_of("0 0 0 0 0", [](int i) { return text_of(0.01 * (i + 1)) + ' ' + several(i, " ", motor); }),
       {"time: column 1", "shoulder.measured: {column: column 2, unit: rad}"}});
  return all;
}

TEST_F(LogMapping, ProposedForStrangersWorksWhenItIsPasted) {
  const std::vector<Stranger> all = strangers();
  ASSERT_GE(all.size(), 10u);
  for (const Stranger& s : all) {
    spec = spec_of("");
    const std::string section = proposed(s.text);
    for (const std::string& line : s.lines)
      EXPECT_NE(section.find("  " + line + '\n'), std::string::npos)
          << s.source << ": " << line << " in " << section;
    ASSERT_TRUE(section.starts_with("log:\n")) << s.source << ": " << section;
    spec = spec_of(section);
    const Log log = read(s.text);
    EXPECT_GE(log.rows, 200u) << s.source;
    ASSERT_TRUE(log.has_time()) << s.source;
    const Eigen::ArrayXd time = values(log, LogSignal::time);
    EXPECT_GT(time[1], time[0]) << s.source;
    EXPECT_LT(time[1] - time[0], 0.2) << s.source;
    const std::size_t joint = s.source == "Excel in French";
    const auto measured = measured_joint(log, log.values, spec.model.transmission, joint);
    ASSERT_TRUE(measured) << s.source;
    for (int i = 10; i < 20; ++i)
      if (s.source != "Dynamixel") {  // whose zero is elsewhere
        EXPECT_NEAR((*measured)[i] - (*measured)[0], motor(i - (s.source == "no header"), 0) - motor(0, 0),
                    3e-3)
            << s.source;
      }
  }
}

/// A log of the shoulder in two columns.
std::string two_columns(const std::string& first, const std::string& second, double scale) {
  return log_of("time [s]," + first + ',' + second, [&](int i) {
    return text_of(0.01 * i) + ',' + text_of(motor(i, 0)) + ',' + text_of(scale * load(i, 0), 9);
  });
}

TEST_F(LogMapping, UnitsOfHeadersAreKeptOrAsked) {
  const double deg = 180 / std::numbers::pi;
  struct Written {
    std::string unit;
    double scale;
  };
  for (const Written& w : {Written{"(mdeg)", 1e3 * deg},
                           {"(0.1 deg)", 10 * deg},
                           {"[gon]", 10 * deg / 9},
                           {"(mrev)", 500 / std::numbers::pi},
                           {"[360/4096 deg]", 4096 / 360. * deg}}) {
    const std::string text = two_columns("shoulder motor", "shoulder link " + w.unit, w.scale);
    spec = spec_of("");
    spec = spec_of(proposed(text));
    EXPECT_NEAR(values(read(text), LogSignal::reference)[7], load(7, 0), 1e-8) << w.unit;
  }
  for (const char* unit : {"(U)", "(V)", "[Ticks7]", "[%]", "[mm]", "[rad/s^2]", "[count]"}) {
    spec = spec_of("");
    const std::string text = two_columns("shoulder motor", "shoulder link " + std::string(unit), 100);
    const std::string section = proposed(text);
    EXPECT_NE(section.find("# not mapped: 'shoulder link " + std::string(unit)), std::string::npos)
        << section;
    EXPECT_EQ(section.find("\n    shoulder.reference:"), std::string::npos) << section;
    spec = spec_of(section);
    EXPECT_FALSE(read(text).find(LogSignal::reference, 0)) << unit;
  }
  spec = spec_of("");
  EXPECT_NE(proposed("t,shoulder (V)\n0,1\n0.1,2\n").find("the unit 'V' is not known"), std::string::npos);
  // A word of the name is no unit.
  EXPECT_NE(proposed(two_columns("shoulder (motor)", "shoulder (link)", 1)).find("shoulder.reference: "),
            std::string::npos);
}

TEST_F(LogMapping, TheSensorIsTheReferenceWhateverTheEncoderIsCalled) {
  for (const auto& [first, second] :
       {std::pair{"shoulder", "shoulder_laser"}, {"shoulder", "autocollimator"}}) {
    spec = spec_of("");
    const std::string section = proposed(two_columns(first, second, 1));
    EXPECT_NE(section.find("shoulder.measured: {column: " + std::string(first)), std::string::npos)
        << section;
    EXPECT_NE(section.find("shoulder.reference: {column: " + std::string(second)), std::string::npos)
        << section;
  }
  const std::string with_error =
      log_of("time [s],shoulder motor,shoulder link,shoulder link Abweichung", [](int i) {
        return text_of(0.01 * i) + ',' + text_of(motor(i, 0)) + ',' + text_of(load(i, 0)) + ',' +
               text_of(motor(i, 0) - load(i, 0), 9);
      });
  EXPECT_NE(proposed(with_error).find("shoulder.reference: {column: shoulder link, unit: rad}"),
            std::string::npos);
}

TEST_F(LogMapping, TwoNamelessChannelsOfOneJointAreTheEncoderAndTheReference) {
  std::ofstream(folder / "one.yaml")
      << "qerr: 1\nrobot: {joint: {name: a, type: revolute}}\nencoders: {a: {bits: 12}}\n";
  spec = read_spec((folder / "one.yaml").string());
  const auto row = [](int i) {
    return text_of(0.01 * i) + ',' + text_of(load(i, 0), 9) + ',' + text_of(motor(i, 0));
  };
  EXPECT_EQ(proposed(log_of("time,ch1,ch2", row)),
            "log:\n  columns:\n    a.measured: {column: ch2, unit: rad}\n    a.reference: {column: ch1, "
            "unit: rad}\n");
  EXPECT_EQ(
      proposed(log_of("time,ch1,ch2,ch3", [&](int i) { return row(i) + ',' + text_of(load(i, 0) + 1); }))
          .rfind("none", 0),
      0u)
      << "three alike";
  // Two encoders in counts: that of the spec is the coarser one.
  EXPECT_NE(proposed(log_of("time,encoder2,encoder1",
                            [](int i) {
                              return text_of(0.01 * i) + ',' + text_of(std::round(load(i, 0) * 166886), 0) +
                                     ',' + text_of(std::round(load(i, 0) * 651.9), 0);
                            }))
                .find("a.counts: encoder1"),
            std::string::npos);
}

TEST_F(LogMapping, CountsBehindWholeSecondsAreNoNanoseconds) {
  std::ofstream(folder / "one.yaml")
      << "qerr: 1\nrobot: {joint: {name: a, type: revolute}}\nencoders: {a: {bits: 20}}\n";
  spec = read_spec((folder / "one.yaml").string());
  for (const int rows_a_second : {1, 10}) {  // of a counter beyond 1e5, forth and back
    std::string text;
    for (int i = 0; i < 200; ++i)
      text += std::to_string(1764177402 + i / rows_a_second) + ',' +
              text_of(std::round(6e5 + 4e5 * load(i, 0)), 0) + ',' + text_of(load(i, 0)) + '\n';
    const std::string section = proposed(text);
    EXPECT_NE(section.find("a.counts: column 2"), std::string::npos) << section;
    spec = read_spec((folder / "one.yaml").string());
    map_column("time=column 1", spec);
    map_column("a.counts=column 2", spec);
    EXPECT_EQ(values(read(text), LogSignal::counts)[7], std::round(6e5 + 4e5 * load(7, 0))) << rows_a_second;
    spec = read_spec((folder / "one.yaml").string());
  }
}

TEST_F(LogMapping, CurrentsAndCountsOfHeadersAreProposed) {
  spec = spec_of("");
  const std::string section = proposed(log_of(
      "time [s],Shoulder encoder (counts),Shoulder position ext (rad),Shoulder current (A)", [](int i) {
        return text_of(0.01 * i) + ',' + text_of(std::round(motor(i, 0) * 4096 / (2 * std::numbers::pi)), 0) +
               ',' + text_of(load(i, 0)) + ",0.25";
      }));
  EXPECT_EQ(
      section,
      "log:\n  columns:\n    shoulder.counts: Shoulder encoder (counts)\n"
      "    shoulder.reference: Shoulder position ext (rad)\n    shoulder.effort: Shoulder current (A)\n");
}

TEST_F(LogMapping, ProposedForATopicThatRos2Prints) {
  std::string text;
  for (int i = 0; i < 200; ++i) {
    text += std::to_string(1700000000 + i / 100) + ',' + std::to_string(10000000 * (i % 100)) +
            ",base,elbow,shoulder," + text_of(motor(i, 1)) + ',' + text_of(motor(i, 0)) + ',' +
            text_of(0.1 * i) + ',' + text_of(0.2 * i) + ",3,4\n";
  }
  const std::string section = proposed(text);
  spec = spec_of(section);
  const Log log = read(text);
  EXPECT_NEAR(values(log, LogSignal::time)[150] - values(log, LogSignal::time)[0], 1.5, 1e-9) << section;
  EXPECT_NEAR(values(log, LogSignal::measured, 0)[50], motor(50, 0), 1e-6) << section;
  EXPECT_NEAR(values(log, LogSignal::measured, 1)[50], motor(50, 1), 1e-6) << section;
  EXPECT_NEAR(values(log, LogSignal::velocity, 0)[50], 10, 1e-6) << section;
  EXPECT_EQ(values(log, LogSignal::effort, 1)[50], 3) << section;
  EXPECT_FALSE(log.find(LogSignal::reference, 0)) << section;
}

TEST_F(LogMapping, ProposedAsOptionsIsTheSameMapping) {
  const Stranger s = strangers().front();
  const std::string section = proposed(s.text), message = refusal(s.text);
  EXPECT_NE(message.find("--column 'shoulder.measured=/motor_states/shoulder/position [rad]' \\\n"),
            std::string::npos)
      << message;
  map_column("shoulder.measured=/motor_states/shoulder/position [rad]", spec);
  map_column("shoulder.reference=/joint_states/shoulder/position [rad]", spec);
  const Log by_options = read(s.text);
  spec = spec_of(section);
  EXPECT_TRUE((read(s.text).values == by_options.values).all());
}

TEST_F(LogMapping, ACompleteLogIsNotAsked) {
  const Log log = read("time [s],shoulder.counts,shoulder.reference [rad],q2_motor\n0,1,0.5,3\n1,2,0.5,3\n");
  ASSERT_EQ(log.warnings.size(), 1u);
  EXPECT_NE(log.warnings[0].find("ignored: 'q2_motor'"), std::string::npos) << log.warnings[0];
}

}  // namespace
}  // namespace qerr::log_mapping_test
