"""Checks of the reports: CSV against JSON, reproducibility, the paper's figures, Table IV."""
import csv
import io
import json
import math

from cases import CORPUS
from tool import Worst, run

STATISTICS = ("min", "mean", "max", "p50", "p95", "p99")
TIDY = ["signal", "filter", "coordinate", "unit", "bound", "statistic", "value"]
THRESHOLD = ["robot", "counts_per_rev", "gear_ratio", "length_mm", "sample_rate_hz", "resolution_mm", "threshold_velocity_mm_s",
             "resolution_mm_as_printed", "threshold_velocity_mm_s_as_printed"]


def read_csv(text):
    rows = list(csv.reader(io.StringIO(text)))
    return (rows[0], rows[1:]) if rows else ([], [])


def flat(report):
    """{(signal, filter, coordinate, unit, bound, statistic): value} of a JSON report."""
    table = {}
    for p in report["position"]:
        for bound in ("worst_case", "worst_case_rigorous", "sigma"):
            for s in STATISTICS if p[bound] is not None else ():
                table["position", "", p["coordinate"], p["unit"], bound, s] = p[bound][s]
    for d in report["derivatives"]:
        for c in d["coordinates"]:
            for bound in ("worst_case", "sigma"):
                for s in STATISTICS:
                    table["derivative", d["filter"], c["coordinate"], c["unit"], bound, s] = c[bound][s]
    return table


def check_tidy(t, label, ran, report):
    header, rows = read_csv(ran.out.decode())
    if not t.check(f"{label}: CSV header", ran.code == 0 and header == TIDY, f"exit {ran.code}, {header}"):
        return
    wanted, found, worst = flat(report), {}, Worst(1e-15)
    for row in rows:
        if tuple(row[:6]) in wanted:
            found[tuple(row[:6])] = float(row[6])
    for key, value in wanted.items():
        worst.add(".".join(key), found.get(key), float(value))
    t.check(f"{label}: CSV agrees with JSON", worst.holds(), worst.detail())


def check_reproducible(t, qerr, root, folder):
    spec = folder / "sobol.yaml"
    base = (f"qerr: 1\nrobot: {{urdf: {CORPUS / 'arm.urdf'}}}\nencoders:\n  '*': {{bits: 14}}\n"
            "  lift: {resolution: 10 um}\ncoordinates: [x, y, z, rx, ry, rz]\n"
            "filters:\n  velocity: {derivative: 1, sample_rate: 1 kHz, lowpass: {family: first_order, order: 2, cutoff: 50 Hz}}\n"
            "configurations: {method: METHOD, count: COUNT, seed: 1, limits: {wrist: [-180 deg, 180 deg]}}\n")
    for method, count in (("sobol", "20000"), ("random", "20001"), ("grid", "11"), ("sobol", "7")):
        spec.write_text(base.replace("METHOD", method).replace("COUNT", count))
        for form in ("json", "csv", "table"):
            outs = []
            for threads in (1, 2, 3, 2):
                each = folder / f"each{len(outs)}.csv"
                ran = run(qerr, "analyze", spec, "--format", form, "--threads", threads, "--per-configuration", each)
                rows = each.read_bytes() if each.exists() else b""
                outs.append((ran.code, ran.out, rows))
            good = outs[0][0] == 0 and outs[0][1] and outs[0][2] and all(o == outs[0] for o in outs)
            t.check(f"{method} {count}, {form}: the same bytes for --threads 1, 2, 3 and again", good,
                    f"exit codes {[o[0] for o in outs]}, lengths {[(len(o[1]), len(o[2])) for o in outs]}, {ran.err.decode()[:200]}")
    spec.write_text(base.replace("METHOD", "sobol").replace("COUNT", "500"))
    files = [folder / "again1.json", folder / "again2.json"]
    for path in files:
        run(qerr, "analyze", spec, "-o", path)
    stdout = run(qerr, "analyze", spec, "--format", "json").out
    t.check("-o FILE.json has the bytes of --format json, twice", all(p.exists() and p.read_bytes() == stdout for p in files))
    if not stdout:
        t.check("seeds", False, "no report")
        return
    seeds = [run(qerr, "analyze", spec, "--format", "json", "--seed", s).out for s in (1, 2)]
    t.check("--seed 1 is the spec's seed 1, --seed 2 is another sample",
            json.loads(seeds[0])["position"] == json.loads(stdout)["position"]
            and json.loads(seeds[1])["position"] != json.loads(stdout)["position"] and json.loads(seeds[1])["seed"] == 2)
    shipped = sorted((root / "configs").glob("*/*.yaml"))
    t.check("configs/ has robots", len(shipped) >= 7, str(len(shipped)))
    for path in shipped:
        outs = [run(qerr, "analyze", path, "--format", "json", "--threads", n).out for n in (1, 3)]
        t.check(f"{path.relative_to(root)}: runs, the same bytes for --threads 1 and 3", outs[0] and outs[0] == outs[1])


