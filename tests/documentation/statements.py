"""What the texts say in figures: the place of each figure, and its value as computed now.

STATEMENTS: (pattern with a group for every figure, function that returns the values of the groups). A blank matches any white space.
NAMES: names and formulas, which have no value to compute: they must stand in the text as they stand here.
"""
import json
import math
import os
import pathlib
import re
import runpy
import signal
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAPER = "configs/paper/README.md"
TOPICS = {path.stem: str(path.relative_to(ROOT)) for path in sorted((ROOT / "src/cli/topics").glob("*.md"))}
DOCUMENTS = ["README.md", ".github/CONTRIBUTING.md", *TOPICS.values(), PAPER]
ARM = "configs/kuka_lwr/spec.yaml"  # one encoder for all joints, gear ratio 1, 10000 configurations by default
EXPERIMENT = "configs/phantom_premium/experiment.yaml"


class Values:
    """Asks the program and the sources; every question once."""

    def __init__(self, root, qerr):
        self.root, self.qerr, self._known = root, qerr, {}

    def once(self, question, answer):
        if question not in self._known:
            self._known[question] = answer()
        return self._known[question]

    def run(self, *words):
        """Standard output and exit code."""

        def answer():
            done = subprocess.run([self.qerr, *words], cwd=self.root, capture_output=True, text=True)
            return done.stdout, done.returncode

        return self.once(words, answer)

    def printed(self, pattern, *words):
        return re.search(pattern, self.run(*words)[0]).groups()

    def json(self, *words):
        return json.loads(self.run(*words, "--format", "json")[0])

    def source(self, path, pattern):
        return re.search(pattern, (self.root / path).read_text(encoding="utf-8")).groups()

    def floors(self):
        return runpy.run_path(str(self.root / "scripts" / "check_floors.py"))["FLOORS"]


def _percent(fraction):
    return f"{100 * float(fraction):g}"


def points(v):
    done = v.json("analyze", "-q", ARM, "--set", "configurations={}")
    return (str(done["configurations"]["count"]),)


def counts(keys):
    """Counts per revolution of an encoder that is specified like this, beside a joint with gear ratio 1."""

    def value(v):
        report = v.json("analyze", "-q", ARM, "--set", f"encoders.*={{{keys}}}", "--set", "configurations.count=1")
        return (f"{2 * math.pi / report['joints'][0]['resolution']:.0f}",)

    return value


def decodings(v):
    """All decodings, the default last."""
    lines = "lines_per_rev: 1024"
    names = {counts(f"{lines}, decoding: {name}")(v): name for name in ("x1", "x2", "x4")}
    default = names.pop(counts(lines)(v))
    return (*names.values(), default)


def exit_code(*words):
    return lambda v: (str(v.run(*words)[1]),)


def unwritable(v):
    with tempfile.TemporaryDirectory() as folder:
        return (str(v.run("schema", "-o", str(pathlib.Path(folder) / "missing" / "x.json"))[1]),)


def floor(modules):
    return lambda v: (str({v.floors()[m] for m in modules.split()}.pop()),)


def statistics(v):
    names = [row.split()[0] for row in v.run("list", "statistics")[0].splitlines() if row and not row.startswith(" ")]
    return tuple(n for n in names if n in ("p95", "p99"))


def percent_names(v):
    """The two accuracies for which `--noise` gives speeds."""
    found = v.json("filter", "-q", ARM, "--noise")["filters"][0]
    return tuple(re.findall(r"ipqn_within_(\d+)_percent", " ".join(found)))


def percentiles_limit(v):
    (bits,) = v.source("include/qerr/bound/figure.hpp", r"exact_percentiles_limit = .*<< (\d+);")
    return (f"{2 ** int(bits):,}".replace(",", " "),)


def agreed_digits(v):
    """Of all figures of a robot, with the slowest and the fastest instruction set of this machine; 12 if it is more."""
    words = ("analyze", "-q", "configs/barrett_wam/spec.yaml", "--format", "csv")
    tables = []
    for name in ("portable", ""):
        environment = {**os.environ, "QERR_INSTRUCTION_SET": name} if name else None
        done = subprocess.run([v.qerr, *words], cwd=v.root, env=environment, capture_output=True, text=True, check=True)
        tables.append([float(row.rsplit(",", 1)[1]) for row in done.stdout.splitlines()[1:]])
    gap = max(abs(a - b) / max(abs(a), abs(b), 1e-300) for a, b in zip(*tables))
    return (str(min(12, math.floor(-math.log10(max(gap, 1e-16))))),)


