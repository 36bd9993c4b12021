#include "cli/command.hpp"
#include "cli/completion/scripts.hpp"
#include "cli/shared.hpp"

namespace qerr::cli {

namespace {

struct Shell {
  std::string_view name;
  std::string (*script)();
};

constexpr Shell shells[] = {{"bash", bash_completion}, {"zsh", zsh_completion}, {"fish", fish_completion}};

std::vector<std::string> shell_names() {
  std::vector<std::string> names;
  for (const Shell& shell : shells) names.emplace_back(shell.name);
  return names;
}

int run(const Values& v) {
  OutputFile out(v.text("output"));
  for (const Shell& shell : shells)
    if (shell.name == v.text("SHELL")) finish(out, shell.script());
  return 0;
}

}  // namespace

Command completion_command() {
  return {"completion",
          "The script that completes qerr's command lines in a shell",
          {{.name = "SHELL",
            .meaning = "bash, zsh or fish",
            .required = true,
            .choices = shell_names,
            .choice = "shell"},
           text_output_option(".bash .zsh .fish .sh .txt")},
          run,
          {{"source <(qerr completion bash)", "complete in this bash; zsh likewise"},
           {"qerr completion fish | source", "complete in this fish"}}};
}

}  // namespace qerr::cli
