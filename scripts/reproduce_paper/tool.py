"""Runs qerr and parses its output."""
import csv
import io
import json
import pathlib
import shlex
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]


class Qerr:
    """The program. `qerr("analyze", spec, set={...})` returns a command that is not yet executed."""

    def __init__(self, path):
        self.path = str(pathlib.Path(path).resolve())
        self.ran = []  # the commands that were executed, as one types them

    def __call__(self, command, *arguments, set=None):
        return Command(self, command, arguments, set or {})


class Command:
    """One command line. Paths of specs are relative to the project's root, the working folder."""

    def __init__(self, qerr, command, arguments, overrides):
        self._qerr = qerr
        self._words = [command, *map(str, arguments)]
        for key, value in overrides.items():
            self._words += ["--set", f"{key}={value}"]

    def __str__(self):
        return "qerr " + " ".join(shlex.quote(word) for word in self._words)

    def text(self, *more):
        """Standard output; an error of qerr ends the reproduction with qerr's message."""
        shown = " ".join([str(self), *(shlex.quote(pathlib.Path(word).name) for word in more)])
        if shown not in self._qerr.ran:
            self._qerr.ran.append(shown)
        done = subprocess.run(
            [self._qerr.path, *self._words, "-q", *more], cwd=ROOT, capture_output=True, text=True
        )
        if done.returncode != 0:
            sys.exit(f"reproduce_paper: {self} failed:\n{done.stderr.strip()}")
        return done.stdout

    def json(self):
        return json.loads(self.text("--format", "json"))

    def rows(self):
        """CSV as a list of dictionaries of texts."""
        return list(csv.DictReader(io.StringIO(self.text("--format", "csv"))))

    def file(self, option):
        """The CSV file that `option` (such as --log) writes, as a list of dictionaries of texts."""
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "out.csv"
            self.text(option, str(path))
            with path.open(newline="") as stream:
                return list(csv.DictReader(stream))


def write_csv(path, header, rows):
    """Writes a CSV file in SI units, with nine significant digits."""
    with path.open("w", newline="") as stream:
        out = csv.writer(stream)
        out.writerow(header)
        for row in rows:
            out.writerow([f"{cell:.9g}" if isinstance(cell, float) else cell for cell in row])


class Output:
    """The output folder. Plots are optional, since they need matplotlib."""

    def __init__(self, folder, draws):
        self.folder, self.draws = pathlib.Path(folder), draws
        self.folder.mkdir(parents=True, exist_ok=True)

    def __truediv__(self, name):
        return self.folder / name

    def draw(self, plot, *figures):
        if self.draws:
            plot(*figures, self.folder)