def experiment(v):
    """Amplitude, frequency, rate, samples of a period, duration, whole periods, period, mean speed in counts per sample."""
    spec = (v.root / EXPERIMENT).read_text(encoding="utf-8")
    amplitude, frequency = re.search(r"amplitude: (\d+) deg, frequency: ([\d.]+) Hz", spec).groups()
    rate, duration = re.search(r"sample_rate: (\d+) kHz\n  duration: (\d+) s", spec).groups()
    samples = 1000 * int(rate) / float(frequency)
    step = float(re.search(r"resolution: (\d+) mrad", spec)[1]) * 1e-3
    peak = math.radians(float(amplitude)) * 2 * math.pi * float(frequency) / (1000 * int(rate)) / step
    periods, period = int(float(duration) * float(frequency)), 1 / float(frequency)
    return amplitude, frequency, rate, f"{samples:g}", duration, str(periods), f"{period:g}", f"{peak:.0f}"


def smallest_eccentricity(v):
    return v.printed(r"eccentricity \(joint\) +([\d.]+) \?", "diagnose", "configs/diagnosis/spec.yaml", "--plan")


def first_report(*columns):
    """Figures of the row of README.md's first report that its text explains: x of the position."""
    names = {"sigma": 0, "worst": 2, "max": 3}

    def value(v):
        readme = (v.root / "README.md").read_text(encoding="utf-8")
        unit, *row = re.search(r"^    x +([num]?m) +(.*)", readme, re.M)[0].split()[1:]
        return tuple(f"{row[names[column]]} {unit}" for column in columns)

    return value


def largest_share(v):
    readme = (v.root / "README.md").read_text(encoding="utf-8")
    return re.search(r"([\d.]+) % .*<- first", readme).groups()


def program_version(v):
    return v.printed(r"qerr (\S+)", "--version")


def repeatability_range(v):
    """RP = m + 3 S, with mean m and scatter S of a distance whose mean square m^2 + S^2 is 1: for any share of m."""
    values = [math.cos(a) + 3 * math.sin(a) for a in (math.pi / 2 * i / 10000 for i in range(10001))]
    return f"{min(values):.0f}", f"{max(values):.1f}"


def normal_repeatability(v):
    mean = math.sqrt(8 / (3 * math.pi))  # of the length of a normal vector in space whose mean square is 1
    return (f"{mean + 3 * math.sqrt(1 - mean**2):.1f}",)


def default_gap(v):
    return (_percent(v.source("include/qerr/report/analysis.hpp", r"double gap = (\S+);")[0]),)


def search_starts(v):
    blocks, block = v.source("src/bound/proven/ascent.cpp", r"blocks = (\d+), block = (\d+);")
    return (f"{int(blocks) * int(block):,}".replace(",", " "),)


def rates_of_table_3(v):
    return v.source("scripts/reproduce_paper/tables.py", r"spaced\((\d+), \d+, \d+\) \+ spaced\(\d+, (\d+)e6, \d+\)")


