#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "cli/shared.hpp"
#include "core/lists.hpp"
#include "core/text.hpp"
#include "qerr/input/first_spec.hpp"
#include "qerr/report/robot_report.hpp"

namespace qerr::cli {

namespace {

namespace fs = std::filesystem;

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

void check_streams(const Values& v) {
  if (v.text("write-spec") == "-" && v.text("URDF") == "-")
    throw usage("--write-spec", "a URDF from standard input is kept beside the spec, which then needs a file",
                "", "give it a name, e.g. --write-spec spec.yaml");
}

/// The files that `--write-spec` asks for, opened before anything is written.
struct SpecFiles {
  std::unique_ptr<OutputFile> spec, urdf;  ///< urdf: of one from standard input
};

SpecFiles opened_files(const Values& v) {
  SpecFiles files{opened(v, "write-spec"), nullptr};
  if (files.spec && v.text("URDF") == "-")
    files.urdf = std::make_unique<OutputFile>(kept_urdf(v.text("write-spec")), "--write-spec");
  return files;
}

void write_spec(const RobotReport& report, const std::string& text, SpecFiles& files, const Values& v) {
  const std::string& spec = v.text("write-spec");
  const Chain chain = first_chain(report.robot, v.text("base"), v.text("tip"));
  const std::string urdf = files.urdf ? kept_urdf(spec) : v.text("URDF");
  if (spec == "-") warn(warnings_about(report.robot, chain), v);  // no report has them
  if (files.urdf) {
    finish(*files.urdf, text);
    if (!v.given("quiet"))
      std::fprintf(stderr, "the URDF from standard input is kept in %s, which the spec names\n",
                   escaped(urdf).c_str());
  }
  finish_spec(*files.spec, first_spec(report.robot, chain, relative_path(urdf, spec)), spec);
}

void check_links(const RobotModel& robot, const Values& v) {
  for (const char* option : {"base", "tip"}) {
    const std::string& link = v.text(option);
    if (link.empty() || contains(robot.links, link)) continue;
    throw Error({robot.file}, "--" + std::string(option), "no link of the URDF has this name", quoted(link),
                did_you_mean(link, robot.links));
  }
}

bool is_spec(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  return first != std::string::npos && text[first] != '<' && text.find("robot:") != std::string::npos;
}

RobotReport report_of_urdf(const std::string& text, const std::string& path, const Values& v) {
  const RobotModel robot = parse_urdf(text, path == "-" ? "(standard input)" : path);
  check_links(robot, v);
  RobotReport report = robot_report(robot, text, v.text("base"), v.text("tip"));
  if (v.given("at"))
    report.pose = pose_at(robot, first_chain(robot, v.text("base"), v.text("tip")), v.texts("at"));
  return report;
}

RobotReport report_of_spec(const std::string& text, const std::string& path, const Values& v) {
  for (const char* option : {"base", "tip", "write-spec"})
    if (v.given(option))
      throw usage("--" + std::string(option), "is for a URDF: a spec has its own base and tip", "",
                  "leave it out");
  RobotOfSpec of_spec = robot_of_spec(text, path);
  warn(of_spec.warnings, v);
  RobotReport report = robot_report(of_spec.robot, text, of_spec.chain.base, of_spec.chain.tip);
  if (v.given("at")) report.pose = pose_at(of_spec.robot, of_spec.chain, v.texts("at"));
  report.spec_file = path;
  report.of_spec = true;
  return report;
}

int run_robot(const Values& v) {
  check_streams(v);
  const std::string& path = v.text("URDF");
  const std::string text = urdf_text(path);
  RobotReport report = is_spec(text) ? report_of_spec(text, path, v) : report_of_urdf(text, path, v);
  if (report.pose) warn(report.pose->warnings, v);
  const auto out = opened_report(v, {"write-spec"});
  SpecFiles files = opened_files(v);
  Outputs outputs;
  if (files.spec) {
    outputs.write([&] { write_spec(report, text, files, v); });
    report.spec_file = v.text("write-spec");
  }
  if (out) outputs.write([&] { finish(*out, report, v); });
  outputs.finish();
  return 0;
}

}  // namespace

Command robot_command() {
  return {
      "robot",
      "What a URDF holds: tree, joints, limits, ratios, possible tips; the tip's pose; writes a first spec",
      joined({{valued("URDF", "", "the URDF, or a spec; '-' reads standard input (xacro FILE | qerr robot -)")
                   .must(),
               valued("--base", "LINK", "base of the first spec (default: the root)"),
               valued("--tip", "LINK", "its tip (default: the first of the ends)"),
               valued("--at", "JOINT=VALUE",
                      "the tip's pose at these joint values, such as q1=30deg,q2=0.1; other joints are at 0",
                      OptionKind::list),
               valued("--write-spec", "FILE",
                      "write a commented spec that can be analyzed as it is; '-' is standard output")},
              output_options_without_page()}),
      run_robot,
      {{"qerr robot arm.urdf", "what the URDF holds, and which tips make sense"},
       {"qerr robot arm.urdf --write-spec first.yaml", "and a commented spec that can be analyzed as it is"},
       {"qerr robot arm.yaml --at j1=30deg,j2=pi/2",
        "where the tip of a spec's robot is at these joint values"},
       {"cat arm.urdf | qerr robot - --write-spec piped.yaml",
        "the same from a pipe, such as that of xacro"}},
      {"urdf", "spec"}};
}

}  // namespace qerr::cli
