#include <lz4frame.h>
#include <sqlite3.h>
#include <zstd.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <random>

#include "support/log_file.hpp"

/// Bags of ROS 2 as logs: written here from the formats' definitions (OMG CDR; mcap.dev/spec; the tables of
/// rosbag2).
namespace qerr::bag_log_test {
namespace {

/// Little-endian bytes, aligned as CDR asks, or not at all.
class Bytes {
 public:
  explicit Bytes(bool cdr = false) : text_(cdr ? std::string("\0\1\0\0", 4) : ""), cdr_(cdr) {}

  template <class Number>
  Bytes& put(Number value) {
    while (cdr_ && (text_.size() - 4) % sizeof value != 0) text_ += '\0';
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    text_.append(raw, sizeof value);
    return *this;
  }
  Bytes& put(const std::string& text) {
    put(static_cast<std::uint32_t>(text.size() + cdr_));
    text_ += text;
    if (cdr_) text_ += '\0';
    return *this;
  }
  Bytes& put(const std::vector<double>& values) {
    put(static_cast<std::uint32_t>(values.size()));
    for (const double v : values) put(v);
    return *this;
  }
  Bytes& raw(const std::string& text) {
    text_ += text;
    return *this;
  }
  Bytes& header(std::int64_t ns, const std::string& frame) {
    if (!cdr_) put(std::uint32_t{7});  // the sequence number of ROS 1
    return put(static_cast<std::int32_t>(ns / 1'000'000'000))
        .put(static_cast<std::uint32_t>(ns % 1'000'000'000))
        .put(frame);
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
  bool cdr_;
};

struct Message {
  std::string topic, type, data;
  std::int64_t received = 0;
};

std::string joint_state(std::int64_t ns, const std::vector<std::string>& names,
                        const std::vector<double>& positions, bool cdr = true) {
  Bytes b(cdr);
  b.header(ns, "odd").put(static_cast<std::uint32_t>(names.size()));
  for (const std::string& name : names) b.put(name);
  return b.put(positions).put(std::vector<double>{}).put(positions).text();
}

std::string pose(std::int64_t ns, double x, double y, double z) {
  Bytes b(true);
  b.header(ns, "map").put(x).put(y).put(z);
  for (const double w : {0.0, 0.0, 0.0, 1.0}) b.put(w);
  return b.text();
}

constexpr std::int64_t start = 1'700'000'000'123'456'789;
constexpr int samples = 300;

double position(double t, int joint) { return 0.4 * std::sin(3 * t + joint); }

/// Joint states at 100 Hz; a reference of the shoulder at its own stamps, 3 ms later, at 50 Hz, that is
/// quadratic in between; a tracker, a temperature and a topic of another type.
std::vector<Message> recording() {
  std::vector<Message> all;
  for (int i = 0; i < samples; ++i) {
    const double t = 0.01 * i;
    const std::int64_t ns = start + std::int64_t{10'000'000} * i;
    all.push_back({"/joint_states", "sensor_msgs/msg/JointState",
                   joint_state(ns, {"elbow", "shoulder", "wrist", "lift"},
                               {position(t, 1), position(t, 0), position(t, 2), 0.1}),
                   ns + 1000});
    if (i % 2) continue;
    all.push_back({"/laser", "sensor_msgs/msg/JointState",
                   joint_state(ns + 3'000'000, {"shoulder"}, {position(t + 0.003, 0) + 0.001}),
                   ns + 4'000'000});
    all.push_back({"/tracker/pose", "geometry_msgs/msg/PoseStamped", pose(ns, 1, 2, t), ns});
    Bytes transform(true);
    transform.put(std::uint32_t{1}).header(ns, "map").put(std::string("tool"));
    for (const double x : {4.0, 5.0, 6.0, 0.0, 0.0, 0.0, 1.0}) transform.put(x);
    all.push_back({"/tf", "tf2_msgs/msg/TFMessage", transform.text(), ns});
    all.push_back({"/motor_temperature", "std_msgs/msg/Float64", Bytes(true).put(20.5).text(), ns});
    all.push_back({"/camera", "sensor_msgs/msg/Image", "\xFF\xFE", ns});
  }
  return all;
}

std::string record(std::uint8_t opcode, const std::string& content) {
  return Bytes().put(opcode).put(static_cast<std::uint64_t>(content.size())).raw(content).text();
}

std::string compressed(const std::string& text, const std::string& by) {
  std::string out(std::max(ZSTD_compressBound(text.size()), LZ4F_compressFrameBound(text.size(), nullptr)),
                  '\0');
  if (by.empty()) return text;
  out.resize(by == "zstd" ? ZSTD_compress(out.data(), out.size(), text.data(), text.size(), 3)
                          : LZ4F_compressFrame(out.data(), out.size(), text.data(), text.size(), nullptr));
  return out;
}

/// A file of MCAP: `per_chunk` messages a chunk, 0: without chunks.
std::string mcap(const std::vector<Message>& all, const std::string& compression, std::size_t per_chunk,
                 const std::string& encoding = "cdr") {
  const std::string magic = "\x89MCAP0\r\n";
  std::string out = magic + record(1, Bytes().put(std::string("ros2")).put(std::string("test")).text()),
              chunk;
  std::vector<std::string> topics;
  const auto close = [&] {
    if (chunk.empty()) return;
    const std::string packed = compressed(chunk, compression);
    out += record(6, Bytes()
                         .put(std::uint64_t{0})
                         .put(std::uint64_t{9})
                         .put(static_cast<std::uint64_t>(chunk.size()))
                         .put(std::uint32_t{0})
                         .put(compression)
                         .put(static_cast<std::uint64_t>(packed.size()))
                         .raw(packed)
                         .text());
    chunk.clear();
  };
  std::size_t in_chunk = 0;
  for (const Message& m : all) {
    std::string& to = per_chunk ? chunk : out;
    auto at = std::find(topics.begin(), topics.end(), m.topic);
    if (at == topics.end()) {
      const auto id = static_cast<std::uint16_t>(topics.size() + 1);
      to += record(
          3, Bytes().put(id).put(m.type).put(std::string("ros2msg")).put(std::string("float64 x")).text());
      to += record(4, Bytes()
                          .put(static_cast<std::uint16_t>(id - 1))
                          .put(id)
                          .put(m.topic)
                          .put(encoding)
                          .put(std::uint32_t{0})
                          .text());
      at = topics.insert(topics.end(), m.topic);
    }
    to += record(5, Bytes()
                        .put(static_cast<std::uint16_t>(at - topics.begin()))
                        .put(std::uint32_t{0})
                        .put(static_cast<std::uint64_t>(m.received))
                        .put(static_cast<std::uint64_t>(m.received))
                        .raw(m.data)
                        .text());
    if (per_chunk && ++in_chunk % per_chunk == 0) close();
  }
  close();
  return out + record(15, std::string(4, '\0')) + record(2, std::string(20, '\0')) + magic;
}

class BagLog : public qerr::testing::LogFile {
 protected:
  void SetUp() override {
    qerr::testing::LogFile::SetUp();
    map("shoulder.measured: /joint_states/shoulder/position, shoulder.reference: /laser/shoulder/position, "
        "shoulder.temperature: {column: /motor_temperature/data, unit: degC}");
  }
  void map(const std::string& columns) {
    spec = spec_with("'*': {counts_per_rev: 4096}, lift: {resolution: 10 um}",
                     "log: {columns: {" + columns + "}}\n");
  }
  std::string database(const std::vector<Message>& all, bool packed) {
    const std::string path = (folder / "log.db3").string();
    std::filesystem::remove(path);
    sqlite3* db = nullptr;
    sqlite3_open(path.c_str(), &db);
    std::string error;
    const auto run = [&](const char* sql) {
      EXPECT_EQ(sqlite3_exec(db, sql, nullptr, nullptr, nullptr), 0) << sqlite3_errmsg(db);
    };
    run("CREATE TABLE topics(id INTEGER PRIMARY KEY,name TEXT NOT NULL,type TEXT NOT "
        "NULL,serialization_format TEXT NOT "
        "NULL,offered_qos_profiles TEXT NOT NULL)");
    run("CREATE TABLE messages(id INTEGER PRIMARY KEY,topic_id INTEGER NOT NULL,timestamp INTEGER NOT NULL, "
        "data BLOB NOT NULL)");
    run("BEGIN");
    std::vector<std::string> topics;
    for (const Message& m : all) {
      auto at = std::find(topics.begin(), topics.end(), m.topic);
      if (at == topics.end()) {
        at = topics.insert(topics.end(), m.topic);
        run(("INSERT INTO topics VALUES(" + std::to_string(topics.size()) + ",'" + m.topic + "','" + m.type +
             "','cdr','')")
                .c_str());
      }
      sqlite3_stmt* insert = nullptr;
      sqlite3_prepare_v2(db, "INSERT INTO messages(topic_id,timestamp,data) VALUES(?,?,?)", -1, &insert,
                         nullptr);
      const std::string data = packed ? compressed(m.data, "zstd") : m.data;
      sqlite3_bind_int64(insert, 1, at - topics.begin() + 1);
      sqlite3_bind_int64(insert, 2, m.received);
      sqlite3_bind_blob(insert, 3, data.data(), static_cast<int>(data.size()), SQLITE_TRANSIENT);
      EXPECT_EQ(sqlite3_step(insert), SQLITE_DONE);
      sqlite3_finalize(insert);
    }
    run("COMMIT");
    sqlite3_close(db);
    return path;
  }
  /// Rows at the stamps of the joint states that two samples of the laser enclose.
  void expect_recording(const Log& log, const std::string& what) {
    ASSERT_GT(log.rows, 290u) << what;
    EXPECT_NEAR(log.time_origin, 1e-9 * static_cast<double>(start), 1e-3) << what;
    const Eigen::ArrayXd time = values(log, LogSignal::time), measured = values(log, LogSignal::measured),
                         reference = values(log, LogSignal::reference),
                         degrees = values(log, LogSignal::temperature);
    const auto first = static_cast<double>(log.row_number(0));
    EXPECT_NEAR(first, 1, 0) << what << ": the first stamp lies before the laser's";
    for (Eigen::Index i = 0; i < time.size(); ++i) {
      const double t = 0.01 * (static_cast<double>(i) + first);
      ASSERT_NEAR(time[i] - time[0], t - 0.01 * first, 1e-9) << what;
      ASSERT_EQ(measured[i], position(0.01 * (static_cast<int>(i) + 1), 0)) << what;
      // A cubic through samples 20 ms apart, of 0.4 sin 3 t: 3/128 * 0.4 * 3^4 * 0.02^4, four times so at the
      // ends.
      ASSERT_NEAR(reference[i], position(t, 0) + 0.001, 1e-6) << what << ' ' << i;
      ASSERT_EQ(degrees[i], 20.5) << what;
    }
  }
};

TEST_F(BagLog, McapOfAnyChunksIsRead) {
  const std::vector<Message> all = recording();
  for (const std::string compression : {"", "lz4", "zstd"})
    for (const std::size_t per_chunk : {0, 1, 7, 100000}) {
      if (per_chunk == 0 && !compression.empty()) continue;
      expect_recording(read(mcap(all, compression, per_chunk)), compression + std::to_string(per_chunk));
    }
}

TEST_F(BagLog, DatabasesOfRosbag2AreRead) {
  for (const bool packed : {false, true})
    expect_recording(read_log(database(recording(), packed), spec), "db3");
}

TEST_F(BagLog, TheFilesOfASplitRecordingAreOne) {
  const std::vector<Message> all = recording();
  const std::filesystem::path bag = folder / "record";
  std::filesystem::create_directories(bag);
  std::ofstream(bag / "metadata.yaml") << "rosbag2_bagfile_information: {version: 5}\n";
  constexpr std::size_t parts = 12;  // record_10 lies behind record_9
  for (std::size_t i = 0; i < parts; ++i)
    std::ofstream(bag / ("record_" + std::to_string(i) + ".mcap"), std::ios::binary)
        << mcap({all.begin() + static_cast<std::ptrdiff_t>(all.size() * i / parts),
                 all.begin() + static_cast<std::ptrdiff_t>(all.size() * (i + 1) / parts)},
                "zstd", 7);
  expect_recording(read_log(bag.string(), spec), "folder");
  expect_recording(read_log((bag / "metadata.yaml").string(), spec), "metadata");
  try {
    read_log(LogFiles({(bag / "record_0.mcap").string(), (bag / "record_1.mcap").string()}), spec);
    ADD_FAILURE() << "two files with the same signals";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("name the folder"), std::string::npos) << e.what();
  }
}

TEST_F(BagLog, AMotionIsReadFromABag) {
  std::vector<Message> all;
  for (int i = 0; i < 10; ++i)
    all.push_back({"/joint_states", "sensor_msgs/msg/JointState",
                   joint_state(start + 10'000'000LL * i, {"lift", "shoulder", "elbow", "wrist"},
                               {0.01 * i, 0.1, 0.2, 0.3 * i}, true),
                   start});
  write(mcap(all, "lz4", 3));
  const Spec moved =
      spec_with("'*': {counts_per_rev: 4096}, lift: {resolution: 10 um}", "motion: {file: log.csv}\n");
  EXPECT_NEAR(moved.motion->sample_rate, 100, 1e-6);
  ASSERT_EQ(moved.motion->table.positions.cols(), 10);
  EXPECT_EQ(moved.motion->table.positions(find_joint(moved.model.chain, "wrist").value(), 9), 0.3 * 9);
}

TEST_F(BagLog, TipsAreReadFromPosesAndTransforms) {
  const std::string joints =
      "shoulder.measured: /joint_states/shoulder/position, elbow.measured: /joint_states/elbow/position, "
      "wrist.measured: /joint_states/wrist/position, lift.measured: /joint_states/lift/position, ";
  map(joints + "tip.x: /tracker/pose/pose/position/x, tip.y: /tracker/pose/pose/position/y");
  EXPECT_EQ(values(read(mcap(recording(), "zstd", 5)), LogSignal::tip, 1)[3], 2);
  map(joints + "tip.x: /tf/tool/translation/x, tip.z: /tf/tool/translation/z");
  EXPECT_EQ(values(read(mcap(recording(), "lz4", 5)), LogSignal::tip, 2)[3], 6);
}

TEST_F(BagLog, MessagesOfRos1AreRead) {
  map("shoulder.measured: /joint_states/shoulder/position");
  std::vector<Message> all;
  for (int i = 0; i < 10; ++i)
    all.push_back({"/joint_states", "sensor_msgs/JointState",
                   joint_state(start + i, {"a", "shoulder"}, {9, 0.1 * i}, false), start});
  const Log log = read(mcap(all, "lz4", 3, "ros1"));
  ASSERT_EQ(log.rows, 10u);
  EXPECT_EQ(values(log, LogSignal::measured)[7], 0.1 * 7);
}

TEST_F(BagLog, WithoutAMappingOneIsProposed) {
  spec = spec_with("'*': {counts_per_rev: 4096}, lift: {resolution: 10 um}");
  const std::string message = refusal(mcap(recording(), "zstd", 50));
  const std::size_t at = message.find("\nlog:\n");
  ASSERT_NE(at, std::string::npos) << message;
  spec = spec_with("'*': {counts_per_rev: 4096}, lift: {resolution: 10 um}", message.substr(at + 1) + '\n');
  const Log log = read(mcap(recording(), "zstd", 50));
  EXPECT_TRUE(log.find(LogSignal::measured, 3)) << message;
  EXPECT_TRUE(log.find(LogSignal::reference, 0)) << message;
}

TEST_F(BagLog, AnyChangedByteIsAcceptedOrRefused) {
  std::mt19937_64 dice(7);
  const std::vector<Message> all = recording();
  const std::vector<Message> few(all.begin(), all.begin() + 40);
  int accepted = 0;
  for (const std::string compression : {"", "lz4", "zstd"}) {
    const std::string whole = mcap(few, compression, 10);
    for (int i = 0; i < 150; ++i) {
      std::string changed = whole;
      for (std::size_t k = 1 + dice() % 4; k > 0; --k)
        changed[dice() % changed.size()] = static_cast<char>(dice());
      if (dice() % 4 == 0) changed.resize(dice() % changed.size());
      accepted += refusal(changed) == "accepted";
    }
  }
  EXPECT_GT(accepted, 20);
  EXPECT_LT(accepted, 430);
}

TEST_F(BagLog, DamagedOnesAreRefusedOrReadToTheirEnd) {
  const std::string whole = mcap(recording(), "", 20);
  const Log cut = read(whole.substr(0, whole.size() / 2));
  EXPECT_LT(cut.rows, 200u);
  EXPECT_TRUE(std::any_of(cut.warnings.begin(), cut.warnings.end(),
                          [](const std::string& w) { return w.find("cut off") != std::string::npos; }));
  std::vector<Message> all = recording();
  all[100].data.resize(30);
  EXPECT_NE(refusal(mcap(all, "", 20)).find("is damaged"), std::string::npos);
  std::string broken = mcap(recording(), "zstd", 20);
  broken[2000] = static_cast<char>(broken[2000] ^ 0x55);
  refusal(broken);  // is accepted or refused, and ends
  EXPECT_NE(refusal(mcap(recording(), "zip", 20)).find("unknown compression 'zip'"), std::string::npos);
  EXPECT_NE(refusal(mcap({recording()[5]}, "", 20)).find("/camera (sensor_msgs/msg/Image)"),
            std::string::npos);
}

}  // namespace
}  // namespace qerr::bag_log_test
