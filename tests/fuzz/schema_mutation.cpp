#include "fuzz/schema_mutation.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <iterator>
#include <random>
#include <vector>

#include "qerr/report/write.hpp"

namespace qerr::fuzz {

namespace {

using YAML::Node;

constexpr int deepest = 12;

/// Values at the edges of number formats, of units and of physics.
const char* const hostile[] = {"0",
                               "-0.0",
                               "-1",
                               "1",
                               "2",
                               "0.5",
                               "1e-320",
                               "1e-300",
                               "1e300",
                               "1.8e308",
                               "-1e18",
                               "1e9",
                               "65536",
                               "2147483648",
                               "9007199254740993",
                               ".nan",
                               ".inf",
                               "true",
                               "null",
                               "''",
                               "' '",
                               "[]",
                               "{}",
                               "[[]]",
                               "1 mm",
                               "1e300 m",
                               "0 rad",
                               "-5 deg",
                               "1 Hz",
                               "1e-300 s",
                               "1e12 Hz",
                               "100 %",
                               "1 N m",
                               "'*'",
                               "shoulder",
                               "lift",
                               "velocity",
                               "0..5",
                               "5..0",
                               "1 furlong",
                               "0x10",
                               "1_000",
                               "\"\\u202e\"",
                               "\"\\u001b[31m\"",
                               "nearest",
                               "known"};

/// Keys of mappings that the user names: joints of the corpus' arm, a filter.
const char* const names[] = {"shoulder", "elbow", "wrist", "lift", "*", "velocity"};

class Change {
 public:
  explicit Change(unsigned seed) : random_(seed) {}

  /// A value that the schema allows, or nearly so.
  Node value(const Node& schema, int depth = 0) {
    if (depth > deepest || one_in(8)) return YAML::Load(pick(hostile));
    for (const char* key : {"oneOf", "anyOf"})
      if (const Node all = schema[key]; all && all.IsSequence() && all.size() > 0)
        return value(all[index(all.size())], depth + 1);
    if (const Node allowed = schema["enum"]; allowed && allowed.size() > 0)
      return YAML::Clone(allowed[index(allowed.size())]);
    if (schema["const"]) return YAML::Clone(schema["const"]);
    const std::string type = schema["type"] && schema["type"].IsScalar() ? schema["type"].Scalar() : "";
    if (type == "object") return object(schema, depth);
    if (type == "array") return array(schema, depth);
    if (type == "number" || type == "integer") return number(schema);
    return YAML::Load(pick(hostile));
  }

  /// Changes one place of a tree.
  void change(Node root, const Node& schema) {
    std::vector<Place> places;
    collect(root, schema, 0, places);
    if (places.empty()) return;
    Place& p = places[index(places.size())];
    switch (index(4)) {
      case 0:
        p.parent[p.key] = YAML::Load(pick(hostile));
        break;
      case 1:
        p.parent.remove(p.key);
        break;
      case 2:
        add_key(p);
        break;
      default:
        p.parent[p.key] = value(p.schema);
    }
  }

 private:
  struct Place {
    Node parent;
    std::string key;
    Node schema;         // of the value
    Node parent_schema;  // with the keys that may be added
  };

  std::size_t index(std::size_t count) { return static_cast<std::size_t>(random_() % count); }
  bool one_in(unsigned count) { return random_() % count == 0; }
  template <std::size_t n>
  const char* pick(const char* const (&words)[n]) {
    return words[index(n)];
  }

  Node object(const Node& schema, int depth) {
    Node made(YAML::NodeType::Map);
    std::vector<std::string> required;
    if (schema["required"])
      for (const Node& name : schema["required"]) required.push_back(name.Scalar());
    if (const Node rows = schema["properties"]; rows && rows.IsMap())
      for (const auto& row : rows) {
        const std::string name = row.first.Scalar();
        const bool needed = std::find(required.begin(), required.end(), name) != required.end();
        if (needed ? !one_in(10) : one_in(4)) made[name] = value(row.second, depth + 1);
      }
    if (const Node rest = schema["additionalProperties"]; rest && rest.IsMap())
      made[pick(names)] = value(rest, depth + 1);
    return made;
  }

  Node array(const Node& schema, int depth) {
    Node made(YAML::NodeType::Sequence);
    if (const Node items = schema["items"]; items && items.IsMap())
      for (std::size_t i = index(4); i-- > 0;) made.push_back(value(items, depth + 1));
    return made;
  }

  Node number(const Node& schema) {
    for (const char* bound : {"minimum", "exclusiveMinimum", "maximum", "exclusiveMaximum"})
      if (schema[bound] && one_in(4)) return YAML::Clone(schema[bound]);
    return Node(std::uniform_real_distribution<double>(0, 100)(random_));
  }

  void add_key(Place& p) {
    const Node rows = p.parent_schema["properties"];
    if (!rows || !rows.IsMap() || rows.size() == 0) return;
    auto row = rows.begin();
    std::advance(row, static_cast<long>(index(rows.size())));
    p.parent[row->first.Scalar()] = value(row->second);
  }

  /// The alternative of a schema that has the keys of a mapping; else one of them.
  Node alternative(const Node& schema, const Node& node) {
    for (const char* key : {"oneOf", "anyOf"})
      if (const Node all = schema[key]; all && all.IsSequence() && all.size() > 0) {
        for (const Node& one : all)
          if (node.IsMap() && node.size() > 0 && one["properties"] &&
              one["properties"][node.begin()->first.Scalar()])
            return one;
        return all[index(all.size())];
      }
    return schema;
  }

  void collect(Node node, const Node& unresolved, int depth, std::vector<Place>& places) {
    if (depth > deepest) return;
    if (node.IsSequence()) {
      const Node items = unresolved["items"];
      for (std::size_t i = 0; i < node.size(); ++i)
        collect(node[i], items && items.IsMap() ? items : Node(YAML::NodeType::Map), depth + 1, places);
    }
    if (!node.IsMap()) return;
    const Node schema = alternative(unresolved, node);
    for (const auto& entry : node) {
      if (!entry.first.IsScalar()) continue;
      const std::string key = entry.first.Scalar();
      const Node rows = schema["properties"], rest = schema["additionalProperties"];
      Node of_value(YAML::NodeType::Map);
      if (rows && rows.IsMap() && rows[key])
        of_value.reset(rows[key]);
      else if (rest && rest.IsMap())
        of_value.reset(rest);
      places.push_back({node, key, of_value, schema});
      collect(entry.second, of_value, depth + 1, places);
    }
  }

  std::mt19937 random_;
};

}  // namespace

std::string changed_by_schema(const std::string& spec, unsigned seed) {
  static const Node schema = YAML::Load(json_schema());
  if (spec.find('&') != std::string::npos) return "";  // an alias may make a tree endless
  try {
    Node root = YAML::Load(spec);
    if (!root.IsMap()) return "";
    Change change(seed);
    change.change(root, schema);
    return YAML::Dump(root) + '\n';
  } catch (const YAML::Exception&) {
    return "";
  }
}

}  // namespace qerr::fuzz
