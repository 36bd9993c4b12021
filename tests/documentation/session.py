"""Runs the blocks of a document, one after the other, in a copy of the project.

    sh              commands, run as written in the root; each must succeed
    (no language)   what the block above prints on standard output; a line `...` stands for lines left out
    yaml            what the paragraph above says: "save ... as `FILE`", "append to `FILE`", "an excerpt of `FILE`"
    python          run in the root
    gnuplot         the same, where gnuplot is installed
    cpp             a file of tests/documentation, which acceptance.package compiles and runs
    text, cmake     not run: their figures are checked like those of the text

Excepted are, by the rules below, commands that install packages or build, and workflows of GitHub, GitLab and pre-commit.
"""
import difflib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

BUILDS = re.compile(r"^(scripts/(run_example|run_tests|package)\.sh|cmake |colcon |sudo |docker |git clone )")  # run by continuous integration itself
WORKFLOW = re.compile(r"^(jobs|stages|repos):", re.M)  # tests/acceptance/check_ci.py parses and runs them
PLACES = [  # (what the paragraph says, how the block is used)
    (re.compile(r"save\b[^`]*`([^`]+)`", re.I), "save"),
    (re.compile(r"append\b[^`]*`([^`]+)`", re.I), "append"),
    (re.compile(r"excerpt of\s+`([^`]+)`", re.I), "excerpt"),
]
ELLIPSIS = "..."


class Fault(Exception):
    """A block that does not run, or does not belong where it stands."""


def excepted(block):
    if block.language == "sh":
        return all(BUILDS.match(line) for line in block.body.splitlines())
    return block.language == "yaml" and bool(WORKFLOW.search(block.body))


def checked_by_running(block):
    return block.language not in ("text", "cmake") and not excepted(block)


