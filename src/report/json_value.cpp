#include "report/json_value.hpp"

#include <algorithm>
#include <string_view>

#include "core/text.hpp"
#include "input/byte_source.hpp"
#include "qerr/core/error.hpp"

namespace qerr {

namespace {

Error no_json(const std::string& text, std::size_t byte, const std::string& file, const std::string& rule) {
  const std::string rest =
      text.substr(byte, std::min(text.find_first_of("\r\n", byte) - byte, std::size_t{30}));
  // What a file of another kind holds may be nobody's business.
  const bool report = text.find("\"qerr\"") != std::string::npos;
  return Error(Fault{place_of_byte(text, byte, file), "", rule,
                     rest.empty() ? "its end"
                     : report     ? quoted(rest)
                                  : "",
                     "write the file anew with --format json"});
}

/// The first number beyond the doubles that is not within a string.
std::size_t place_of_large_number(const std::string& text) {
  constexpr std::string_view parts = "+-.0123456789Ee";
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (text[at] == '"') {
      while (++at < text.size() && text[at] != '"') at += text[at] == '\\';
    } else if (parts.find(text[at]) < parts.size() - 2) {
      const std::size_t end = std::min(text.find_first_not_of(parts, at), text.size());
      if (Json::parse(text.substr(at, end - at), nullptr, false).is_discarded()) return at;
      at = end - 1;
    }
  }
  return 0;
}

std::string escaped_code(unsigned code) {
  if (code >= 0x10000)  // two surrogates
    return escaped_code(0xD800 + (code - 0x10000) / 0x400) + escaped_code(0xDC00 + code % 0x400);
  return "\\u" + hexadecimal(static_cast<unsigned char>(code >> 8)) +
         hexadecimal(static_cast<unsigned char>(code & 0xFF));
}

/// What a reader cannot see, or a terminal obeys, is valid in JSON: as \uXXXX the text is the same. It
/// occurs in strings only, except for line ends.
std::string terminal_safe(const std::string& text) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t hidden = text[i] == '\n' ? 0 : hidden_length(text, i);
    const std::size_t length = std::max<std::size_t>(utf8_length(text, i), 1);
    if (hidden > 0)
      out += escaped_code(code_point(text, i));
    else
      out.append(text, i, length);
    i += length;
  }
  return out;
}

std::string text(const Json& json, int indent) {
  return terminal_safe(json.dump(indent, ' ', false, Json::error_handler_t::replace));
}

}  // namespace

Json parse_json(const std::string& text, const std::string& file) {
  constexpr int most_levels = 64;  // readers call themselves for each
  if (text.find_first_not_of(" \t\r\n") == std::string::npos)
    throw Error(Fault{{file, 1, 1}, "", "the file is empty", "", "write it anew with --format json"});
  const auto limited = [&](int depth, Json::parse_event_t, const Json&) {
    if (depth > most_levels) throw no_json(text, 0, file, "has more than 64 levels: this is no report");
    return true;
  };
  try {
    return Json::parse(text, limited);
  } catch (const Json::parse_error& e) {
    throw no_json(text, std::min(text.size(), e.byte > 0 ? e.byte - 1 : 0), file,
                  "the text is no valid JSON");
  } catch (const Json::out_of_range&) {
    throw no_json(text, place_of_large_number(text), file, "a number is too large");
  }
}

std::string document(const Json& json) { return text(json, 2) + '\n'; }

std::string line(const Json& json) { return text(json, -1); }

}  // namespace qerr
