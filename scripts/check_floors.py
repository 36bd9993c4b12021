#!/usr/bin/env python3
"""Checks the structure of qerr's sources: a module includes only modules on the floors below it, its folders do not
include each other in a circle, no type is defined twice, no call follows the locale, and the rows of a family are named
in its folder alone.

    check_floors.py [ROOT]       reads the #include lines of ROOT/include and ROOT/src (default: this project)
    check_floors.py --self-test  tests the check itself on a small tree

One line per fault, `FILE:LINE: what is wrong`, and exit code 1 when there is any. Standard library only.
"""
import pathlib
import re
import sys
import tempfile

# A module may include itself and modules on lower floors; those on one floor do not include each other.
FLOORS = {
    "core": 0, "lanes": 0,
    "encoder": 1, "kinematics": 1, "filter": 1,
    "effect": 2, "control": 2,
    "bound": 3, "simulate": 3,
    "diagnose": 4, "design": 4,
    "input": 5, "report": 5,
    "cli": 6, "python": 7,
}
# Exceptions, as (including module, included module): allowed on one floor; forbidden although it is a lower floor.
ALLOWED = {("lanes", "core"), ("report", "input"), ("simulate", "bound")}
FORBIDDEN = {("input", "diagnose")}

# Libraries that a single module names, in its own sources: public headers do not pass them on.
LIBRARIES = [
    (re.compile(r"yaml-cpp/"), "input"),
    (re.compile(r"urdf_\w+/|console_bridge/|tinyxml"), "input"),
    (re.compile(r"expat(_\w+)?\.h$"), "input"),
    (re.compile(r"(sqlite3|lz4(frame)?|zstd)\.h$"), "input"),
    (re.compile(r"nlohmann/"), "report"),
    (re.compile(r"CLI(/|11)"), "cli"),
]
# Functions whose result depends on the locale of the process: core/text and core/quantity write and read numbers.
LOCALE_DEPENDENT = re.compile(r"\b(?:v?s(?:n)?printf|sscanf|ato[fil]|strto[dfl]\w*|sto[dfil]|imbue)\(")
# Families whose members are files named after them: (folder, where no text may name a member).
EVERYWHERE = ("src/", "include/")
FAMILIES = [
    ("src/encoder/kinds", ("src/input", "include/qerr/input")),
    ("src/effect/effects", EVERYWHERE),
    ("src/filter/design/families", EVERYWHERE),
    ("src/filter/design/representations", EVERYWHERE),
    ("src/simulate/estimators", EVERYWHERE),
]
# Keys and figures that are spelt like a member of a family: (file, name) and what the name means there.
HOMONYMS = {
    ("src/input/spec_format.cpp", "frame"): "key of the spec",
    ("src/input/spec_format.cpp", "tool"): "key of the spec",
    ("src/input/spec_reader.cpp", "frame"): "key of the spec",
    ("src/input/spec_reader.cpp", "tool"): "key of the spec",
    ("src/report/schema.cpp", "tool"): "key of the spec",
    ("src/kinematics/tree.cpp", "tool"): "name of a link",
    ("src/report/analysis/json.cpp", "frame"): "member of a report",
    ("src/report/simulation/formats.cpp", "noise"): "member of a report",
    ("src/diagnose/inference/tip/tip.cpp", "frame"): "nuisances of the tip's fit",
    ("src/diagnose/inference/tip/tip.cpp", "tool"): "nuisances of the tip's fit",
    ("src/effect/effect.cpp", "noise"): "the shape of a residual",
    ("src/input/read_design.cpp", "resolution"): "minimize: resolution",
    ("src/encoder/kinds/lines_per_rev.cpp", "decoding"): "parameter of an encoder: x1, x2 or x4",
    ("src/input/spec_variants.cpp", "scale"): "spacing of a sweep: linear or log",
    ("src/input/spec_format.cpp", "scale"): "spacing of a sweep: linear or log",
    ("src/input/read_urdf.cpp", "offset"): "attribute of <mimic>",
    ("src/input/urdf_tree.cpp", "offset"): "attribute of <mimic>",
    ("src/input/urdf_reader.cpp", "offset"): "attribute of <mimic>",
    ("src/report/robot/robot_report.cpp", "offset"): "attribute of <mimic>",
    ("src/report/simulation/formats.cpp", "varying_jacobian"): "factor of a simulated error",
    ("src/report/simulation/formats.cpp", "correlated_joints"): "factor of a simulated error",
    ("src/report/filter/formats.cpp", "finite_difference"): "estimator of a velocity",
    ("src/cli/filter.cpp", "noise"): "option --noise: analysis of an input noise",
    ("src/cli/filter.cpp", "coefficients"): "option --coefficients: print them",
    ("src/input/read_filters.cpp", "first_order"): "example in a message",
}
UMBRELLA = "qerr/qerr.hpp"
INCLUDE = re.compile(r'^\s*#\s*include\s*(["<])([^">]+)[">]')
NAMESPACE = re.compile(r"^namespace ?([\w:]*) ?\{$")
TYPE = re.compile(r"^(?:template <.*> )?(?:struct|class|union|enum(?: class| struct)?) (?:\w+\([^)]*\) )?(\w+)(?: final)?"
                  r"(?: :(?!:).*)?(?: \{.*)?$")
