#include "input/unknown_key.hpp"

#include <algorithm>
#include <cctype>
#include <string_view>
#include <utility>

#include "core/suggest.hpp"
#include "core/text.hpp"
#include "input/spec_format.hpp"
#include "qerr/encoder/encoder_kinds.hpp"
#include "qerr/filter/family.hpp"

namespace qerr {

namespace {

bool has_row(const std::vector<Parameter>& rows, std::string_view key) {
  return std::any_of(rows.begin(), rows.end(), [&](const Parameter& p) { return p.name == key; });
}

/// Where a key belongs that stands in the wrong mapping; "" if no section has it, or several have.
std::string home_of(std::string_view key) {
  using namespace spec_format;
  std::string found;
  int homes = 0;
  const auto count = [&](const std::vector<Parameter>& rows, const char* home) {
    if (has_row(rows, key) && found != home) found = home, ++homes;
  };
  count(top(), "at the left margin, beside robot and encoders");
  count(robot(), "in robot: {...}");
  count(configurations(), "in configurations: {...}");
  count(threshold(), "in threshold: {...}");
  count(motion(), "in motion: {...}");
  count(requirement(), "in an entry of requirements: [...]");
  count(joint_motion(), "in a joint of motion: {joints: {...}}");
  count(filter(), "in an entry of filters: {...}");
  count(sine(), "in an entry of sines: [...]");
  count(effect(), "in an entry of effects: [...]");
  count(sweep(), "in an entry of sweep: [...]");
  count(lowpass(), "in the filter's lowpass: {...}");
  for (const FilterFamily& family : filter_families())
    count(family.parameters, "in the filter's lowpass: {...}");
  for (const EncoderKind& kind : encoder_kinds())
    count(encoder_parameters(kind), "in an entry of encoders: {...}");
  return homes == 1 ? found : "";
}

/// `{at_most: 0,02 deg}` has the entries `at_most: 0` and `02 deg`.
std::optional<Fault> after_decimal_comma(const Field& map, const Node::Entry& entry) {
  const auto& entries = map.node->entries;
  const std::string& rest = entry.key.name;
  if (entry.value.type != Node::Type::null || rest.empty() || rest[0] < '0' || rest[0] > '9')
    return std::nullopt;
  for (std::size_t i = 1; i < entries.size(); ++i)
    if (&entries[i] == &entry && entries[i - 1].value.type == Node::Type::scalar) {
      const std::string text = entries[i - 1].value.text + ',' + rest;
      const NumberAdvice advice = advice_on_number(text, "");
      if (advice.remedy.empty()) return std::nullopt;
      return Fault{entries[i - 1].value.place, map.path_of(entries[i - 1].key.name), advice.rule,
                   quoted(text), advice.remedy};
    }
  return std::nullopt;
}

}  // namespace

const Node::Entry* empty_section_before(const Node& map, const Node::Entry& entry) {
  const Node::Entry* section = nullptr;
  for (const Node::Entry& other : map.entries) {
    if (&other == &entry) return section;
    const bool empty = other.value.type == Node::Type::null;
    if (empty || has_row(spec_format::top(), other.key.name)) section = empty ? &other : nullptr;
  }
  return nullptr;
}

std::string with_space_after_colon(const std::string& text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 >= text.size() || text[colon + 1] == ' ')
    return "";
  const std::string key = text.substr(0, colon);
  const bool plain = std::all_of(key.begin(), key.end(), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) ||
           std::string_view("_*?[]-").find(c) != std::string_view::npos;
  });
  const bool path = text[colon + 1] == '/' || text[colon + 1] == '\\' || text[colon + 1] == ':';
  return plain && !path ? key + ": " + text.substr(colon + 1) : "";
}

namespace {

Fault unknown_key(const Field& map, const Node::Entry& entry, const std::vector<std::string>& known) {
  const std::string& name = entry.key.name;
  const std::string path = map.path_of(name);
  if (const std::string corrected = with_space_after_colon(name);
      !corrected.empty() && entry.value.type == Node::Type::null)
    return {entry.key.place, path, "a colon after a key must be followed by a space", quoted(name),
            "write " + quoted(corrected)};
  if (name.starts_with("//") || name.starts_with(';') || name.starts_with("--"))
    return {entry.key.place, path, "unknown key", quoted(name), "a comment begins with #"};
  if (const std::size_t equals = name.find('='); equals != std::string::npos && equals > 0)
    return {entry.key.place, path, "a key is followed by a colon, not by =", quoted(name),
            "write 'key: value'"};
  if (auto fault = after_decimal_comma(map, entry)) return *fault;
  if (const Node::Entry* section = empty_section_before(*map.node, entry))
    return {entry.key.place, path, "unknown key beside '" + section->key.name + "', which is empty",
            quoted(name), "indent by two spaces what belongs into " + section->key.name};
  // `order` of `polynomial_order`.
  const auto part = std::find_if(known.begin(), known.end(),
                                 [&](const std::string& key) { return key.ends_with('_' + name); });
  if (part != known.end())
    return {entry.key.place, path, "unknown key", quoted(name), "did you mean " + quoted(*part) + "?"};
  std::string remedy = did_you_mean(name, known);
  if (const std::string home = remedy.starts_with("did") ? "" : home_of(name);
      !home.empty() && !(path.ends_with(".lowpass." + name) && home.find("lowpass") != std::string::npos))
    remedy = quoted(name) + " belongs " + home;
  return {entry.key.place, path, "unknown key", quoted(name), remedy};
}

}  // namespace

void add_unknown_key(const Field& map, const Node::Entry& entry, const std::vector<std::string>& known,
                     std::vector<Fault>& faults) {
  constexpr std::size_t most = 20;
  faults.push_back(faults.size() < most
                       ? unknown_key(map, entry, known)
                       : Fault{entry.key.place, map.path_of(entry.key.name), "unknown key", "", ""});
}

}  // namespace qerr
