#include <stdexcept>
#include <utility>

#include "cli/command.hpp"
#include "core/text.hpp"
#include "qerr/core/quantity.hpp"
#include "report/text_table.hpp"

namespace qerr::cli {

namespace {

std::vector<std::string> when_words() { return {"auto", "always", "never"}; }

std::vector<Command> table() {
  std::vector<Command> rows{analyze_command(),  check_command(),     compare_command(),   sweep_command(),
                            merge_command(),    design_command(),    filter_command(),    simulate_command(),
                            diagnose_command(), threshold_command(), robot_command(),     list_command(),
                            schema_command(),   help_command(),      completion_command()};
  for (Command& command : rows)
    command.options.insert(command.options.end(), global_options().begin(), global_options().end());
  return rows;
}

}  // namespace

const std::vector<Option>& global_options() {
  static const std::vector<Option> rows{
      flag("-q,--quiet", "no warnings, no progress"),
      valued("--color", "WHEN", "always, never, or auto: on a terminal, unless NO_COLOR is set")
          .otherwise("auto")
          .one_of(when_words, "choice"),
      flag("--no-color", "the same as --color never"),
      valued("--progress", "WHEN", "always, never, or auto: on a terminal, unless --quiet")
          .otherwise("auto")
          .one_of(when_words, "choice"),
      flag("--force", "let an output replace a spec, URDF or catalogue, which a person may have edited"),
      flag("-h,--help", "this help"),
      flag("-V,--version", "the version of qerr")};
  return rows;
}

const std::vector<Command>& commands() {
  static const std::vector<Command> rows = table();
  return rows;
}

const Command* command_of(std::string_view name) { return find_named(commands(), name); }

std::vector<std::string> command_names() { return names_of(commands()); }

std::string usage_line(const Command& command) {
  std::string line = "qerr " + std::string(command.name) + " [OPTION...]";
  for (const Option& row : command.options)
    if (row.positional())
      line += (row.required ? " " : " [") + std::string(row.name) + (row.repeats() ? "..." : "") +
              (row.required ? "" : "]");
  return line;
}

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
