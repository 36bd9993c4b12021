#include "input/bag_file.hpp"

#include <lz4frame.h>
#include <sqlite3.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <map>

#include "core/text.hpp"
#include "input/csv.hpp"
#include "qerr/core/error.hpp"

namespace qerr {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view mcap_magic = "\x89MCAP0\r\n", sqlite_magic = "SQLite format 3",
                           zstd_magic = "\x28\xB5\x2F\xFD";
constexpr std::uint64_t largest_chunk = std::uint64_t{1} << 30;  // [bytes] of a recorder: some megabytes

[[noreturn]] void refuse_bag(const std::string& file, const std::string& rule,
                             const std::string& remedy = {}) {
  throw Error({file, 0, 0}, "", rule, "", remedy);
}

/// Decompressed bytes of a Zstandard frame, `limit` at most.
std::string unpacked_zstd(std::string_view bytes, std::uint64_t limit, const std::string& file) {
  std::string out;
  const std::unique_ptr<ZSTD_DStream, decltype(&ZSTD_freeDStream)> stream(ZSTD_createDStream(),
                                                                          ZSTD_freeDStream);
  ZSTD_inBuffer in{bytes.data(), bytes.size(), 0};
  const std::size_t block = ZSTD_DStreamOutSize();
  for (std::size_t left = 1; left != 0;) {
    const std::size_t before = out.size();
    out.resize(before + block);
    ZSTD_outBuffer part{out.data() + before, block, 0};
    left = ZSTD_decompressStream(stream.get(), &part, &in);
    out.resize(before + part.pos);
    const bool stalled = left != 0 && part.pos < block && in.pos == in.size;
    if (ZSTD_isError(left) || stalled || out.size() > limit)
      refuse_bag(file, "a chunk of Zstandard is damaged");
  }
  return out;
}

std::string unpacked_lz4(std::string_view bytes, std::uint64_t limit, const std::string& file) {
  std::string out;
  LZ4F_dctx* made = nullptr;
  LZ4F_createDecompressionContext(&made, LZ4F_VERSION);
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(
      made, LZ4F_freeDecompressionContext);
  for (std::size_t left = 1; left != 0;) {
    constexpr std::size_t block = 1 << 18;
    const std::size_t before = out.size();
    out.resize(before + block);
    std::size_t written = block, taken = bytes.size();
    left = LZ4F_decompress(context.get(), out.data() + before, &written, bytes.data(), &taken, nullptr);
    out.resize(before + written);
    bytes.remove_prefix(taken);
    const bool stalled = left != 0 && written == 0 && taken == 0;
    if (LZ4F_isError(left) || stalled || out.size() > limit) refuse_bag(file, "a chunk of LZ4 is damaged");
  }
  return out;
}

/// Little-endian fields of a record of MCAP.
class RecordReader {
 public:
  RecordReader(std::string_view bytes, const std::string& file) : bytes_(bytes), file_(file) {}

  std::string_view take(std::uint64_t count) {
    if (count > bytes_.size()) refuse_bag(file_, "a record is damaged: it ends within a field");
    const std::string_view part = bytes_.substr(0, count);
    bytes_.remove_prefix(count);
    return part;
  }
  std::uint64_t whole(std::size_t size) {
    std::uint64_t value = 0;
    const std::string_view bytes = take(size);
    for (std::size_t i = size; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[i]);
    return value;
  }
  std::string text() { return std::string(take(whole(4))); }
  std::string_view rest() { return take(bytes_.size()); }
  bool empty() const { return bytes_.empty(); }

 private:
  std::string_view bytes_;
  const std::string& file_;
};

/// https://mcap.dev/spec: records of an opcode, a length and a content; chunks contain records.
class McapFile : public BagFile {
 public:
  McapFile(const std::string& path, const std::string& topic) : source_(path), topic_(topic) {
    read_bytes(mcap_magic.size());
  }

  bool next(BagMessage& message) override {
    while (true) {
      while (chunk_at_ < chunk_.size()) {
        RecordReader in(std::string_view(chunk_).substr(chunk_at_), name());
        const std::uint64_t opcode = in.whole(1), length = in.whole(8);
        const std::string_view content = in.take(length);
        chunk_at_ += 9 + length;
        if (take_record(opcode, content, message)) return true;
      }
      if (!read_bytes(9)) return false;
      RecordReader in(buffer_, name());
      const std::uint64_t opcode = in.whole(1), length = in.whole(8);
      if (opcode == data_end || opcode == footer) return false;
      if (source_.size() > 0 && length > source_.size() - source_.position()) return cut_off();
      if (length > largest_chunk) refuse_bag(name(), "a record is longer than 1 GiB");
      if (!read_bytes(length)) return cut_off();
      if (opcode == chunk)
        unpack_chunk();
      else if (take_record(opcode, buffer_, message))
        return true;
    }
  }

