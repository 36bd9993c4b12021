#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <exception>
#include <new>

#include "cli/command.hpp"
#include "core/output_file.hpp"
#include "core/suggest.hpp"

namespace {

constexpr int closed_pipe_code = 128 + SIGPIPE;

extern "C" void stop(int signal) {
  qerr::remove_unfinished_outputs();
  _exit(128 + signal);
}

/// Results are renamed into place only when whole, so that a signal may end the work at any point.
void set_signals() {
  std::signal(SIGINT, stop);
  std::signal(SIGTERM, stop);
  // A closed pipe must not kill the process before it has removed its temporary files: write() fails with
  // EPIPE.
  std::signal(SIGPIPE, SIG_IGN);
}

std::vector<std::string> command_names() {
  std::vector<std::string> names;
  for (const qerr::cli::Command& c : qerr::cli::commands()) names.emplace_back(c.name);
  return names;
}

/// What to say of an option that the command does not know, or "" when all are known.
std::string unknown_option(CLI::App& app, int argc, char** argv) {
  if (argc < 3) return {};
  const auto commands = app.get_subcommands([&](const CLI::App* c) { return c->get_name() == argv[1]; });
  if (commands.empty()) return {};
  std::vector<std::string> known;
  for (const CLI::Option* option : commands.front()->get_options())
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  for (int i = 2; i < argc; ++i) {
    const std::string word = std::string(argv[i]).substr(0, std::string(argv[i]).find('='));
    if (word == "--") break;
    if (word.starts_with("--") && std::find(known.begin(), known.end(), word) == known.end())
      return "no such option, found '" + word + "'; " + qerr::did_you_mean(word, known);
  }
  return {};
}

int run(int argc, char** argv) {
  using namespace qerr::cli;
  CLI::App app{
      "qerr: how large the errors of a robot's encoders get at its tip, and in filtered velocity and "
      "acceleration"};
  app.set_version_flag("--version", "qerr " + std::string(qerr::version()));
  app.require_subcommand(1);
  app.get_formatter()->column_width(28);
  Options options;
  std::vector<std::pair<CLI::App*, std::function<int()>>> work;
  for (const Command& command : commands()) {
    CLI::App* sub = app.add_subcommand(std::string(command.name), std::string(command.summary));
    work.emplace_back(sub, command.declare(*sub, options));
  }
  // CLI11 says "A subcommand is required" to a mistyped one; the word itself is what helps.
  if (argc > 1 && argv[1][0] != '-') {
    const std::vector<std::string> names = command_names();
    const std::string word = argv[1];
    if (std::find(names.begin(), names.end(), word) == names.end())
      throw qerr::Error(
          {{"", 0, 0}, "", "no such command", "'" + word + "'", qerr::did_you_mean(word, names)},
          qerr::Trouble::usage);
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) return app.exit(e);
    const std::string option = unknown_option(app, argc, argv);
    const std::string help =
        "see qerr " + (argc > 1 && argv[1][0] != '-' ? argv[1] + std::string(" ") : "") + "--help";
    if (!option.empty()) throw qerr::Error({{"", 0, 0}, "", option, "", help}, qerr::Trouble::usage);
    const bool nothing = argc == 1;
    throw qerr::Error({{"", 0, 0}, "", nothing ? "a command is missing" : e.what(), "", help},
                      qerr::Trouble::usage);
  }
  for (const auto& [sub, action] : work)
    if (sub->parsed()) return action();
  return static_cast<int>(qerr::Trouble::usage);
}

int report(const std::string& text, qerr::Trouble trouble) {
  std::fprintf(stderr, "%s\n", text.c_str());
  return static_cast<int>(trouble);
}

}  // namespace

int main(int argc, char** argv) {
  set_signals();
  try {
    return run(argc, argv);
  } catch (const qerr::Error& e) {
    return report(e.what(), e.trouble());
  } catch (const qerr::ClosedPipe&) {
    return closed_pipe_code;
  } catch (const std::bad_alloc&) {
    return report("qerr: out of memory; take fewer configurations or a smaller input",
                  qerr::Trouble::internal);
  } catch (const std::exception& e) {
    return report(std::string("qerr: a fault of qerr itself: ") + e.what(), qerr::Trouble::internal);
  }
}
