#!/usr/bin/env python3
"""Mutation test: changes one operator, constant or condition at a time, and looks whether a test fails.

    mutate.py [--count 500] [--seed 1] [--folder src/bound ...] [--then REGEX] [--at-least PERCENT]
              [--skip N] [--list]

Mutants are drawn by the seed from all places of the folders. They are made in a copy of the sources in build-mutation/,
which is compiled once; each mutant compiles what it changes. A mutant is killed by a failed, crashed or endless unit test:
first those that include its header, then those of its module, then, of the others in --tests, those of modules above
it. With --then, survivors also meet the tests of ctest that match REGEX, such as 'acceptance|hidden'. Mutants that do
not compile are replaced by others.
A 0 with which a member of a struct begins is not changed: most are overwritten before they are read, which no test can
see. Properties draw the same cases for every mutant.
--skip goes on after a run that was stopped.

Prints one line a mutant, then the survivors (FILE:LINE, change) and the share that was killed. The exit code is 1 if it
is below --at-least.
"""
import argparse
import json
import os
import pathlib
import random
import re
import resource
import shutil
import signal
import subprocess
import sys

from check_floors import ALLOWED, FLOORS

ROOT = pathlib.Path(__file__).resolve().parents[1]
WORK = ROOT / "build-mutation"
TREE, BUILD = WORK / "tree", WORK / "build"
FOLDERS = ["src/bound", "src/filter", "src/diagnose/inference"]
TESTS = ["bound", "filter", "diagnose"]

# clang-format writes spaces around binary operators only, so that ` < ` is no template and ` * ` no pointer.
SWAPS = {
    " < ": [" <= ", " > "], " <= ": [" < "], " > ": [" >= ", " < "], " >= ": [" > "], " == ": [" != "], " != ": [" == "],
    " + ": [" - "], " - ": [" + "], " * ": [" / "], " / ": [" * "], " += ": [" -= "], " -= ": [" += "],
    " *= ": [" /= "], " && ": [" || "], " || ": [" && "], "std::min(": ["std::max("], "std::max(": ["std::min("],
    "true": ["false"], "false": ["true"],
}
SWAP = re.compile("|".join(rf"\b{k}\b" if k.isalpha() else re.escape(k) for k in sorted(SWAPS, key=len, reverse=True)))
NUMBER = re.compile(r"(?<![\w.'])\d+(?:\.\d*)?(?:e[-+]?\d+)?(?![\w.'])")
CONDITION = re.compile(r"\b(?:if|while) (?:constexpr )?\(")
NOT_CODE = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\'|^#[^\n]*|\bstatic_assert\([^;]*;|'
                      r"\btemplate <[^\n]*", re.M | re.S)


def blanked(text):
    """The text with spaces for comments, strings and what the preprocessor reads; places stay the same."""
    return NOT_CODE.sub(lambda m: re.sub(r"[^\n]", " ", m[0]), text)


def closing(text, start):
    """The place behind the bracket that closes the one before `start`."""
    depth = 1
    for at in range(start, len(text)):
        depth += (text[at] == "(") - (text[at] == ")")
        if depth == 0:
            return at
    return -1


def changed_number(word):
    """A whole number below ten one larger; 0 in place of 1.0, and 1 in place of all else (after PIT's "inline constant").

    Nobody could see 41 steps of a search in place of 40. Below ten, one more is a dimension, an order or an index too many."""
    if word.isdigit():
        return str(int(word) + 1) if int(word) < 10 else "1"
    return "0.0" if float(word) == 1 else "1.0"


def zero_members(code):
    """The places of the 0 behind the names of members: within the braces of a struct, and of nothing inside."""
    places, open_structs, start = set(), [], 0
    for m in re.finditer(r"[{};]|(?<= = )0(?![\w.'])", code):
        statement = code[start:m.start()]
        if m[0] == "0":
            if open_structs and open_structs[-1] and not re.search(r"\(|\bstatic\b", statement):
                places.add(m.start())
            continue
        if m[0] == "{":
            open_structs.append(bool(re.search(r"\bstruct\b", statement)) and "(" not in statement)
        elif m[0] == "}" and open_structs:
            open_structs.pop()
        start = m.end()
    return places