  std::uint64_t position() const override { return source_.position(); }
  bool is_cut_off() const override { return cut_off_; }

 private:
  enum Opcode : std::uint8_t {
    footer = 2,
    schema = 3,
    channel = 4,
    message_data = 5,
    chunk = 6,
    data_end = 15
  };
  struct Channel {
    std::uint64_t schema = 0;
    std::string topic, encoding;
  };

  const std::string& name() const { return source_.name(); }
  bool cut_off() { return !(cut_off_ = true); }

  /// Reads exactly so many bytes. @returns false at the end
  bool read_bytes(std::uint64_t count) {
    buffer_.clear();
    while (buffer_.size() < count) {
      const std::size_t before = buffer_.size();
      buffer_.resize(std::min<std::uint64_t>(count, before + (1 << 20)));
      const std::size_t read = source_.read(buffer_.data() + before, buffer_.size() - before);
      buffer_.resize(before + read);
      if (read == 0) return false;
    }
    return true;
  }

  void unpack_chunk() {
    RecordReader in(buffer_, name());
    in.take(16);
    const std::uint64_t size = in.whole(8);
    in.take(4);
    const std::string compression = in.text();
    const std::string_view records = in.take(in.whole(8));
    if (size > largest_chunk) refuse_bag(name(), "a chunk is longer than 1 GiB");
    if (compression.empty())
      chunk_ = records;
    else if (compression == "zstd")
      chunk_ = unpacked_zstd(records, size, name());
    else if (compression == "lz4")
      chunk_ = unpacked_lz4(records, size, name());
    else
      refuse_bag(name(), "unknown compression " + quoted(compression), "`mcap compress` writes it with zstd");
    chunk_at_ = 0;
  }

  /// @returns whether it is a message of the topic
  bool take_record(std::uint64_t opcode, std::string_view content, BagMessage& message) {
    RecordReader in(content, name());
    if (opcode == schema) {
      const std::uint64_t id = in.whole(2);
      schemas_[id] = in.text();
    } else if (opcode == channel) {
      const std::uint64_t id = in.whole(2);
      Channel& c = channels_[id];
      c.schema = in.whole(2);
      c.topic = in.text();
      c.encoding = in.text();
    } else if (opcode == message_data) {
      const auto found = channels_.find(in.whole(2));
      if (found == channels_.end()) refuse_bag(name(), "a message has no channel: the file is damaged");
      const Channel& c = found->second;
      if (!topic_.empty() && c.topic != topic_) return false;
      in.take(4);
      const auto received = static_cast<std::int64_t>(in.whole(8));
      in.take(8);
      const bool known = c.encoding == "cdr" || c.encoding == "ros1";
      message = {c.topic, known ? std::string_view(schemas_[c.schema]) : c.encoding, in.rest(), received,
                 c.encoding == "ros1"};
      return true;
    }
    return false;
  }

  ByteSource source_;
  std::string topic_;
  std::string buffer_, chunk_;
  std::size_t chunk_at_ = 0;
  bool cut_off_ = false;
  std::map<std::uint64_t, std::string> schemas_;
  std::map<std::uint64_t, Channel> channels_;
};

/// The tables `topics` and `messages` of rosbag2.
class SqliteBag : public BagFile {
 public:
  SqliteBag(const std::string& path, const std::string& topic)
      : file_(path), database_(nullptr, sqlite3_close) {
    sqlite3* opened = nullptr;
    const int failed = sqlite3_open_v2(path.c_str(), &opened, SQLITE_OPEN_READONLY, nullptr);
    database_.reset(opened);
    if (failed) refuse();
    const std::string query =
        "SELECT t.name, t.type, t.serialization_format, m.timestamp, m.data FROM messages m JOIN topics t "
        "ON t.id = m.topic_id" +
        std::string(topic.empty() ? "" : " WHERE t.name = ?1") + " ORDER BY m.timestamp, m.id";
    sqlite3_stmt* made = nullptr;
    if (sqlite3_prepare_v2(opened, query.c_str(), -1, &made, nullptr)) refuse();
    rows_.reset(made);
    if (!topic.empty()) sqlite3_bind_text(made, 1, topic.c_str(), -1, SQLITE_TRANSIENT);
  }

