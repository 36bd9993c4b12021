#include "report/sweep/merge.hpp"

#include <algorithm>

#include "cli/command.hpp"
#include "cli/shared.hpp"
#include "core/run_files.hpp"

namespace qerr::cli {

namespace {

int run(const Values& v) {
  const std::vector<std::string>& files = v.texts("FILE");
  refuse_shared_input(files, "FILE");
  // An error leaves nothing on standard output: there the files are read once before, to check them.
  const bool pipes = std::find(files.begin(), files.end(), "-") != files.end();
  if (v.text("output") == "-" && !pipes) merge_shards(files, [](const std::string&) {});
  for (const std::string& file : files) note_input(file);
  OutputFile out(v.text("output"), "--output");
  merge_shards(files, [&](const std::string& text) { out.write(text); });
  out.close();
  return 0;
}

}  // namespace

Command merge_command() {
  return {"merge",
          "Join the files of the shards of a sweep: the bytes of one run",
          {{.name = "FILE",
            .kind = OptionKind::repeat,
            .meaning = "a file of each shard, in any order",
            .required = true},
           text_output_option()},
          run,
          {{"qerr merge 1.csv 2.csv 3.csv 4.csv 5.csv -o sweep.csv", "one file of all variants"},
           {"qerr merge shards/*.csv -o sweep.csv", "missing, doubled and torn shards are an error"}},
          {"variants"}};
}

}  // namespace qerr::cli