def mutations(text):
    """[(start, end, replacement)] of one source."""
    code, found = blanked(text), []
    kept = zero_members(code)
    for m in SWAP.finditer(code):
        found += [(m.start(), m.end(), other) for other in SWAPS[m[0]]]
    found += [(m.start(), m.end(), changed_number(m[0])) for m in NUMBER.finditer(code)]
    for m in CONDITION.finditer(code):
        end = closing(code, m.end())
        if end > 0 and "constexpr" not in m[0] and ";" not in code[m.end():end]:
            found.append((m.end(), end, f"!({text[m.end():end]})"))
    return [change for change in found if change[0] not in kept]


def line_of(text, start, end):
    """The number of the line, and the line before the change."""
    first = text.rfind("\n", 0, start) + 1
    last = text.find("\n", end)
    return text.count("\n", 0, start) + 1, first, last if last >= 0 else len(text)


def call(words, limit=None):
    """Exit code, or "timeout", and the output. A mutant may ask for endless memory, too: 4 GB must do."""
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, cwd=WORK, text=True, errors="replace",
                               env={**os.environ, "RC_PARAMS": "seed=1"},
                               start_new_session=True, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30)))
    try:
        output, _ = process.communicate(timeout=limit)
        return process.returncode, output
    except BaseException as stopped:  # an interrupt, too: it does not reach the new session
        os.killpg(process.pid, signal.SIGKILL)  # with the compilers of a build, which hold the pipe open
        process.communicate()
        if isinstance(stopped, subprocess.TimeoutExpired):
            return "timeout", ""
        raise


def must(words, purpose):
    code, output = call(words)
    if code != 0:
        sys.exit(f"mutate: {purpose} failed:\n{output[-3000:]}")


def prepare(modules, tests):
    """A copy of the sources, compiled: every file that changes by itself, so that a mutant compiles one file.

    With the assertions of Eigen and the standard library: an index out of range fails, whatever stands there."""
    WORK.mkdir(exist_ok=True)
    for name in ("CMakeLists.txt", "src", "include", "tests", "configs", "scripts", "README.md", "LICENSE"):
        source, copy = ROOT / name, TREE / name
        if source.is_dir():
            for path in source.rglob("*"):
                if path.is_file() and "__pycache__" not in path.parts:
                    copy_if_changed(path, TREE / path.relative_to(ROOT))
        else:
            copy_if_changed(source, copy)
    for path in [p for top in ("src", "include", "tests") for p in (TREE / top).rglob("*")]:
        if path.is_file() and not (ROOT / path.relative_to(TREE)).exists():
            path.unlink()
    files = ";".join(f"{name}/*_test.cpp" for name in tests)
    must(["cmake", "-S", TREE, "-B", BUILD, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
          "-DCMAKE_CXX_FLAGS_RELEASE=-O2 -D_GLIBCXX_ASSERTIONS", "-DQERR_TESTS=ON", "-DQERR_UNITY=ON",
          f"-DQERR_SINGLE={';'.join(sorted(modules))};tests", f"-DQERR_TEST_FILES={files}"], "configuring")
    print("mutate: building, which takes minutes the first time", file=sys.stderr)
    must(["cmake", "--build", BUILD, "--target", "qerr_tests"], "the build")


def copy_if_changed(source, copy):
    copy.parent.mkdir(parents=True, exist_ok=True)
    if not copy.exists() or copy.read_bytes() != source.read_bytes():
        shutil.copyfile(source, copy)


def suites(files):
    """The names of the suites of test files."""
    text = "\n".join(path.read_text() for path in files)
    return set(re.findall(r"\b(?:TEST|TEST_F|TEST_P|RC_GTEST_PROP)\((\w+)", text))


def test_files(folder):
    return sorted((ROOT / "tests" / folder).glob("*_test.cpp"))


def run_tests(names, limit, *options):
    """Exit code and output of some tests, which stop at the first failure."""
    listed = WORK / "tests.txt"  # a filter of many names may be too long for a command line
    listed.write_text("--gtest_filter=" + ":".join(names) + "\n")
    return call([BUILD / "tests" / "qerr_tests", "--gtest_fail_fast", "--gtest_brief=1", f"--gtest_flagfile={listed}", *options], limit)


def durations(tests):
    """Seconds of each test of the folders, without a change."""
    report = WORK / "durations.json"
    patterns = [f"{start}{suite}.*" for folder in tests for suite in suites(test_files(folder)) for start in ("", "*/")]
    code, output = run_tests(patterns, None, f"--gtest_output=json:{report}")
    if code != 0:
        sys.exit(f"mutate: tests fail without any change:\n{output[-3000:]}")
    return {f"{suite['name']}.{test['name']}": float(test["time"].rstrip("s"))
            for suite in json.loads(report.read_text())["testsuites"] for test in suite["testsuite"]}


