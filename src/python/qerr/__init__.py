"""Encoder quantization error in robots: the commands of qerr as functions.

    import qerr
    r = qerr.analyze("arm.yaml", set={"encoders.*.bits": 17})
    r.figures      # a list of dicts with the columns of the CSV: pandas.DataFrame(r.figures)
    r.json         # the report of --format json, as a dict
    r.page         # the report of --format html, a text

Every option of the command line is an argument, with `_` for `-`: `qerr.check("arm.yaml", baseline="old.json")`.
A list repeats an option, a dict gives KEY=VALUE, True stands for an option without value. What the program
would refuse raises `qerr.Error`, with place and remedy; what it would warn of is a `qerr.Warning`.
"""
from __future__ import annotations

import builtins
import csv
import datetime
import inspect
import io
import json
import os
import pathlib
import tempfile
import warnings as _warnings
from typing import Any, Iterable, Mapping, Union

from . import _qerr

__version__: str = _qerr.version
Path = Union[str, "os.PathLike[str]"]
Log = Union[Path, Mapping[str, Any]]  # a pandas.DataFrame, too


class Error(Exception):
    """What the program refuses.

    faults: a list of dicts with file, line, column, key, rule, found, remedy; code: the exit code of the program.
    """

    faults: list[dict[str, Any]]
    code: int

    def __init__(self, text: str, faults: list[dict[str, Any]], code: int):
        super().__init__(text)
        self.faults, self.code = faults, code


class Warning(UserWarning):
    """What the program warns of."""


def _value(value: Any) -> str:
    # Numbers and arrays of NumPy, and paths, beside what JSON knows.
    return value if isinstance(value, str) else json.dumps(value, default=lambda v: v.tolist() if hasattr(v, "tolist") else os.fspath(v))


def _words(options: Mapping[str, Any], pairs: Iterable[str] = ()) -> list[str]:
    words: list[str] = []
    for name, value in options.items():
        option = "--" + name.replace("_", "-")
        if value is None or value is False:
            continue
        if value is True:
            words.append(option)
        elif name in pairs:
            words += [option, *(str(one) for one in value)]
        elif isinstance(value, Mapping):
            for key, one in value.items():
                words += [option, f"{key}={_value(one)}"]
        elif isinstance(value, Iterable) and not isinstance(value, (str, bytes)):
            for one in value:
                words += [option, os.fspath(one) if isinstance(one, os.PathLike) else str(one)]
        else:
            words += [option, os.fspath(value) if isinstance(value, os.PathLike) else str(value)]
    return words


def _path(value: Any) -> str:
    try:
        return os.fsdecode(value)
    except TypeError:
        raise TypeError(f"a file's path is wanted, found {type(value).__name__}; a spec is a YAML file (set={{...}} changes single "
                        "values), the arrays of a log are a dict of its columns") from None


def _column(name: Any, values: Any) -> tuple[str, Any]:
    """A column as the module reads it, with its name: calendar time as seconds after the first stamp, durations as
    seconds; what is masked or no time is nan. float64 is not copied.

    Raises TypeError where the values are no numbers, ValueError where they are no list of them."""
    import numpy

    if isinstance(values, (builtins.list, tuple)) and values and isinstance(values[0], (datetime.date, datetime.timedelta)):
        values = numpy.asarray(values, dtype="m8[ns]" if isinstance(values[0], datetime.timedelta) else "M8[ns]")
    masked, numbers = numpy.ma.getmaskarray(values) if isinstance(values, numpy.ma.MaskedArray) else False, numpy.ma.getdata(values)
    if numbers.ndim != 1:
        raise ValueError(f"column '{name}': one value per row is wanted, found an array of the shape {numbers.shape}; name each column")
    if numbers.dtype.kind in "mM":
        times = numpy.asarray(numbers, dtype=numbers.dtype.kind + "8[ns]")
        masked = masked | numpy.isnat(times)
        name = name.partition("[")[0].strip() + " [s]"
        if times.dtype.kind == "M" and not numpy.all(masked):
            times = times - times[~masked][0]
        numbers = times.astype("m8[ns]").astype(float) * 1e-9
    try:
        if not isinstance(name, str) or numbers.dtype.kind in "cUS":
            raise TypeError
        numbers = numpy.asarray(numbers, dtype=float)
    except (TypeError, ValueError):
        wanted = "numbers are wanted, found " + type(numbers[0]).__name__ if isinstance(name, str) else "a text is wanted as name"
        raise TypeError(f"column {name!r}: {wanted}") from None
    return name, numpy.where(masked, numpy.nan, numbers) if numpy.any(masked) else numbers