class Session:
    """The state of the copy after each block. What was run before is not run again."""

    def __init__(self, root, qerr, keep_states):
        self._root, self._keep = root, keep_states
        self._scratch = tempfile.TemporaryDirectory()
        base = pathlib.Path(self._scratch.name)
        self._copy, self._states = base / "copy", {}
        (base / "bin").mkdir()
        (base / "bin" / "qerr").symlink_to(pathlib.Path(qerr).resolve())
        self._environment = {
            **os.environ,
            "PATH": f"{base / 'bin'}{os.pathsep}{os.environ['PATH']}",
            "PYTHONPATH": str(pathlib.Path(qerr).resolve().parent / "python"),
            "NO_COLOR": "1",
            "GNUTERM": "dumb",
            "LC_ALL": "C.UTF-8",
        }
        self._copy_root()
        self._of_root, self._read = self._stamps(), {}
        self._outputs, self._live = {}, ()
        self._store(())

    def output(self, history):
        """What the last of these blocks prints; the blocks before it were run already."""
        key = tuple((block.language, block.before, block.body) for block in history)
        if key not in self._outputs:
            if self._live != key[:-1]:
                self._restore(key[:-1])
            self._live = None
            self._outputs[key] = self._run(history[-1])
            self._live = key
            self._store(key)
        return self._outputs[key]

    def _copy_root(self):
        for folder in ("configs", "scripts"):
            shutil.copytree(self._root / folder, self._copy / folder, ignore=shutil.ignore_patterns("__pycache__"))

    def _stamps(self):
        """When each file of the copy was written, and its size."""
        files = (path for path in self._copy.rglob("*") if path.is_file())
        return {path: (path.stat().st_mtime_ns, path.stat().st_size) for path in files}

    def _store(self, key):
        """Keeps what differs from the root: contents of files, read once, and files that are gone."""
        if not self._keep:
            return
        now = self._stamps()
        changed = {path: stamp for path, stamp in now.items() if self._of_root.get(path) != stamp}
        self._read = {(path, stamp): self._read.get((path, stamp)) or path.read_bytes() for path, stamp in changed.items()}
        self._states[key] = {path: content for (path, _), content in self._read.items()}, set(self._of_root) - set(now)

    def _restore(self, key):
        contents, gone = self._states[key]
        shutil.rmtree(self._copy)
        self._copy_root()
        for path, content in contents.items():
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        for path in gone:
            path.unlink()

    def _run(self, block):
        if block.language == "sh":
            return self._execute(["bash", "-euo", "pipefail"], block)
        if block.language == "yaml":
            return self._place(block)
        if block.language == "python":
            for name in [*re.findall(r"^import (qerr)\b", block.body, re.M), *(["matplotlib"] if ".plot(" in block.body else [])]:
                if subprocess.run([sys.executable, "-c", f"import {name}"], env=self._environment, capture_output=True).returncode:
                    print(f"line {block.line}: not run, there is no module {name}", file=sys.stderr)
                    return ""
            return self._execute([sys.executable, "-"], block)
        if block.language == "gnuplot":
            if not shutil.which("gnuplot"):
                print(f"line {block.line}: not run, there is no gnuplot", file=sys.stderr)
                return ""
            return self._execute(["gnuplot"], block)
        if block.language == "cpp":
            if block.body not in {path.read_text() for path in (self._root / "tests/documentation").glob("*.cpp")}:
                raise Fault(f"line {block.line}: the program is no file of tests/documentation")
            return ""
        raise Fault(f"line {block.line}: nothing is known of blocks in '{block.language}'")

    def _execute(self, words, block):
        done = subprocess.run(
            words, input=block.body, cwd=self._copy, env=self._environment, capture_output=True, text=True
        )
        if done.returncode != 0:
            raise Fault(f"line {block.line}: exit code {done.returncode}: {done.stderr.strip()}")
        return re.sub(r"[ \t]+$", "", done.stdout, flags=re.M)

    def _place(self, block):
        for pattern, use in PLACES:
            match = pattern.search(block.before)
            if match is None:
                continue
            path = self._copy / match[1]
            if use == "excerpt":
                if block.body not in path.read_text():
                    raise Fault(f"line {block.line}: {match[1]} does not contain this excerpt")
            else:
                with path.open("w" if use == "save" else "a") as stream:
                    stream.write(block.body)
            return ""
        raise Fault(f"line {block.line}: the paragraph above does not say where this belongs")


def _likeness(shown, printed):
    def words(line):
        return re.sub(r"\d", "0", line)

    if shown == printed:
        return 2
    return difflib.SequenceMatcher(None, words(shown), words(printed), autojunk=False).ratio()


def renewed(shown, printed):
    """The block `shown` with the lines that `printed` has in their places."""
    if ELLIPSIS not in shown.splitlines():
        return printed
    lines = printed.splitlines()
    parts, part = [], []
    for line in shown.splitlines():
        if line == ELLIPSIS:
            parts.append(part)
            part = []
        else:
            part.append(line)
    parts.append(part)
    new, place = [], 0
    for number, part in enumerate(parts):
        if part:
            starts = range(place, len(lines) - len(part) + 1)
            if number == 0:
                starts = [0]
            elif number == len(parts) - 1:
                starts = [len(lines) - len(part)]
            best = max(starts, key=lambda s: sum(map(_likeness, part, lines[s:])), default=None)
            if best is None:
                return printed
            new += lines[best : best + len(part)]
            place = best + len(part)
        if number < len(parts) - 1:
            new.append(ELLIPSIS)
    return "\n".join(new) + "\n"


def outputs(text_blocks, session):
    """(block, what it should show) of every output block; raises Fault at the first block that does not run."""
    history, printed = [], None
    for block in text_blocks:
        if block.language in ("text", "cmake") or excepted(block):
            printed = None
        elif block.language:
            history.append(block)
            printed = session.output(history)
        elif printed is None:
            raise Fault(f"line {block.line}: no command above this output")
        else:
            yield block, renewed(block.body, printed)