SOURCES = {".hpp", ".cpp", ".h", ".cc", ".ipp"}


def module_of(path):
    """The module of a path relative to the root, such as `src/input/csv.cpp`; "" for the umbrella header."""
    parts = path.parts
    inside = parts[2:] if parts[:2] == ("include", "qerr") else parts[1:]
    return inside[0] if len(inside) > 1 else ""


def fault_between(user, used):
    """Why module `user` must not include module `used`; "" when it may."""
    if used not in FLOORS:
        return f"no such module: '{used}'"
    if (user, used) in FORBIDDEN:
        return f"{user} must not include {used}"
    if user == used or FLOORS[used] < FLOORS[user] or (user, used) in ALLOWED:
        return ""
    where = "the same floor" if FLOORS[used] == FLOORS[user] else "a higher floor"
    return f"{user} (floor {FLOORS[user]}) must not include {used} (floor {FLOORS[used]}), which is on {where}"


def fault_of(root, path, quote, name):
    """What is wrong with one #include in the file `path` (relative to the root); "" when nothing is."""
    user = module_of(path)
    if name.startswith("qerr/"):
        if not (root / "include" / name).is_file():
            return f"no such file: include/{name}"
        if name == UMBRELLA:
            return "the umbrella header is for users of the library; include what is needed"
        return fault_between(user, module_of(pathlib.Path("include", name))) if user else ""
    if quote == '"':
        if not (root / "src" / name).is_file():
            return f"no such file: src/{name}"
        if path.parts[0] == "include":
            return f"{name} is not public: a program that links qerr cannot include it"
        return fault_between(user, pathlib.Path(name).parts[0])
    for pattern, owner in LIBRARIES:
        if pattern.match(name) and path.parts[:2] != ("src", owner):
            return f"<{name}> is named in src/{owner} and nowhere else"
    return ""


def folders_of(path):
    """The folders of a source inside src/ or include/qerr/, its module first."""
    return path.parts[2 if path.parts[:2] == ("include", "qerr") else 1:-1]


def check_circles(includes):
    """One line per circle of folders that stand beside each other in a module; `includes` are (path, line, name).

    A folder and one inside it are no circle, nor are a module's own files and its folders: the inner one is a part.
    """
    uses = {}  # folder -> {folder beside it that it includes: where}
    for path, line, name in includes:
        user, used = folders_of(path), folders_of(pathlib.Path("include" if name.startswith("qerr/") else "src", name))
        depth = next((i for i, (a, b) in enumerate(zip(user, used)) if a != b), 0)
        if depth:
            uses.setdefault(user[:depth + 1], {}).setdefault(used[:depth + 1], f"{path}:{line}")
    faults, done = [], set()

    def follow(folder, trail):
        if folder in trail:
            circle = trail[trail.index(folder):] + [folder]
            faults.append(f"{uses[trail[-1]][folder]}: folders include each other: {' -> '.join(map('/'.join, circle))}")
        elif folder not in done:
            for used in sorted(uses.get(folder, ())):
                follow(used, trail + [folder])
            done.add(folder)

    for folder in sorted(uses):
        follow(folder, [])
    return faults


def types_defined(text):
    """(line, qualified name) of every type defined in a named namespace, in text as clang-format leaves it."""
    scopes = []
    for number, line in enumerate(text.splitlines(), 1):
        if opened := NAMESPACE.match(line):
            scopes.append(opened[1] or "")
        elif line.startswith("}  // namespace") and scopes:
            scopes.pop()
        elif (found := TYPE.match(line)) and "" not in scopes:
            yield number, "::".join(scopes + [found[1]])