  bool next(BagMessage& message) override {
    const int state = sqlite3_step(rows_.get());
    if (state == SQLITE_DONE) return false;
    if (state != SQLITE_ROW) refuse();
    const auto text = [&](int column) {
      const void* begin = sqlite3_column_blob(rows_.get(), column);
      const auto size = static_cast<std::size_t>(sqlite3_column_bytes(rows_.get(), column));
      return begin ? std::string_view(static_cast<const char*>(begin), size) : std::string_view();
    };
    message = {text(0), text(1), text(4), sqlite3_column_int64(rows_.get(), 3), false};
    if (text(2) != "cdr") message.type = text(2);
    position_ += message.data.size();
    if (message.data.starts_with(zstd_magic)) {  // messages may be compressed one by one
      unpacked_ = unpacked_zstd(message.data, largest_chunk, file_);
      message.data = unpacked_;
    }
    return true;
  }

  std::uint64_t position() const override { return position_; }

 private:
  [[noreturn]] void refuse() const {
    refuse_bag(file_,
               std::string("is no bag of rosbag2 that can be read: ") + sqlite3_errmsg(database_.get()),
               "it needs the tables topics and messages");
  }

  std::string file_, unpacked_;
  std::unique_ptr<sqlite3, decltype(&sqlite3_close)> database_;
  std::unique_ptr<sqlite3_stmt, decltype(&sqlite3_finalize)> rows_{nullptr, sqlite3_finalize};
  std::uint64_t position_ = 0;
};

std::string head_of(const std::string& path) {
  std::string head(16, '\0');
  ByteSource source(path);
  head.resize(source.read(head.data(), head.size()));
  return head;
}

std::unique_ptr<BagFile> open_part(const std::string& path, const std::string& topic) {
  const std::string head = head_of(path);
  if (head.starts_with(sqlite_magic)) return std::make_unique<SqliteBag>(path, topic);
  return std::make_unique<McapFile>(path, topic);
}

/// The folder of a recording; "" for a path of a single file.
std::string folder_of_bag(const std::string& path) {
  const fs::path given(path);
  std::error_code unknown;
  if (fs::is_directory(given, unknown)) return path;
  if (given.filename() != "metadata.yaml") return "";
  return given.has_parent_path() ? given.parent_path().string() : ".";
}

/// The files of a bag. rosbag2 numbers them: NAME_0.mcap, NAME_1.mcap, ..., NAME_10.mcap.
std::vector<std::string> parts_of_bag(const std::string& path) {
  const std::string folder = folder_of_bag(path);
  if (folder.empty()) return {path};
  std::vector<std::string> parts;
  bool compressed = false;
  std::error_code failure;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, failure)) {
    const std::string ending = entry.path().extension().string();
    if (ending == ".mcap" || ending == ".db3") parts.push_back(entry.path().string());
    compressed = compressed || ending == ".zstd";
  }
  if (parts.empty())
    throw Error({path, 0, 0}, "", "a folder that has no file of a bag: .mcap or .db3", "",
                compressed ? "unpack those that are compressed as a whole: zstd -d FILE.zstd" : "name a file",
                Trouble::file_system);
  std::ranges::sort(parts, [](const std::string& a, const std::string& b) {
    return std::pair(a.size(), a) < std::pair(b.size(), b);
  });
  return parts;
}

/// Files of one recording, one after the other.
class SplitBag : public BagFile {
 public:
  SplitBag(std::vector<std::string> parts, std::string topic)
      : parts_(std::move(parts)), topic_(std::move(topic)) {}

  bool next(BagMessage& message) override {
    while (!part_ || !part_->next(message)) {
      if (part_) before_ += part_->position(), cut_off_ = cut_off_ || part_->is_cut_off();
      if (opened_ == parts_.size()) return part_.reset(), false;
      part_ = open_part(parts_[opened_++], topic_);
    }
    return true;
  }

  std::uint64_t position() const override { return before_ + (part_ ? part_->position() : 0); }
  bool is_cut_off() const override { return cut_off_; }

 private:
  std::vector<std::string> parts_;
  std::string topic_;
  std::unique_ptr<BagFile> part_;
  std::size_t opened_ = 0;
  std::uint64_t before_ = 0;  // bytes of the parts that have been read
  bool cut_off_ = false;
};

}  // namespace

bool is_bag(const std::string& path) {
  if (!folder_of_bag(path).empty()) return true;
  std::error_code unknown;
  if (path == "-" || !fs::is_regular_file(path, unknown)) return false;
  const std::string head = head_of(path);
  return head.starts_with(mcap_magic) || head.starts_with(sqlite_magic);
}

std::uint64_t size_of_bag(const std::string& path) {
  std::uint64_t sum = 0;
  for (const std::string& part : parts_of_bag(path)) sum += ByteSource(part).size();
  return sum;
}

std::unique_ptr<BagFile> open_bag(const std::string& path, const std::string& topic) {
  std::vector<std::string> parts = parts_of_bag(path);
  if (parts.size() == 1) return open_part(parts.front(), topic);
  return std::make_unique<SplitBag>(std::move(parts), topic);
}

}  // namespace qerr
