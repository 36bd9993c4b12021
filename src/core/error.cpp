#include "qerr/core/error.hpp"

#include <algorithm>
#include <utility>

#include "core/text.hpp"

namespace qerr {

namespace {

constexpr std::size_t most_lines = 20;

/// A fault that is a remedy and nothing else is a text to paste: its lines stand by themselves.
std::string pasteable(const std::string& text) {
  std::string out;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    out += (begin > 0 ? "\n" : "") + escaped(text.substr(begin, end - begin), text.size() + 1);
    begin = end + 1;
  }
  return out;
}

std::string line_of(const Fault& fault) {
  if (fault.place.file.empty() && fault.key.empty() && fault.rule.empty() && fault.found.empty())
    return pasteable(fault.remedy);
  std::string line = fault.place.file.empty() ? "qerr" : escaped(fault.place.file);
  if (fault.place.line > 0) {
    line += ':' + std::to_string(fault.place.line);
    if (fault.place.column > 0) line += ':' + std::to_string(fault.place.column);
  }
  line += ": ";
  // The place of an override already names its key.
  const bool named = !fault.key.empty() && fault.place.file.ends_with(' ' + fault.key);
  if (!fault.key.empty() && !named) line += escaped(fault.key) + ": ";
  line += escaped(fault.rule, 600);
  if (!fault.found.empty()) line += ", found " + escaped(fault.found);
  if (!fault.remedy.empty()) line += "; " + escaped(fault.remedy, 600);
  return line;
}

}  // namespace

std::string escaped(const std::string& text, std::size_t limit) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t hidden = hidden_length(text, i);
    const std::size_t step = hidden > 0 ? hidden : utf8_length(text, i);
    if (hidden > 0) {
      for (std::size_t k = 0; k < step; ++k)
        out += "\\x" + hexadecimal(static_cast<unsigned char>(text[i + k]));
    } else {
      out.append(text, i, step);
    }
    i += step;
    if (out.size() >= limit && i < text.size()) return out + "...";
  }
  return out;
}

std::string format(const std::vector<Fault>& faults) {
  std::string text;
  const std::size_t shown = faults.size() > most_lines ? most_lines - 1 : faults.size();
  for (std::size_t i = 0; i < shown; ++i) text += (i ? "\n" : "") + line_of(faults[i]);
  if (shown < faults.size()) text += "\n(" + std::to_string(faults.size() - shown) + " more faults)";
  return text;
}

Error::Error(Place place, std::string key, std::string rule, std::string found, std::string remedy,
             Trouble trouble)
    : Error(Fault{std::move(place), std::move(key), std::move(rule), std::move(found), std::move(remedy)},
            trouble) {}

Error::Error(std::string key, std::string rule, std::string found, std::string remedy, Trouble trouble)
    : Error(Place{}, std::move(key), std::move(rule), std::move(found), std::move(remedy), trouble) {}

Error::Error(Fault fault, Trouble trouble) : Error(std::vector<Fault>{std::move(fault)}, trouble) {}

Error::Error(std::vector<Fault> faults, Trouble trouble)
    : std::runtime_error(format(faults)), faults_(std::move(faults)), trouble_(trouble) {}

}  // namespace qerr
