#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

#include "qerr/core/quantity.hpp"
#include "qerr/input/spec.hpp"
#include "qerr/report/write.hpp"

namespace qerr {
namespace {

namespace fs = std::filesystem;

/// A spec as an editor's YAML server parses it.
nlohmann::json to_json(const YAML::Node& node) {
  if (node.IsSequence()) {
    nlohmann::json list = nlohmann::json::array();
    for (const YAML::Node& item : node) list.push_back(to_json(item));
    return list;
  }
  if (node.IsMap()) {
    nlohmann::json object = nlohmann::json::object();
    for (const auto& entry : node) object[entry.first.as<std::string>()] = to_json(entry.second);
    return object;
  }
  if (node.IsNull()) return nullptr;
  const std::string text = node.as<std::string>();
  if (node.Tag() == "!") return text;
  if (text == "true" || text == "false") return text == "true";
  const auto number = parse_number(text);
  if (number && *number == std::floor(*number) && std::abs(*number) < 1e15)
    return static_cast<std::int64_t>(*number);
  return number ? nlohmann::json(*number) : nlohmann::json(text);
}

class SpecSchema : public ::testing::Test {
 protected:
  void SetUp() override {
    const nlohmann::json json = nlohmann::json::parse(json_schema());
    valijson::SchemaParser parser;
    parser.populateSchema(valijson::adapters::NlohmannJsonAdapter(json), schema_);
  }

  bool valid(const nlohmann::json& spec) {
    valijson::Validator validator;
    return validator.validate(schema_, valijson::adapters::NlohmannJsonAdapter(spec), nullptr);
  }

  static std::vector<fs::path> specs(const std::string& folder) {
    std::vector<fs::path> found;
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(QERR_SOURCE_DIR) / folder))
      if (entry.path().extension() == ".yaml") found.push_back(entry.path());
    std::sort(found.begin(), found.end());
    return found;
  }

  valijson::Schema schema_;
};

TEST_F(SpecSchema, AcceptsEverySpecThatTheReaderAccepts) {
  std::size_t count = 0;
  for (const char* folder : {"configs", "tests/corpus/good_specs"})
    for (const fs::path& path : specs(folder)) {
      EXPECT_NO_THROW(read_spec(path.string())) << path;
      EXPECT_TRUE(valid(to_json(YAML::LoadFile(path.string())))) << path;
      ++count;
    }
  EXPECT_GE(count, 20u);
}

TEST_F(SpecSchema, RejectsMostSpecsThatTheReaderRejects) {
  std::size_t refused = 0;
  for (const fs::path& path : specs("tests/corpus/bad_specs")) {
    EXPECT_THROW(read_spec(path.string()), Error) << path;
    std::ifstream in(path);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    if (text.find(" &") != std::string::npos) continue;  // an alias bomb would be unfolded here
    try {
      refused += !valid(to_json(YAML::LoadFile(path.string())));
    } catch (const YAML::Exception&) {
      ++refused;
    }
  }
  // A schema cannot check names of joints, stability or limits of the URDF; keys, kinds and ranges are most
  // of the corpus.
  EXPECT_GE(refused, 100u);
}

TEST_F(SpecSchema, DescribesEveryKey) {
  std::size_t count = 0;
  const auto walk = [&](auto&& self, const nlohmann::json& schema, const std::string& at) -> void {
    if (schema.is_object() && schema.contains("properties") && schema["properties"].is_object())
      for (const auto& [key, row] : schema["properties"].items()) {
        EXPECT_NE(row.value("description", ""), "") << at << '/' << key;
        ++count;
      }
    if (schema.is_structured())
      for (const auto& [key, child] : schema.items()) self(self, child, at + '/' + key);
  };
  const nlohmann::json schema = nlohmann::json::parse(json_schema());
  EXPECT_EQ(schema["$id"], "urn:qerr:spec:1");
  walk(walk, schema, "");
  EXPECT_GE(count, 200u);
}

TEST_F(SpecSchema, HasTheBoundsOfPhysics) {
  const auto with_rate = [&](const std::string& rate) {
    return valid(
        to_json(YAML::Load("{qerr: 1, robot: {urdf: a.urdf}, encoders: {'*': {bits: 12}}, "
                           "filters: {v: {derivative: 1, sample_rate: " +
                           rate + "}}}")));
  };
  EXPECT_TRUE(with_rate("1000"));
  EXPECT_FALSE(with_rate("1e300"));
  EXPECT_FALSE(with_rate("1e-300"));
}

/// A key with one letter added is unknown to both reader and schema, at every depth.
TEST_F(SpecSchema, HasExactlyTheKeysOfTheReader) {
  const fs::path file = fs::temp_directory_path() / ("qerr_schema_" + std::to_string(getpid()) + ".yaml");
  const std::set<std::string> free_keys{"/encoders",       "/filters",         "/configurations/limits",
                                        "/motion/joints",  "/design/encoders", "/design/filters",
                                        "/control/joints", "/walls",           "/estimators",
                                        "/design/gains"};
  const auto read = [&](const nlohmann::json& spec) {
    std::ofstream(file) << spec.dump();  // JSON is YAML
    read_spec(file.string());
  };
  std::size_t changed = 0;
  std::set<std::string> tried;
  const auto walk = [&](auto&& self, const nlohmann::json& whole,
                        const nlohmann::json::json_pointer& at) -> void {
    const nlohmann::json& value = whole[at];
    if (value.is_array())
      for (std::size_t i = 0; i < value.size(); ++i) self(self, whole, at / i);
    if (!value.is_object()) return;
    for (const auto& [key, child] : value.items()) {
      self(self, whole, at / key);
      if (free_keys.contains(at.to_string())) continue;
      // One misspelt key of each place and kind (of effect, family, ...) is enough.
      std::string place = at.to_string() + '/' + key;
      std::erase_if(place, [](char c) { return c >= '0' && c <= '9'; });  // of rows
      for (const char* kind : {"type", "family"})
        if (value.contains(kind)) place += ' ' + value[kind].dump();
      if (!tried.insert(place).second) continue;
      nlohmann::json other = whole;
      other[at][key + "x"] = child;
      EXPECT_FALSE(valid(other)) << at.to_string() << '/' << key << 'x';
      EXPECT_THROW(read(other), Error) << at.to_string() << '/' << key << 'x';
      ++changed;
    }
  };
  for (const fs::path& path : specs("tests/corpus/good_specs")) {
    nlohmann::json spec = to_json(YAML::LoadFile(path.string()));
    spec["robot"]["urdf"] =
        fs::absolute(path.parent_path() / spec["robot"]["urdf"].get<std::string>()).string();
    for (const char* section : {"configurations", "motion"})
      if (spec.contains(section) && spec[section].contains("file"))
        spec[section]["file"] =
            fs::absolute(path.parent_path() / spec[section]["file"].get<std::string>()).string();
    ASSERT_NO_THROW(read(spec)) << path;
    walk(walk, spec, nlohmann::json::json_pointer(""));
  }
  fs::remove(file);
  EXPECT_GE(changed, 100u);
}

}  // namespace
}  // namespace qerr
