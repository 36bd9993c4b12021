#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "qerr/bound/workspace.hpp"
#include "qerr/input/spec.hpp"
#include "qerr/report/write.hpp"

/// What every command shares: its options, where results and messages go.
namespace qerr::cli {

/// Options that all commands take.
struct Options {
  std::string format;  ///< "" until decided from the output's ending
  std::string output = "-";
  std::vector<std::string> set;
  std::string seed;
  unsigned threads = 0;
  bool quiet = false;
  bool no_color = false;
};

/// A command: its line in the help, how it declares its own arguments, and its work, which returns the exit
/// code.
struct Command {
  std::string_view name;
  std::string_view summary;
  std::function<int()> (*declare)(CLI::App&, Options&);
};

/// Every command, in the order of the help.
const std::vector<Command>& commands();

std::function<int()> declare_analyze(CLI::App&, Options&);
std::function<int()> declare_check(CLI::App&, Options&);
std::function<int()> declare_filter(CLI::App&, Options&);
std::function<int()> declare_diagnose(CLI::App&, Options&);
std::function<int()> declare_simulate(CLI::App&, Options&);
std::function<int()> declare_threshold(CLI::App&, Options&);
std::function<int()> declare_list(CLI::App&, Options&);
std::function<int()> declare_schema(CLI::App&, Options&);

/// Adds --format, -o, --threads, ...; those that change a spec only where there is one.
void add_output_options(CLI::App&, Options&);
void add_spec_options(CLI::App&, Options&);

/// The spec with the command line's changes.
Spec load(const std::string& path, const Options&);

/// The format asked for, or that of the output's ending, or the table.
std::string chosen_format(const Options&);
Style style(const Options&);

/// Warnings to standard error, one line each, unless --quiet.
void warn(const std::vector<std::string>& warnings, const Options&);

/// Shows done/total on a terminal's standard error, at most ten times a second; nothing elsewhere.
std::function<void(std::uint64_t, std::uint64_t)> progress(const Options&);

}  // namespace qerr::cli
