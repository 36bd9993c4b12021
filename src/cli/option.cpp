#include "cli/option.hpp"

#include <stdexcept>
#include <utility>

#include "core/text.hpp"
#include "qerr/core/quantity.hpp"

namespace qerr::cli {

std::string Option::long_name() const { return std::string(name.substr(name.rfind(',') + 1)); }

std::string Option::short_name() const {
  const std::size_t comma = name.find(',');
  return comma == std::string_view::npos ? "" : std::string(name.substr(0, comma));
}

std::string Option::key() const { return long_name().substr(positional() ? 0 : 2); }

std::string Option::range() const {
  if (kind != OptionKind::number && kind != OptionKind::whole) return "";
  return significant(least, 9) + " to " + (most == 0x1p53 - 1 ? "2^53 - 1" : significant(most, 9));
}

Values::Values(Texts given, Texts fallbacks) : given_(std::move(given)), fallbacks_(std::move(fallbacks)) {}

bool Values::given(std::string_view name) const { return !texts(name).empty(); }

const std::string& Values::text(std::string_view name) const {
  static const std::string none;
  if (given(name)) return texts(name).front();
  const auto fallback = fallbacks_.find(name);
  return fallback == fallbacks_.end() ? none : fallback->second.front();
}

const std::vector<std::string>& Values::texts(std::string_view name) const {
  const auto found = given_.find(name);
  if (found == given_.end()) throw std::logic_error("the command has no option '" + std::string(name) + "'");
  return found->second;
}

double Values::number(std::string_view name) const { return parse_number(text(name)).value(); }

std::uint64_t Values::whole(std::string_view name) const { return static_cast<std::uint64_t>(number(name)); }

}  // namespace qerr::cli
