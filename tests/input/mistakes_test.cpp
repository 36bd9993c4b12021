#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "input/csv.hpp"
#include "input/yaml_tree.hpp"
#include "qerr/input/spec.hpp"

namespace qerr {
namespace {

const std::string kuka = QERR_SOURCE_DIR "/configs/kuka_lwr/";
const std::string all_joints = "{counts_per_rev: 4096, gear_ratio: 100}";
const std::string good = "qerr: 1\nrobot: {urdf: kuka_lwr.urdf}\nencoders:\n  '*': " + all_joints +
                         "\n"
                         "configurations: {count: 20}\n";

/// Words of the parsers that a user has not written and cannot look up.
const std::vector<std::string> inner_words{
    "yaml-cpp",      "bad conversion", "illegal map", "flow end",        "block entry",
    "anchor is not", "not valid YAML", "end of map",  "end of sequence", "invalid node",
    "token",         "std::",          "stoi",        "basic_string",    "exception"};

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

std::string value(const Node& entry, const char* key) {
  const Node* found = entry.find(key);
  return found ? replaced(replaced(found->text, "⏎", "\n"), "⇥", "\t") : "";
}

/// The message of a mistake; "" if the spec is accepted.
std::string answer(const Node& mistake) {
  const std::string change = value(mistake, "set");
  std::string whole = value(mistake, "spec");
  if (mistake.find("encoder")) whole = replaced(good, all_joints, value(mistake, "encoder"));
  SpecOverrides overrides;
  if (const std::size_t equals = change.find('='); equals != std::string::npos)
    overrides.values = {{change.substr(0, equals), change.substr(equals + 1)}};
  try {
    parse_spec(whole.empty() ? good + value(mistake, "add") : whole, kuka + "spec.yaml", overrides);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(Mistakes, AreAnsweredWithOneLineThatHasThePlaceAndTheRemedy) {
  const std::string path = QERR_SOURCE_DIR "/tests/corpus/mistakes.yaml";
  const Node mistakes = parse_yaml(read_text(path), path);
  ASSERT_GT(mistakes.items.size(), 150u);
  for (const Node& mistake : mistakes.items) {
    const std::string message = answer(mistake), place = value(mistake, "place");
    const std::string change = value(mistake, "set");
    SCOPED_TRACE("line " + std::to_string(mistake.place.line) + ": " + message);
    const std::string begin =
        change.empty() ? kuka + "spec.yaml:" + place + ": " : "--set " + change.substr(0, change.find('='));
    EXPECT_EQ(message.substr(0, begin.size()), begin);
    EXPECT_NE(message.find("; " + value(mistake, "remedy")), std::string::npos);
    EXPECT_EQ(message.find('\n'), std::string::npos) << "one mistake, one message";
    for (const std::string& word : inner_words) EXPECT_EQ(message.find(word), std::string::npos) << word;
  }
}

TEST(Mistakes, OfXmlEmptyFilesAndLineEndsAreNamed) {
  const auto said = [](const std::string& text) {
    try {
      parse_spec(text, "spec.yaml");
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(said("<?xml version=\"1.0\"?>\n<robot/>\n").find("spec.yaml:1:1: this is a URDF, not a spec"),
            0u);
  EXPECT_EQ(said(""), "spec.yaml:1:1: the file is empty; a spec begins with 'qerr: 1'");
  EXPECT_EQ(said("# nothing\n"), "spec.yaml:1:1: the file is empty; a spec begins with 'qerr: 1'");
  EXPECT_EQ(said("qerr: 1\rrobot: {}\r").find("spec.yaml:1:8: a carriage return without a line feed"), 0u);
  EXPECT_EQ(said("- qerr: 1\n"),
            "spec.yaml:1:1: a spec must be a mapping, found a list of 1; begin with 'qerr: 1'");
}

}  // namespace
}  // namespace qerr