def _number(text: str) -> Any:
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            pass
    return text if text else None


class Report:
    """What a command found. Forms that were not computed at once are computed when they are read."""

    command: str
    code: int  #: 1: check found a requirement that is not met
    warnings: list[str]

    def __init__(self, command: str, words: list[str], formats: Iterable[str] = ("json", "csv"), quiet: bool = False,
                 log: Iterable[tuple[str, Any]] = (), columns: bool = False):
        self.command, self._words, self._log = command, words, [_column(name, values) for name, values in log]
        if columns:
            ran = _qerr.run([command, *words], [], [], True)
            self.columns: dict[str, Any] = ran.columns
        else:
            ran = self._run(formats)
        self.warnings, self.code = ran.warnings, ran.code
        if not quiet:
            for text in ran.warnings:
                _warnings.warn(text, Warning, stacklevel=4)

    def _run(self, formats: Iterable[str], *more: str) -> Any:
        ran = _qerr.run([self.command, *more, *self._words], builtins.list(formats), self._log)
        self._texts = {**getattr(self, "_texts", {}), **ran.reports}
        return ran

    def text(self, format: str = "table") -> str:
        """The report as the program prints it: table, csv, json, html (where the command has a page), md."""
        if format not in self._texts:
            self._run([format], *(["--format", format] if self.command != "list" else []))
        return self._texts[format]

    @property
    def json(self) -> dict[str, Any]:
        return json.loads(self.text("json"))

    @property
    def csv(self) -> str:
        return self.text("csv")

    @property
    def figures(self) -> list[dict[str, Any]]:
        """The rows of the CSV: numbers as int and float, empty cells as None."""
        rows = csv.DictReader(io.StringIO(self.csv))
        return [{name: _number(cell) for name, cell in row.items()} for row in rows]

    @property
    def page(self) -> str:
        return self.text("html")

    def __str__(self) -> str:
        return self.text("table")

    def _repr_html_(self) -> str:
        import html

        return "<pre>" + html.escape(str(self)) + "</pre>"


class _Written(Report):
    """Of a sweep, which writes its rows as it goes."""

    def _run(self, formats: Iterable[str], *more: str) -> Any:
        texts = getattr(self, "_texts", {})
        with tempfile.TemporaryDirectory() as folder:
            for form in formats:
                path = pathlib.Path(folder, "report." + {"table": "txt"}.get(form, form))
                ran = _qerr.run([self.command, "--format", form, "--output", str(path), *self._words], [])
                texts = {**texts, form: path.read_text(encoding="utf-8")}
        self._texts = texts
        return ran


def _report(command: str, paths: Iterable[Path], options: dict[str, Any], kind: type[Report] = Report, **more: Any) -> Report:
    quiet = bool(options.pop("quiet", False))
    known = {name: kind for name, kind, _ in _qerr.options(command)}
    unknown = [name for name in options if name not in known]
    if unknown:
        raise TypeError(f"qerr.{command}() has no argument '{unknown[0]}'; it has: {', '.join(sorted(known))}")
    pairs = [name for name, of in known.items() if of == "pair"]
    return kind(command, [*_words(options, pairs), "--", *(_path(p) for p in paths)], quiet=quiet, **more)


def _paths(given: Path | Iterable[Path]) -> list[Path]:
    return builtins.list(given) if isinstance(given, Iterable) and not isinstance(given, (str, bytes, Mapping)) else [given]


def analyze(spec: Path, *, set: Mapping[str, Any] | None = None, **options: Any) -> Report:
    """Errors of the tip over the configurations."""
    return _report("analyze", [spec], {"set": set, **options})


def check(spec: Path | Iterable[Path], *, set: Mapping[str, Any] | None = None, **options: Any) -> Report:
    """Whether the requirements of one spec or of several are met: `code` is 0 if all are."""
    return _report("check", _paths(spec), {"set": set, **options})