def check_paper(t, qerr, root, folder):
    spec = folder / "prr.yaml"
    spec.write_text(
        f"qerr: 1\nrobot: {{urdf: {CORPUS / 'prr.urdf'}}}\nencoders:\n  slide: {{counts_per_rev: 10000, travel_per_rev: 1 m}}\n"
        "  '*': {counts_per_rev: 10000}\ncoordinates: [x, y]\nfilters:\n"
        "  one: {derivative: 1, sample_rate: 1 kHz, lowpass: {family: first_order, order: 1, cutoff: 50 Hz}}\n"
        "  two: {derivative: 1, sample_rate: 1 kHz, lowpass: {family: first_order, order: 2, cutoff: 50 Hz}}\n"
        "configurations: {method: list, points: [[0, 11.7 deg, 110 deg]]}\n")
    ran = run(qerr, "analyze", spec, "--format", "json")
    sigmas = {}
    if ran.out.startswith(b"{"):
        sigmas = {d["filter"]: [c["sigma"]["max"] for c in d["coordinates"]] for d in json.loads(ran.out)["derivatives"]}
    for name, wanted in (("one", 0.0802), ("two", 0.0241)):
        t.check(f"PRR, order {name}: sigma of the velocity is {wanted} m/s in x and y",
                name in sigmas and all(abs(s - wanted) <= 0.00005 for s in sigmas[name]), f"{sigmas} {ran.err.decode()[:200]}")
    specs = sorted((root / "configs" / "table_iv").glob("*.yaml"))
    ran = run(qerr, "threshold", *specs, "--format", "csv")
    header, rows = read_csv(ran.out.decode())
    t.check("threshold: exit 0, the contract's columns, five rows", ran.code == 0 and header[:9] == THRESHOLD and len(rows) == 5,
            f"exit {ran.code}, {len(specs)} specs, {len(rows)} rows, {header} {ran.err.decode()[:200]}")
    worst, printed = Worst(1e-9), set()
    for row in [dict(zip(header, r)) for r in rows]:
        n, gear, length, rate = (float(row[k]) for k in THRESHOLD[1:5])
        step = length / (n * abs(gear))
        for key, value in zip(THRESHOLD[5:], (2 * math.pi * step, 2 * math.pi * step * rate, step, step * rate)):
            worst.add(f"{row['robot']}.{key}", float(row[key]), value)
        printed.add(float(f"{step:.3g}"))
    t.check("threshold: both interpretations follow from n, G, l and f", worst.holds(), worst.detail())
    t.check("threshold: l/(nG) of Table IV's five rows", printed == {0.015, 1.67e-4, 5e-4, 0.02, 0.005}, str(printed))
    ran = run(qerr, "threshold", *specs)
    t.check("threshold: the table has the figures of both interpretations", ran.code == 0 and len(ran.out.splitlines()) >= 6, ran.out.decode()[:200])