def check_types(files):
    """One line per type that is defined more than once outside unnamed namespaces: an ODR violation.

    @param files  (path, text) of each
    """
    first, faults = {}, []
    for path, text in files:
        for number, name in types_defined(text):
            if name in first:
                faults.append(f"{path}:{number}: {name} is defined twice, also in {first[name]}")
            first.setdefault(name, f"{path}:{number}")
    return faults


def check_calls(files):
    """One line per call of a function that follows the locale; `files` are (path, text)."""
    return [f"{path}:{number}: {found[0]}) depends on the locale; use core/text or core/quantity"
            for path, text in files for number, line in enumerate(text.splitlines(), 1)
            if (found := LOCALE_DEPENDENT.search(line.split("//")[0]))]


def check_families(files):
    """One line per string that names a member of a family outside the family's folder; `files` are (path, text)."""
    files = [(path.as_posix(), text) for path, text in files]
    faults = []
    for folder, elsewhere in FAMILIES:
        rows = [(pathlib.Path(path).stem, text) for path, text in files if path.startswith(f"{folder}/")]
        members = sorted({stem for stem, text in rows if f'"{stem}"' in text})  # the others are helpers
        # A name that is also an English word counts only as a whole string.
        named = re.compile("|".join(rf'"(?:[^"]*\b)?({m})(?:\b[^"]*)?"' if "_" in m else rf'"({m})"' for m in members))
        for path, text in files:
            if not members or not path.startswith(elsewhere) or path.startswith(f"{folder}/"):
                continue
            for number, line in enumerate(text.splitlines(), 1):
                for found in [] if INCLUDE.match(line) else named.finditer(line.split("//")[0]):
                    if (path, next(m for m in found.groups() if m)) not in HOMONYMS:
                        faults.append(f"{path}:{number}: {found[0]} is named outside {folder}")
    return faults


def check(root):
    """All faults of a source tree, as lines of text."""
    root = pathlib.Path(root).resolve()
    faults = []
    umbrella = root / "include" / UMBRELLA
    shown = set()
    includes = []
    # src/precompiled.* belongs to the build of all modules, not to a module.
    files = sorted(p for top in ("include", "src") for p in (root / top).rglob("*")
                   if p.suffix in SOURCES and not (p.parent == root / "src" and p.stem == "precompiled"))
    if not files:
        faults.append(f"{root}:1: no sources found")
    for file in files:
        path = file.relative_to(root)
        module = module_of(path)
        if file != umbrella and module not in FLOORS:
            faults.append(f"{path}:1: '{module}' has no floor; give it one in scripts/check_floors.py")
            continue
        for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
            found = INCLUDE.match(line)
            if not found:
                continue
            if file == umbrella:
                shown.add(found[2])
            elif found[1] == '"' or found[2].startswith("qerr/"):
                includes.append((path, number, found[2]))
            fault = fault_of(root, path, found[1], found[2])
            if fault:
                faults.append(f"{path}:{number}: {fault}")
    texts = [(p.relative_to(root), p.read_text(encoding="utf-8")) for p in files]
    faults += check_circles(includes) + check_types(texts) + check_calls(texts) + check_families(texts)
    public = {p.relative_to(root / "include").as_posix() for p in files if p.is_relative_to(root / "include")}
    faults += [f"include/{UMBRELLA}:1: does not include {name}" for name in sorted(public - shown - {UMBRELLA})]
    return faults