def compare(one: Path, other: Path, **options: Any) -> Report:
    """What differs between two specs or reports."""
    return _report("compare", [one, other], options)


def design(spec: Path, *, set: Mapping[str, Any] | None = None, **options: Any) -> Report:
    """The cheapest encoders, gears and filters that meet the requirements."""
    return _report("design", [spec], {"set": set, **options})


def filter(spec: Path, *, set: Mapping[str, Any] | None = None, **options: Any) -> Report:
    """Norms, delay and errors of the filters."""
    return _report("filter", [spec], {"set": set, **options})


def simulate(spec: Path, *, set: Mapping[str, Any] | None = None, **options: Any) -> Report:
    """Explicit quantizers along the motion. `log=FILE` writes a log; see also `simulated_log`."""
    return _report("simulate", [spec], {"set": set, **options})


def simulated_log(spec: Path, *, set: Mapping[str, Any] | None = None, **options: Any) -> dict[str, Any]:
    """The log of a simulation: NumPy arrays by the names of their columns."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "log.csv")
        _report("simulate", [spec], {"set": set, **options, "log": path}, formats=())
        return _qerr.columns(path)


def sweep(spec: Path, *, set: Mapping[str, Any] | None = None, **options: Any) -> Report:
    """The figures of every variant of the spec's sweep."""
    return _report("sweep", [spec], {"set": set, **options}, _Written, formats=("csv",))


def threshold(spec: Path | Iterable[Path], *, set: Mapping[str, Any] | None = None, **options: Any) -> Report:
    """The resolution at which the linearization remainder reaches the error."""
    return _report("threshold", _paths(spec), {"set": set, **options})


def robot(model: Path, **options: Any) -> Report:
    """What a URDF or the robot of a spec holds; `at={"q1": "30 deg"}` adds the pose of the tip."""
    if isinstance(options.get("at"), Mapping):
        options["at"] = [f"{joint}={_value(value)}" for joint, value in options["at"].items()]
    return _report("robot", [model], options)


def list(kind: str) -> Report:
    """The members of a family: effects, filters, encoders, quantities, units, ..."""
    return _report("list", [kind], {})


def diagnose(spec: Path, log: Log | Iterable[Path] | None = None, *, set: Mapping[str, Any] | None = None, **options: Any) -> Report:
    """Causes of the errors of a measured log: a file, several, or arrays by the names of their columns.

    Arrays of float64 are read where they are; nan is a missing value, a column of datetime64 the time.
    """
    options = {"set": set, **options}
    if hasattr(log, "items"):
        return _report("diagnose", [spec], options, log=log.items())
    return _report("diagnose", [spec, *([] if log is None else _paths(log))], options)


def configurations(spec: Path, *, set: Mapping[str, Any] | None = None, **options: Any) -> dict[str, Any]:
    """The errors at every configuration: NumPy arrays by the names of their columns."""
    return _report("analyze", [spec], {"set": set, **options}, formats=(), columns=True).columns


def schema() -> dict[str, Any]:
    """The JSON Schema of the spec."""
    return json.loads(_qerr.json_schema())


_TYPES = {"flag": "bool", "number": "float | str", "whole": "int", "text": "str | os.PathLike[str]", "optional": "bool | float | str",
          "pair": "tuple[float | str, float | str]", "repeat": "Path | Iterable[Path] | Mapping[str, Any]"}


def _describe(function: Any, command: str) -> None:
    """Gives a function the options of its command: in its signature, for editors, and in its docstring."""
    options = _qerr.options(command)
    signature = inspect.signature(function)
    own = [p for p in signature.parameters.values() if p.kind != inspect.Parameter.VAR_KEYWORD]
    more = [inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=_TYPES[kind] + " | None")
            for name, kind, _ in options if name not in signature.parameters and name not in ("help", "version")]
    function.__signature__ = signature.replace(parameters=own + more)
    function.__doc__ = (function.__doc__ or "") + "\n\nOptions:\n" + "\n".join(f"    {name}: {meaning}" for name, _, meaning in options)


for _function in (analyze, check, compare, design, diagnose, filter, robot, simulate, sweep, threshold):
    _describe(_function, _function.__name__)
_describe(simulated_log, "simulate")
_describe(configurations, "analyze")