def stages(path, tests, seconds):
    """Lists of tests that a mutant meets in turn: of its header, of its module, of those above; quick ones first."""
    module, header = path.parts[1], f"/{path.stem}.hpp\""
    own = test_files(module) if module in tests else []
    nearest = [file for file in own if header in file.read_text()]
    above = [file for name in tests if FLOORS[name] > FLOORS[module] or (name, module) in ALLOWED for file in test_files(name)]
    met = set()
    for files, quick in ((nearest, True), (own, True), (nearest, False), (own, False), (above, True), (above, False)):
        wanted = suites(files)
        names = [name for name, taken in seconds.items()
                 if name not in met and name.split(".")[0].split("/")[-1] in wanted and (taken < 0.3 or not quick)]
        met.update(names)
        if names:
            yield names


def outcome(path, given, seconds):
    """invalid, the test stage that killed the mutant, or survived."""
    if call(["cmake", "--build", BUILD, "--target", "qerr_tests"], 600)[0] != 0:
        return "invalid"
    for names in stages(path, given.tests, seconds):
        # A mutant may be slow without being endless.
        code, _ = run_tests(names, 10 + 10 * sum(seconds[name] for name in names))
        if code != 0:
            return "killed (endless)" if code == "timeout" else "killed"
    if given.then:
        if call(["cmake", "--build", BUILD], 1200)[0] != 0:
            return "invalid"
        if call(["ctest", "--test-dir", BUILD, "-R", given.then, "--stop-on-failure"], 1200)[0] != 0:
            return "killed (by a script)"
    return "survived"


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=500, help="mutants that compile (default 500)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folder", action="append", help=f"default: {', '.join(FOLDERS)}")
    parser.add_argument("--tests", nargs="+", default=TESTS, help=f"folders of tests/ to compile; default: {' '.join(TESTS)}")
    parser.add_argument("--then", default="", help="tests of ctest (regular expression) that survivors meet, too")
    parser.add_argument("--at-least", type=float, default=0, help="exit code 1 if less of them are killed [%%]")
    parser.add_argument("--skip", type=int, default=0, help="leave out the first N that are drawn, compiled or not")
    parser.add_argument("--list", action="store_true", help="print the drawn mutants only")
    return parser.parse_args()


def main():
    given = arguments()
    sources = sorted(path for folder in given.folder or FOLDERS for path in (ROOT / folder).rglob("*.[ch]pp"))
    texts = {path: path.read_text() for path in sources}
    drawn = [(path, *change) for path in sources for change in mutations(texts[path])]
    print(f"mutate: {len(drawn)} places in {len(sources)} files, seed {given.seed}", file=sys.stderr)
    random.Random(given.seed).shuffle(drawn)
    if not given.list:
        prepare({path.relative_to(ROOT).parts[1] for path in sources}, given.tests)
        seconds = durations(given.tests)
    counted, survivors, invalid = 0, [], 0
    for path, start, end, replacement in drawn[given.skip:]:
        if counted == given.count:
            break
        text, name = texts[path], path.relative_to(ROOT)
        mutant = text[:start] + replacement + text[end:]
        line, first, last = line_of(text, start, end)
        what = f"{name}:{line}: {text[first:last].strip()}  ->  {mutant[first:last + len(mutant) - len(text)].strip()}"
        if given.list:
            counted += 1
            print(what)
            continue
        copy = TREE / name
        try:
            copy.write_text(mutant)
            result = outcome(name, given, seconds)
        finally:
            copy.write_text(text)
        invalid += result == "invalid"
        counted += result != "invalid"
        survivors += [what] if result == "survived" else []
        print(f"{counted:4} {result:16} {what}", flush=True)
    if given.list:
        return 0
    print("\nSurvivors")
    for what in sorted(survivors):
        print(f"  {what}")
    percent = 100 * (counted - len(survivors)) / max(counted, 1)
    print(f"{counted - len(survivors)} of {counted} killed, {percent:.1f} %; {invalid} did not compile")
    return 1 if percent < given.at_least else 0


if __name__ == "__main__":
    sys.exit(main())