def self_test():
    """Each file of a small tree, the text of its one include, and a word of the fault expected (None: no fault)."""
    cases = [
        ("include/qerr/core/a.hpp", "<vector>", None),
        ("include/qerr/encoder/a.hpp", '"qerr/core/a.hpp"', None),
        ("include/qerr/kinematics/a.hpp", '"qerr/core/a.hpp"', None),
        ("include/qerr/input/a.hpp", '"qerr/encoder/a.hpp"', None),
        ("include/qerr/report/a.hpp", '"qerr/input/a.hpp"', None),
        ("include/qerr/bound/a.hpp", "<nlohmann/json.hpp>", "src/report"),
        ("src/encoder/own.hpp", "<cmath>", None),
        ("src/encoder/kinds/a.cpp", '"encoder/own.hpp"', None),
        ("src/bound/b.cpp", '"encoder/own.hpp"', None),
        ("src/encoder/b.cpp", '"own.hpp"', "no such file"),
        ("src/kinematics/b.cpp", '"encoder/own.hpp"', "same floor"),
        ("include/qerr/bound/b.hpp", '"encoder/own.hpp"', "not public"),
        ("src/encoder/a.cpp", '"qerr/kinematics/a.hpp"', "same floor"),
        ("src/core/a.cpp", '"qerr/encoder/a.hpp"', "higher floor"),
        ("src/core/angle.cpp", "<qerr/encoder/a.hpp>", "higher floor"),
        ("src/input/a.cpp", '"qerr/report/a.hpp"', "same floor"),
        ("include/qerr/diagnose/a.hpp", "<cmath>", None),
        ("src/input/cause.cpp", '"qerr/diagnose/a.hpp"', "must not include"),
        ("src/input/yaml.cpp", "<yaml-cpp/yaml.h>", None),
        ("src/input/expat.cpp", "<expat.h>", None),
        ("src/report/a.cpp", "<yaml-cpp/yaml.h>", "src/input"),
        ("src/report/urdf.cpp", "<urdf_parser/urdf_parser.h>", "src/input"),
        ("src/report/json.cpp", "<nlohmann/json.hpp>", None),
        ("src/cli/json.cpp", "<nlohmann/json.hpp>", "src/report"),
        ("src/cli/a.cpp", "<CLI/CLI.hpp>", None),
        ("src/report/cli.cpp", "<CLI/CLI.hpp>", "src/cli"),
        ("src/cli/expat.cpp", "<expat.h>", "src/input"),
        ("include/qerr/input/expat.hpp", "<expat.h>", "src/input"),
        ("src/bound/gone.cpp", '"gone.hpp"', "no such file"),
        ("src/bound/umbrella.cpp", '"qerr/qerr.hpp"', "umbrella"),
        ("src/attic/a.cpp", "<cmath>", "has no floor"),
    ]
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        for name, include, _ in cases:
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            (root / name).write_text(f"// head\n#  include {include}\n// #include <expat.h>\n", encoding="utf-8")
        public = [name.removeprefix("include/") for name, _, _ in cases if name.startswith("include/")]
        forgotten = public.pop()
        umbrella = root / "include" / UMBRELLA
        umbrella.write_text("".join(f'#include "{name}"\n' for name in public), encoding="utf-8")
        faults = check(root)
    wrong = []
    for name, include, word in cases:
        of_file = [f for f in faults if f.startswith(f"{name}:")]
        expected = [] if word is None else [word]
        line = 1 if word == "has no floor" else 2
        if len(of_file) != len(expected) or any(
                w not in f or not f.startswith(f"{name}:{line}: ") for w, f in zip(expected, of_file)):
            wrong.append(f"{name} with {include}: expected {expected}, got {of_file}")
    if f"include/{UMBRELLA}:1: does not include {forgotten}" not in faults:
        wrong.append(f"the umbrella header without {forgotten}: no fault")
    if len(faults) != sum(word is not None for _, _, word in cases) + 1:
        wrong.append(f"unexpected faults among {faults}")
    return [f"self-test: {w}" for w in wrong + self_test_of_circles() + self_test_of_types() + self_test_of_texts()]


def self_test_of_circles():
    """Files that include one another, and the folders of the circles that they form."""
    cases = [
        ([("src/a/x/f.cpp", "a/y/f.hpp"), ("src/a/y/f.hpp", "a/x/g.hpp")], ["a/x -> a/y -> a/x"]),
        ([("src/a/x/f.cpp", "a/y/f.hpp"), ("src/a/y/f.hpp", "a/z/g.hpp"), ("src/a/z/g.hpp", "a/x/g.hpp")],
         ["a/x -> a/y -> a/z -> a/x"]),
        ([("src/a/x/in/f.cpp", "a/y/f.hpp"), ("src/a/y/f.hpp", "a/x/g.hpp")], ["a/x -> a/y -> a/x"]),
        ([("src/a/x/u/f.cpp", "a/x/v/f.hpp"), ("src/a/x/v/f.cpp", "a/x/u/f.hpp")], ["a/x/u -> a/x/v -> a/x/u"]),
        ([("src/a/x/f.cpp", "a/y/f.hpp"), ("src/a/x/f.cpp", "a/z/f.hpp"), ("src/a/y/f.hpp", "a/z/f.hpp")], []),
        ([("src/a/x/f.cpp", "a/x/in/f.hpp"), ("src/a/x/in/f.hpp", "a/x/g.hpp")], []),
        ([("src/a/x/f.cpp", "qerr/a/f.hpp"), ("src/a/f.cpp", "a/x/f.hpp")], []),
        ([("src/a/x/f.cpp", "b/x/f.hpp"), ("src/b/x/f.cpp", "a/x/f.hpp")], []),
    ]
    wrong = []
    for includes, expected in cases:
        faults = check_circles([(pathlib.Path(path), 1, name) for path, name in includes])
        if [f.split("each other: ")[-1] for f in faults] != expected:
            wrong.append(f"{includes}: expected {expected}, got {faults}")
    return wrong


