#!/usr/bin/env python3
"""Checks `qerr filter --write-code` against the same filters run in long double.

    check_code.py --qerr PATH [--count 20] [--seed 1] [--compiler cc]

Random filters: cascades of differences and low-passes, sections, coefficients and taps. The C code is compiled with all
warnings as errors and run in double and in float along white noise, the input of the largest output, and a quantized
motion; Python is imported, the chain of ROS filters is run by its difference equation. Double and Python: within 1e-12
of the largest output that such an input can have. Both: within the error that the code states.
"""
import argparse
import json
import pathlib
import random
import re
import runpy
import subprocess
import tempfile

import numpy as np

import filters
from tool import Tally, run

L = np.longdouble
SAMPLES = 1500


def low_pass(rng, rate):
    return {"derivative": rng.randint(0, 2), "sample_rate": rate,
            "lowpass": {"family": rng.choice(["first_order", "butterworth"]), "order": rng.randint(1, 6),
                        "cutoff": rate * 10 ** rng.uniform(-2.5, -0.4)}}


def sections(rng, rate):
    rows = []
    for _ in range(rng.randint(1, 4)):
        radius, angle = 1 - 10 ** rng.uniform(-2.5, -0.3), rng.uniform(0.02, 3.1)
        rows.append([rng.uniform(-1, 1) for _ in range(3)] + [1, -2 * radius * np.cos(angle), radius**2])
    return {"derivative": 0, "sample_rate": rate, "sos": [[float(x) for x in row] for row in rows]}


def taps(rng, rate):
    return {"derivative": 0, "sample_rate": rate, "numerator": [rng.uniform(-2, 2) for _ in range(rng.randint(2, 60))],
            "denominator": [1.0]}


def cascade(f):
    """[(numerator, denominator)] in long double, ascending in 1/z."""
    if "sos" in f:
        return [([L(x) for x in row[:3]], [L(x) for x in row[3:]]) for row in f["sos"]]
    return filters.sections_of(f)


def filtered(f, x, number=L):
    """From rest, by the difference equation of each section."""
    y = [number(v) for v in x]
    for b, a in cascade(f) if number is L else f:
        past_x, past_y, out = [number(0)] * (len(b) - 1), [number(0)] * (len(a) - 1), []
        for v in y:
            past_x = [v] + past_x
            w = sum((c * p for c, p in zip(b, past_x)), number(0)) - sum((c * p for c, p in zip(a[1:], past_y)), number(0))
            w = w / a[0]
            past_x, past_y = past_x[:len(b) - 1], ([w] + past_y)[:len(a) - 1]
            out.append(w)
        y = out
    return np.array(y, dtype=number)


MAIN = """
#include <stdio.h>
#include <math.h>
%s
#include "filters.h"
int main(void) {
  double x;
  static %s_filter f;
  while (scanf("%%lf", &x) == 1) printf("%%.17g\\n", (double)%s_step(&f, (qerr_real)x));
  return 0;
}
"""


def compiled(folder, name, real, compiler):
    source, program = folder / f"{name}_{real}.c", folder / f"{name}_{real}"
    define = "" if real == "double" else f"#define QERR_REAL {real}"
    source.write_text(MAIN % (define, name, name))
    done = subprocess.run([compiler, "-std=c99", "-O1", "-Wall", "-Wextra", "-Werror", "-Wno-unused-function", "-Wno-unused-const-variable",
                           "-o", program, source, "-lm"], capture_output=True, text=True)
    return program if done.returncode == 0 else done.stderr


def inputs(rng, f):
    h = filtered(f, [1.0] + [0.0] * (SAMPLES - 1))
    noise = rng.uniform(-1, 1, SAMPLES)
    worst = np.sign(h[::-1]).astype(float)
    t = np.arange(SAMPLES)
    motion = np.round(900 * np.sin(2 * np.pi * t / rng.uniform(50, 900))) / 1000
    return float(np.abs(h).sum()), {"noise": noise, "worst": worst, "motion": motion}


