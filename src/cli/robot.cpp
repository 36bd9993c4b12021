#include <cstdio>
#include <filesystem>

#include "cli/command.hpp"
#include "cli/shared.hpp"
#include "core/output_file.hpp"
#include "core/text.hpp"
#include "input/read_text.hpp"
#include "qerr/input/first_spec.hpp"
#include "qerr/input/read_urdf.hpp"
#include "qerr/report/robot_report.hpp"

namespace qerr::cli {

namespace {

namespace fs = std::filesystem;

bool one_file(const std::string& a, const std::string& b) {
  std::error_code none;
  return a != "-" && b != "-" &&
         (fs::equivalent(a, b, none) || fs::weakly_canonical(a, none) == fs::weakly_canonical(b, none));
}

/// A URDF from a pipe is kept beside the spec, which needs it: `arm.yaml` has `arm.stdin.urdf`.
std::string kept_urdf(const std::string& spec) {
  return fs::path(spec).replace_extension(".stdin.urdf").string();
}

/// Where a spec in the file `spec` finds the URDF. Symbolic links are resolved only where `..` would
/// otherwise lead elsewhere.
std::string relative_path(const std::string& urdf, const std::string& spec) {
  if (fs::path(urdf).is_absolute()) return urdf;
  fs::path folder = spec == "-" ? fs::path() : fs::path(spec).parent_path();
  if (folder.empty()) folder = ".";
  const fs::path plain =
      fs::absolute(urdf).lexically_normal().lexically_proximate(fs::absolute(folder).lexically_normal());
  std::error_code none;
  if (fs::equivalent(folder / plain, urdf, none)) return plain.string();
  return fs::weakly_canonical(urdf).lexically_proximate(fs::weakly_canonical(folder)).string();
}

void check_files(const Values& v) {
  const std::string &urdf = v.text("URDF"), &spec = v.text("write-spec"), &output = v.text("output");
  if (spec == "-" && urdf == "-")
    throw usage("--write-spec", "a URDF from standard input is kept beside the spec, which then needs a file",
                "", "give it a name, e.g. --write-spec spec.yaml");
  if (spec == "-" && output == "-")
    throw usage("--write-spec", "spec and report cannot both go to standard output", "",
                "add -o FILE for the report");
  for (const std::string& written : {spec, output})
    if (!written.empty() && one_file(written, urdf))
      throw usage(written == spec ? "--write-spec" : "-o", "the output would overwrite the URDF",
                  quoted(urdf), "give the output another name");
  if (!spec.empty() && (one_file(spec, output) || (urdf == "-" && one_file(kept_urdf(spec), output))))
    throw usage("--write-spec", "spec and report must be two files", quoted(spec), "give one another name");
}

void write_file(const std::string& path, const std::string& text) {
  OutputFile file(path);
  file.write(text);
  file.close();
}

void write_spec(const RobotReport& report, const std::string& text, const Values& v) {
  const std::string& spec = v.text("write-spec");
  const Chain chain = first_chain(report.robot, v.text("base"), v.text("tip"));
  std::string urdf = v.text("URDF");
  if (urdf == "-") {
    urdf = kept_urdf(spec);
    write_file(urdf, text);
    if (!v.given("quiet"))
      std::fprintf(stderr, "the URDF from standard input is kept in %s, which the spec names\n",
                   escaped(urdf).c_str());
  }
  write_file(spec, first_spec(report.robot, chain, relative_path(urdf, spec)));
}

int run(const Values& v) {
  check_files(v);
  const std::string& path = v.text("URDF");
  const std::string text = read_text(path);
  RobotReport report = robot_report(parse_urdf(text, path == "-" ? "(standard input)" : path), text,
                                    v.text("base"), v.text("tip"));
  if (v.given("write-spec")) {
    write_spec(report, text, v);
    report.spec_file = v.text("write-spec");
  }
  OutputFile out(v.text("output"));
  finish(out, report, v);
  return 0;
}

}  // namespace

Command robot_command() {
  return {
      "robot", "What a URDF holds: tree, joints, limits, ratios, possible tips; writes a first spec",
      joined({{{.name = "URDF",
                .meaning = "the URDF; '-' reads standard input (xacro FILE | qerr robot -)",
                .required = true},
               {.name = "--base", .value = "LINK", .meaning = "base of the first spec (default: the root)"},
               {.name = "--tip", .value = "LINK", .meaning = "its tip (default: the first of the ends)"},
               {.name = "--write-spec",
                .value = "FILE",
                .meaning = "write a commented spec that can be analyzed as it is; '-' is standard output"}},
              output_options()}),
      run};
}

}  // namespace qerr::cli