def self_test_of_types():
    """The types of small files that are reported as defined twice."""
    def in_qerr(text):
        return f"namespace qerr {{\n\n{text}\n\n}}  // namespace qerr\n"
    cases = [
        ("struct A {};", "struct A {\n};", ["b.hpp:3: qerr::A is defined twice, also in a.hpp:3"]),
        ("struct A {};", "enum class A { x };", ["b.hpp:3: qerr::A is defined twice, also in a.hpp:3"]),
        ("class A : public B {\n};", "struct alignas(64) A {\n};",
         ["b.hpp:3: qerr::A is defined twice, also in a.hpp:3"]),
        ("template <class T>\nstruct A {\n};", "template <class T>\nstruct A {\n};",
         ["b.hpp:4: qerr::A is defined twice, also in a.hpp:4"]),
        ("struct A {};", "struct A;", []),
        ("struct A {};", "struct B {\n  struct A {};\n};", []),
        ("struct A {};", "struct B::A {\n};", []),
        ("struct A {};", "namespace {\n\nstruct A {};\n\n}  // namespace", []),
        ("struct A {};", "namespace lanes {\nstruct A {};\n}  // namespace lanes", []),
        ("namespace {\n}  // namespace\nstruct A {};", "struct A {};",
         ["b.hpp:3: qerr::A is defined twice, also in a.hpp:5"]),
    ]
    wrong = []
    for one, other, expected in cases:
        faults = check_types([("a.hpp", in_qerr(one)), ("b.hpp", in_qerr(other))])
        if faults != expected:
            wrong.append(f"{one!r} and {other!r}: expected {expected}, got {faults}")
    return wrong


def self_test_of_texts():
    """Calls that follow the locale, and members of a family that are named elsewhere."""
    path = pathlib.Path
    calls = [("std::snprintf(text, 8, \"%g\", x);", 1), ("std::fprintf(stderr, text);", 0), ("// atof(x)", 0),
             ("y = std::stod(x);", 1), ("put(std::atof(x));", 1), ("fast_atof(x);", 0)]
    names = [('if (kind == "bits") {', 1), ('"give 12 bits, please"', 0), ('"or x_bits: 12"', 1), ('"bitset"', 0), ("int bits = 3;", 0)]
    wrong = [f"{line!r}: expected {expected} faults" for line, expected in calls
             if len(check_calls([(path("src/core/a.cpp"), line)])) != expected]
    members = [(path(f"src/encoder/kinds/{m}.cpp"), f'"{m}"') for m in ("bits", "x_bits")]
    wrong += [f"{line!r}: expected {expected} faults" for line, expected in names
              if len(check_families(members + [(path("src/input/a.cpp"), line)])) != expected]
    effects = [(path("src/effect/effects/noise.cpp"), '.name = "noise"'), (path("src/effect/effects/scale.cpp"), '"scale"'),
               (path("src/effect/effects/periodic.cpp"), "// a helper, not a row")]
    named = [("src/report/a.cpp", 'e.type == "noise"', 1), ("src/report/a.cpp", 'pair("noise", "scale")', 2),
             ("include/qerr/bound/a.hpp", 'x = "scale"', 1), ("src/input/spec_variants.cpp", 'o.choice("scale")', 0),
             ("src/input/spec_variants.cpp", 'o.choice("noise")', 1), ("src/effect/effects/drift.cpp", '"noise"', 0),
             ("src/report/a.cpp", '"white noise"; "periodic"', 0), ("src/report/a.cpp", '#include "noise"', 0)]
    return wrong + [f"{file}: {line!r}: expected {expected} faults" for file, line, expected in named
                    if len(check_families(effects + [(path(file), line)])) != expected]


def main(arguments):
    if arguments[:1] == ["--self-test"] and len(arguments) == 1:
        faults = self_test()
    elif len(arguments) <= 1 and not arguments[:1] == ["--help"]:
        faults = check(arguments[0] if arguments else pathlib.Path(__file__).resolve().parents[1])
    else:
        print(__doc__.strip())
        return 2
    for fault in faults:
        print(fault, file=sys.stderr)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