def check(tally, folder, index, f, arguments, rng):
    (folder / "spec.yaml").write_text(
        "qerr: 1\nrobot: {joint: {name: j, type: revolute, limits: [-1, 1]}}\ncoordinates: [rz]\nencoders: {j: {bits: 16}}\n"
        f"filters: {{v: {json.dumps(f)}}}\n")
    for language, name in (("c", "filters.h"), ("python", "code.py"), ("ros", "chain.yaml")):
        ran = run(arguments.qerr, "filter", "spec.yaml", "-q", "--write-code", language, name, "-o", "report.json", cwd=folder)
        if not tally.check(f"{index} {language} is written", ran.code == 0, ran.err.decode()):
            return
    header = (folder / "filters.h").read_text()
    stated = {n: float(v) for n, v in re.findall(r"#define V_(\w+)_ERROR (\S+)", header)}
    peak, along = inputs(rng, f)
    code = runpy.run_path(str(folder / "code.py"))["v"]
    chain = [(json.loads(b), json.loads(a)) for a, b in re.findall(r"a: (\[.*?\]), b: (\[.*?\])", (folder / "chain.yaml").read_text())]
    programs = {real: compiled(folder, "v", real, arguments.compiler) for real in ("double", "float")}
    for real, program in programs.items():
        if not tally.check(f"{index} {real} compiles without warnings", not isinstance(program, str), program):
            return
    for name, x in along.items():
        exact = filtered(f, x)
        for real, program in programs.items():
            ran = subprocess.run([program], input="\n".join(repr(float(v)) for v in x), capture_output=True, text=True)
            error = float(np.abs(np.array([float(v) for v in ran.stdout.split()], dtype=L) - exact).max())
            tally.check(f"{index} {name} in {real}: within its error", error <= stated[real.upper()], f"{error} > {stated}")
            if real == "double":
                tally.check(f"{index} {name} in C: equal to 1e-12", error <= 1e-12 * peak, f"{error / peak:.3g} of the peak")
            elif name == "worst":
                arguments.ratios.append(stated["FLOAT"] / max(error, 1e-300))
        one = code()
        error = float(np.abs(np.array([one.step(float(v)) for v in x], dtype=L) - exact).max())
        tally.check(f"{index} {name} in Python: equal to 1e-12", error <= min(1e-12 * peak, code.DOUBLE_ERROR), f"{error / peak:.3g}")
        error = float(np.abs(filtered(chain, x, np.float64) - exact).max())
        tally.check(f"{index} {name} in ROS: equal to 1e-8", error <= 1e-8 * peak, f"{error / peak:.3g}")
    started = code(0.75)
    y = [started.step(0.75) for _ in range(50)]
    gain = float(np.prod([sum(b) / sum(a) for b, a in cascade(f)]))
    tally.check(f"{index} a start at rest stays there", np.ptp(y) <= code.DOUBLE_ERROR * 2 and abs(y[0] - 0.75 * gain) < 1e-9 * peak, f"{y[:3]} {gain}")


def check_names(tally, folder, arguments):
    """Names that are one in capitals, keywords, or names of the code itself."""
    names = ["vel 2", "VEL_2", "vel-2", "class", "Filter", "qerr_section", "float"]
    low = '{derivative: 1, sample_rate: 1 kHz, lowpass: {family: first_order, order: 2, cutoff: %d Hz}}'
    rows = [f"  {json.dumps(name)}: {low % (10 + 10 * i)}\n" for i, name in enumerate(names)]
    rows.append("  sum: {derivative: 0, sample_rate: 1 kHz, numerator: [0.25, 0.75], denominator: [1]}\n")
    (folder / "names.yaml").write_text("qerr: 1\nrobot: {joint: {name: j, type: revolute, limits: [-1, 1]}}\ncoordinates: [rz]\n"
                                       "encoders: {j: {bits: 16}}\nfilters:\n" + "".join(rows))
    for language, name in (("c", "filters.h"), ("python", "names.py")):
        run(arguments.qerr, "filter", "names.yaml", "-q", "--write-code", language, name, "-o", "report.json", cwd=folder)
    macros = re.findall(r"#define (\w+)_FLOAT_ERROR", (folder / "filters.h").read_text())
    tally.check("names: a macro each", len(macros) == len(set(macros)) == len(rows), str(macros))
    program = compiled(folder, "VEL_2_2", "double", arguments.compiler)
    tally.check("names: the header compiles", not isinstance(program, str), str(program))
    code = runpy.run_path(str(folder / "names.py"))
    filters_of_code = [c for n, c in code.items() if isinstance(c, type) and c.__name__ != "Filter"]
    tally.check("names: a class each", len(filters_of_code) == len(rows) and all(c.__bases__ == (code["Filter"],) for c in filters_of_code),
                str(list(code)))
    tally.check("names: taps are summed", code["filter_sum"](1.0).step(1.0) == 1)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--qerr", required=True)
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--compiler", default="cc")
    arguments = parser.parse_args()
    arguments.qerr = pathlib.Path(arguments.qerr).resolve()
    arguments.ratios = []
    tally = Tally(False)
    rng, numbers = random.Random(arguments.seed), np.random.default_rng(arguments.seed)
    with tempfile.TemporaryDirectory() as folder:
        for index in range(arguments.count):
            f = rng.choice([low_pass, low_pass, sections, taps])(rng, rng.choice([500.0, 1000.0, 8000.0]))
            check(tally, pathlib.Path(folder), index, f, arguments, numbers)
        check_names(tally, pathlib.Path(folder), arguments)
    print(f"stated error of float over the one along the worst input: {min(arguments.ratios):.3g} .. "
          f"{max(arguments.ratios):.3g}, median {np.median(arguments.ratios):.3g}")
    return tally.close()


if __name__ == "__main__":
    raise SystemExit(main())