HISTOGRAM = "src/bound/histogram.hpp"
STATEMENTS = {
    "README.md": [
        (r"actions/qerr@v([\d.]+),", program_version),
        (r"plain CMake \(C\+\+(\d+);", lambda v: v.source("CMakeLists.txt", r"CMAKE_CXX_STANDARD (\d+)")),
        (r"within ([\d.]+ \w+) of where the encoders say,", first_report("worst")),
        (r"at the worst of them ([\d.]+ \w+) off", first_report("max")),
        (r"Sigma, ([\d.]+ \w+) at half of them", first_report("sigma")),
        (r"causes ([\d.]+) % of the variance", largest_share),
        (r"exit code (\d) if all are met", exit_code("check", "-q", ARM)),
        (r"if all are met, (\d) if one is not", exit_code("check", "-q", ARM, "--set", "requirements.0.at_most=1 nm")),
    ],
    ".github/CONTRIBUTING.md": [
        *[
            (rf" (\d) +{re.sub(' ', '  ', modules)} ", floor(modules))
            for modules in (
                "core lanes",
                "encoder kinematics filter",
                "effect",
                "bound simulate",
                "design diagnose",
                "input report",
                "cli",
            )
        ],
        (r"a statistic \(median, (p\d+)\)", lambda v: (statistics(v)[-1],)),
    ],
    TOPICS["library"]: [
        (r"find_package\(qerr (\d+\.\d+)", lambda v: v.printed(r"qerr (\d+\.\d+)", "--version")),
        (r"cmake_minimum_required\(VERSION ([\d.]+)\)", lambda v: v.source("CMakeLists.txt", r"VERSION ([\d.]+)\)")),
        (r"and its `CMakeLists.txt`:\s+```cmake\s+cmake_minimum_required\(VERSION ([\d.]+)\)",
         lambda v: v.source("CMakeLists.txt", r"VERSION ([\d.]+)\)")),
        (r"c\+\+ -std=c\+\+(\d+)", lambda v: v.source("CMakeLists.txt", r"CMAKE_CXX_STANDARD (\d+)")),
    ],
    TOPICS["changes"]: [
        (r"## Version (\S+)", program_version),
        (r"version = \{([\d.]+)\}", program_version),
    ],
    TOPICS["ci"]: [
        (r"ends with (\d) if all requirements are met", exit_code("check", "-q", ARM)),
        (r"requirements are met, with (\d) if one is not", exit_code("check", "-q", ARM, "--set", "requirements.0.at_most=1 nm")),
        (r"actions/qerr@v([\d.]+)", program_version),
        (r"QERR_VERSION: (\S+)", program_version),
        (r"rev: v(\S+)", program_version),
    ],
    TOPICS["glossary"]: [
        (r"With it alone RP lies between (\d) and ([\d.]+) times this sigma", repeatability_range),
        (r"it is ([\d.]+) times sigma where the scatter is normal", normal_repeatability),
        (r"stays within (\d) % of its end", lambda v: v.source("src/design/filter_choice.cpp", r"stays within (\d) %")),
    ],
    TOPICS["spec"]: [(r"sampled by (\d+) Sobol points", points)],
    TOPICS["encoders"]: [
        (r"`counts_per_rev: 4096` \|[^|]*\| (\d+) \|", counts("counts_per_rev: 4096")),
        (r"`lines_per_rev: 1024, decoding: x4` \|[^|]*\| (\d+) \|", counts("lines_per_rev: 1024, decoding: x4")),
        (r"incremental; `(x\d)`, `(x\d)`, `(x\d)` \(default\)", decodings),
        (r"`bits: 17` \|[^|]*\| (\d+) \|", counts("bits: 17")),
        (
            r"`periods_per_rev: 512, interpolation_bits: 10` \|[^|]*\| (\d+) \|",
            counts("periods_per_rev: 512, interpolation_bits: 10"),
        ),
        (r"`resolution: 0\.125 mrad` \|[^|]*\| (\d+) \|", counts("resolution: 0.125 mrad")),
        (
            r"per joint revolution \(default (\d+)\)",
            lambda v: v.printed(r'(?s)"gear_ratio".*?"default": (\d+)\.0', "schema"),
        ),
    ],
    TOPICS["motion"]: [
        (
            r"for less than (\d+) of them, up to (\d+) other runs",
            lambda v: v.source("src/simulate/simulate.cpp", r"enough = (\d+), most = (\d+),"),
        ),
    ],
    TOPICS["filters"]: [(r"accurate to (\d+) % and (\d+) %, and `--speed`", percent_names)],
    TOPICS["figures"]: [
        (r"\(median, (p\d+), (p\d+), max\)", statistics),
        (r"accurate to (\d+) % and (\d+) %, and the noise", percent_names),
        (r"GAP, (\d+) % unless given", default_gap),
        (r"starts from ([\d ]+) samples", search_starts),
        (
            r"H2 and l1 norms agree to (\S+) relative",
            lambda v: v.source("tests/filter/norms_test.cpp", r"n\.l1\.upper - n\.l1\.lower, (\S+) \*"),
        ),
        (
            r"and Jacobians to (\S+) with",
            lambda v: v.source("tests/kinematics/jacobian_test.cpp", r"gap\.jacobian, (\S+)\)"),
        ),
        (r"exact up to ([\d ]+) configurations", percentiles_limit),
        (
            r"It is within (\S+) % of the mean over all zeros",
            lambda v: (
                _percent(v.source("tests/acceptance/check_motion_figures.py", r"tolerance = (\S+) \* truth")[0]),
            ),
        ),
        (r"accurate to (\S+) relative and", lambda v: v.source(HISTOGRAM, r"relative error at most (\S+) for any")),
        (r"agree to (\d+) digits", agreed_digits),
        (r"to about (\S+)\. On one machine", lambda v: v.source(HISTOGRAM, r"values, (\S+) for millions")),
    ],
    TOPICS["variants"]: [
        (
            r"make at least (\d+) variants",
            lambda v: v.source("src/report/sweep/run_sweep.cpp", r"fewest_sharing = (\d+);"),
        ),
    ],
    TOPICS["requirements"]: [
        (r"between the two is at most (\d+) %", default_gap),
        (r"exit code is (\d) if all are met", exit_code("check", "-q", ARM)),
        (r"if all are met, (\d) if one is not", exit_code("check", "-q", ARM, "--set", "requirements.0.at_most=1 nm")),
    ],
    TOPICS["diagnosis"]: [
        (r"`([\d.]+) \?` means: detectable", smallest_eccentricity),
        (r"detectable from ([\d.]+) counts, but", smallest_eccentricity),
        (
            r"white noise of ([\d.]+) counts \(`--reference-noise",
            lambda v: v.printed(r"noise of ([\d.]+) counts", "diagnose", "configs/diagnosis/spec.yaml", "--plan"),
        ),
        (r"Intervals are of (\d+) %", lambda v: v.source("src/report/diagnosis/table.cpp", r"with (\d+) % intervals")),
    ],
    TOPICS["output"]: [
        (r"or (\d+) columns", lambda v: v.source("src/cli/shared.cpp", r"usual_width = (\d+)")),
        (r"\| (\d+) \| success \|", exit_code("schema")),
        (r"\| (\d+) \| success, but a requirement", exit_code("check", "-q", ARM, "--set", "requirements.0.at_most=1 nm")),
        (r"\| (\d+) \| error in the command line", exit_code("analyze", ARM, "--no-such-option")),
        (r"\| (\d+) \| error in the input", exit_code("analyze", ARM, "--set", "qerr=two")),
        (r"\| (\d+) \| a file cannot", unwritable),
        (r"\| (\d+) \| an internal error", lambda v: v.source("include/qerr/core/error.hpp", r"internal = (\d+)")),
        (
            r"\| (\d+), (\d+) \| interrupted",
            lambda v: (str(128 + signal.SIGINT), str(128 + signal.SIGTERM)),
        ),
    ],
    PAPER: [
        (r"norms from (\d+) Hz to (\d+) MHz, four", rates_of_table_3),
        (
            r"motion \((\d+) deg, ([\d.]+) Hz, the same sine in all joints\) is sampled at (\d+) kHz, so that every period"
            r" has the same (\d+) samples: (\d+) s are (\d+) repetitions of ([\d.]+) s, .* is not white at (\d+) counts per",
            experiment,
        ),
        (r"cut-off (\d+) rad/s", lambda v: v.source("scripts/reproduce_paper/sample_rates.py", r"corner = (\d+) / \(2")),
    ],
}
NAMES = {
    "README.md": [
        r"Debian 12\b",
        r"GCC 12 or Clang 14\b",
        r"\bl1\b",
        r"PUMA 560\b",
        r"BSD 3-Clause",
        r"encoder of a2 causes",
        r"one for a7 would change",
        r"actions/checkout@v4\b",
        r"\(H2 and H-infinity, not l1\)",
        r"sigma, ISO 9283\)",
    ],
    TOPICS["questions"]: [r"for 5 ms of delay\?"],
    TOPICS["library"]: [r"`h2_norm`, `l1_norm`", r"<package format=\"3\">", r"<version>0\.1\.0</version>", r"BSD-3-Clause"],
    TOPICS["changes"]: [r"the format `qerr: 1` of", r"certified l1 norm"],
    TOPICS["ci"]: [
        r"Debian 12\b",
        r"actions/checkout@v4\b", r"actions/cache@v4\b", r"actions/upload-artifact@v4\b",
    ],
    TOPICS["glossary"]: [
        r"ISO 9283\b",
        r"commanded 30 times",  # of the standard
        r"`1` where the encoder",
        r"\(1 sigma\)",
        r"Delta/sqrt\(12\)",
        r"\bp95, p99 \|", r"below them are 95 % and 99 % of these",
        r"\bH2\b", r"\bl1\b", r"H\(1\)", r"velocity filter it is 0\b", r"fallen by 3 dB",
    ],
    TOPICS["control"]: [
        r"\bl1\b", r"\bH2\b", r"-L/\(1 \+ L\) e\b", r"-C/\(1 \+ L\) e\b", r"\bL/\(1 \+ L\)", r"\b4/pi:",
        r"2 b/\(T \(1 \+ 2 d\)\) and 2 f/Delta\b", r"Robotics 21\(5\), 2005\)",
    ],
    ".github/CONTRIBUTING.md": [
        r"\bH2\b",
        r"\bl1\b",
        r"AVX-512, AVX2 or",
    ],
    TOPICS["spec"]: [
        r"`requirements\.0\.at_most` or `requirements\[0\]\.at_most`",
        r"`--set encoders\.a2\.bits=19`",
        # Numbers with units, as examples of writing them.
        r"`50 Hz`, `0\.1 mm`, `15 deg`, `12 arcmin`, `5 mm/s`",
    ],
    TOPICS["choice"]: [
        r"`velocity\.h2_norm`",
        r"`\{bits: 12\.\.23\}`",
        r"`\{counts_per_rev: \[2048, 4096\], gear_ratio: \[50, 100\]\}`",
        r"`price: \{fixed: 20, per_bit: 3\}`",
        r"`1\.\.4` \(default\) or `\[2, 4\]`",
        r"`\{band: 5 Hz, at_most: 2 %\}`",
        r"noise for 5 ms of delay",
        r"1 - value/limit",
        r"within 1e-8 of one another",
        r"differs from 1 by more than 1 %",
    ],
    TOPICS["encoders"]: [
        r"such as `1/100` are",
        r"`gear_accuracy: 1 arcmin`",
        r"`gear_accuracy: 0`",
        r"`'joint\[1-3\]'`",
        r"`accuracy: 20 arcsec`",
        r"A\^2/2",
        r"\(-Delta, 0\]",
        r"-Delta/2\b",
        # What a row says is computed in its last column.
        r"`counts_per_rev: 4096`",
        r"`lines_per_rev: 1024, decoding: x4`",
        r"`bits: 17`",
        r"`periods_per_rev: 512, interpolation_bits: 10`",
        r"`resolution: 0\.125 mrad`",
        # Examples of how a value is written.
        r"`requirements\[0\]\.at_most`",
        r"`--set encoders\.a2\.bits=19`",
        r"`1/100`",
        r"`'joint\[1-3\]'`",
        r"`accuracy: 20 arcsec`",
        r"A\^2/2 to its variance",
    ],
    TOPICS["filters"]: [r"\(1 - z\^-1\)/T", r"\bH2\b", r"\bl1\b", r"H\(1\)"],
    TOPICS["figures"]: [
        r"\bH2\b",
        r"\bl1\b",
        r"0\.5 \|J C\| Delta",
        r"diag\(Delta\^2/12\)",
        r"\|H\(1\)\|",
    ],
    TOPICS["motion"]: [r"\bphase 0\b", r"The 95 % interval"],
    TOPICS["variants"]: [
        # Examples of the forms of an entry.
        r"\{key: K, values: \[1, 2, 3\]\}",
        r"\{key: K, from: 5 Hz, to: 80 Hz, count: 9, scale: log\}",
        r"\{keys: \[K, L\], values: \[\[1, 2\], \[3, 4\]\]\}",
        r"`\{key: encoders\.a2, catalogue: encoders\.csv\}`",
        r"`--statistics max,p99`",
        r"\{wildcards\.k\}/20 -o", r"k \+ 1\}\.csv\" for k in range\(20\)\]",  # of a cluster's size
    ],
    TOPICS["effects"]: [r"\bH2\b", r"\bl1\b"],
    TOPICS["logs"]: [r"RFC 4180\b", r"ROS [12]\b", r"rosbag2", r"UTF-8", r"UTF-16", r"Windows-1252", r"# t q1 q2", r"`column [12]`", r"--column shoulder\.counts=q1_motor --column 'shoulder\.reference=q1_link",
                     r"\ba joint `a1`", r"/joint_states/a1/position`", r"`a1\.(?:measured|command|effort|counts):",
                     r"`?(?:actual|target)_q_0`", r"[`']q\[0\]'?`", r"[`']tau_J\[0\]'?`", r"ID1_Present_Position`",
                     r"`actual_TCP_pose_0`", r"`O_T_EE\[12\]`", r"\blz4\b", r"`\.db3`", r"`\.h5`",
                     r"\| Float64, Float32, Int64, Int32 \|", r"\| Float64MultiArray \| `TOPIC/data/0`", r"`26\.11\.2026 17:16:42,123`", r"`11/26/2026 5:16:42 PM`", r"those since 1970", r"`\[1\]`", r"`\[0\.1 deg\]`", r"`\[360/4096 deg\]`", r"`ros2 topic", r"column: column 1, unit", r"a1\.measured: column 5`", r"`#DIV/0!`", r"days since 1900", r"`14-Mar-2026 17:16:42`", r"an epoch such as 1970", r"ISO 8601", r"`2026-05-01T12:00:00\.25Z`",
                     r"`123\.0`", r"multiples of 1/4, say", r"1/1024 or coarser"],
    PAPER: [
        r"--row 15\b",
        r"# row 15 of the claims",
        r"`python3 scripts",
        r"\(37\)",
        r"Figs\. 1 to 4, 6 and 11 are",
        r"by \(43\) and \(44\), and with 2 pi",
        # Numbers of tables and figures, with the files of the same numbers.
        r"Table II \| `table_2\.csv`",
        r"Table III \| `table_3\.csv`",
        r"Table IV \| `table_4\.csv`",
        r"Fig\. 5 \| `figure_5`",
        r"Figs\. 7, 8, 9 \| `figure_7`, `figure_8`, `figure_9`",
        r"Fig\. 10 \| `figure_10`",
        r"Fig\. 12 \| `figure_12`",
        r"Fig\. 13 \| `figure_13`",
        r"behind Figs\. 12 and 13: errors",
        r"Fig\. 14, App\. A \| `figure_14`",
        r"Figs\. 7, 8 for higher",
        r"so that Figs\. 12 and 13 compare",
        r"whiskers of Figs\. 12 and 13 are",
    ],
}
_FILE = re.compile(r"`([\w.-]+(?:/[\w.-]+)+)`")


def _spaced(pattern):
    """A blank stands for any white space, so that lines may be broken anywhere."""
    return re.compile(re.sub(r"(?<!\\) (?![+*?])", r"\\s+", pattern), re.S)


class Missing(Exception):
    """The text no longer has a figure that is listed here."""


def _places(name, text):
    for pattern, value in STATEMENTS.get(name, []):
        match = _spaced(pattern).search(text)
        if match is None:
            raise Missing(f"the text lacks the statement '{pattern}'")
        yield match, value


def changes(name, text, values):
    """(begin, end, value) of every figure."""
    for number, (match, value) in enumerate(_places(name, text)):
        new = values.once(number, lambda: value(values))
        for group, figure in enumerate(new, start=1):
            yield (*match.span(group), figure)


def covered(name, text, root):
    """Ranges of figures that are computed, of names, and of files that exist."""
    ranges = [match.span(group + 1) for match, _ in _places(name, text) for group in range(len(match.groups()))]
    for pattern in NAMES.get(name, []):
        ranges += [match.span() for match in _spaced(pattern).finditer(text)]
    return ranges + [match.span() for match in _FILE.finditer(text) if (root / match[1]).exists()]
