#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "qerr/core/error.hpp"

/// What the fuzz targets share: libFuzzer calls LLVMFuzzerTestOneInput with bytes that it has varied.
namespace qerr::fuzz {

/// Runs `work`. Any input may be refused by an Error with a place and a rule; everything else that ends it is
/// a defect: another exception, a signal, an internal error, a message that is empty.
template <class Work>
void accept_or_refuse(const Work& work) {
  try {
    work();
  } catch (const Error& e) {
    if (e.trouble() == Trouble::internal || e.faults().empty() || e.faults().front().rule.empty())
      std::abort();
  }
}

/// A folder of this process with the URDFs of tests/corpus, in which specs of the corpus find them at
/// ../arm.urdf; removed at exit.
class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "qerr_fuzz_XXXXXX").string();
    if (!mkdtemp(name.data())) std::abort();
    top_ = name;
    std::filesystem::create_directory(top_ / "work");
    for (const auto& entry : std::filesystem::directory_iterator(QERR_SOURCE_DIR "/tests/corpus"))
      if (entry.path().extension() == ".urdf")
        std::filesystem::copy_file(entry.path(), top_ / entry.path().filename());
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(top_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::string file(const std::string& name) const { return (top_ / "work" / name).string(); }

  std::string write(const std::string& name, const std::uint8_t* data, std::size_t size) const {
    std::ofstream(file(name), std::ios::binary)
        .write(reinterpret_cast<const char*>(data), static_cast<long>(size));
    return file(name);
  }
  std::string text(const std::string& name, const std::string& content) const {
    return write(name, reinterpret_cast<const std::uint8_t*>(content.data()), content.size());
  }

 private:
  std::filesystem::path top_;
};

inline const Folder& folder() {
  static const Folder one;
  return one;
}

/// A spec of the corpus' arm (revolute shoulder and elbow, a continuous wrist, a prismatic lift).
inline std::string arm_spec(const std::string& more) {
  return "qerr: 1\nrobot: {urdf: ../arm.urdf}\nencoders: {'*': {counts_per_rev: 4096}, lift: {resolution: 10 "
         "um}}\n" +
         more;
}

inline std::string text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

}  // namespace qerr::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
