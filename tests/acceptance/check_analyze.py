#!/usr/bin/env python3
"""Acceptance of `qerr analyze` against an independent computation. Needs numpy only.

    check_analyze.py --qerr build/qerr [--shared ../shared] [--keep DIR]
"""
import argparse
import hashlib
import json
import pathlib
import sys
import tempfile

import numpy as np

import reports
from cases import own_cases, public_cases
from expected import ANGULAR, box_errors, expected, rigorous_ceiling, statistics
from tool import Tally, Worst, run

ROOT = pathlib.Path(__file__).resolve().parents[2]
KEYS = ["qerr", "command", "spec", "seed", "robot", "configurations", "joints", "position", "derivatives", "effects", "warnings"]
STAT = ["min", "mean", "max", "p50", "p95", "p99", "at_max"]


def bound_unit(coordinate, derivative=0):
    return ("rad" if coordinate in ANGULAR else "m") + ("" if not derivative else "/s" if derivative == 1 else f"/s^{derivative}")


def compare_stat(worst, where, stat, values, floor, case):
    """Compares the statistics with the expected values per configuration; at_max must be a point that attains the maximum."""
    if not isinstance(stat, dict) or [k for k in STAT if k not in stat]:
        worst.add(f"{where} (keys)", None, 0)
        return
    for key, wanted in statistics(values).items():
        worst.add(f"{where}.{key}", stat[key], float(wanted), floor)
    at = stat["at_max"]
    if sorted(at) != sorted(case.chain.names):
        worst.add(f"{where}.at_max names {sorted(at)}", None, 0)
        return
    point = np.array([at[n] for n in case.chain.names])
    index = int(np.argmin(np.abs(case.points - point).max(axis=1)))
    for n, a, b in zip(case.chain.names, point, case.points[index]):
        worst.add(f"{where}.at_max.{n}", float(a), float(b), 1e-12)
    worst.add(f"{where} at its at_max", float(values[index]), float(values.max()), floor)


def check_case(t, qerr, case, folder):
    spec = folder / "spec.yaml"
    spec.write_text(case.text)
    ran = run(qerr, "analyze", spec, "--format", "json", "--per-configuration", folder / "each.csv")
    label = f"{case.name} ({len(case.points)} points)"
    if not t.check(f"{label}: runs", ran.code == 0, f"exit {ran.code}: {ran.err.decode(errors='replace').strip()[:300]}"):
        return
    report = json.loads(ran.out, parse_constant=lambda v: None)
    t.check(f"{label}: keys", [k for k in KEYS if k in report] == KEYS, f"found {list(report)}")
    t.check(f"{label}: header", report["command"] == "analyze" and report["robot"]["name"] == case.chain.robot
            and (report["robot"]["base"], report["robot"]["tip"]) == (case.chain.base, case.chain.tip)
            and report["configurations"]["method"] == "list" and report["configurations"]["count"] == len(case.points)
            and report["spec"]["sha256"] == hashlib.sha256(spec.read_bytes()).hexdigest() and report["effects"] == [],
            str({k: report[k] for k in ("command", "spec", "robot", "configurations", "effects")}))
    e = expected(case)
    check_joints(t, label, report, case, e)
    check_position(t, label, report, case, e)
    check_derivatives(t, label, report, case, e)
    check_joint_signals(t, qerr, spec, label, case, e)
    check_each(t, label, folder / "each.csv", case, e)
    tidy = run(qerr, "analyze", spec, "--format", "csv")
    reports.check_tidy(t, label, tidy, report)


def check_joints(t, label, report, case, e):
    worst, joints = Worst(), report["joints"]
    t.check(f"{label}: joint names and units", [(j["name"], j["unit"]) for j in joints] == list(zip(case.chain.names, case.chain.units)),
            f"found {[(j['name'], j['unit']) for j in joints]}")
    for i, joint in enumerate(joints):
        worst.add(f"{joint['name']}.resolution", joint["resolution"], float(case.delta[i]))
        worst.add(f"{joint['name']}.worst_case", joint["worst_case"], float(e["joint_worst"][i]))
        worst.add(f"{joint['name']}.sigma", joint["sigma"], float(e["joint_sigma"][i]))
    t.check(f"{label}: joints", worst.holds(), worst.detail())


def check_joint_signals(t, qerr, spec, label, case, e):
    """Joints as coordinates: the same at all configurations, behind filters, and alone or beside the tip's."""
    for listed in ("joints", f"z, '{case.chain.names[-1]}'"):
        ran = run(qerr, "analyze", spec, "--set", f"coordinates=[{listed}]", "--json", "--quiet")
        if not t.check(f"{label}: coordinates [{listed}]", ran.code == 0, ran.err.decode()[:300]):
            return
        report, worst = json.loads(ran.out), Worst()
        named = {n if n not in ANGULAR + ("x", "y", "z", "xyz", "rxyz") else f"joint:{n}": i for i, n in enumerate(case.chain.names)}
        rows = {row["coordinate"]: row for row in report["position"]}
        t.check(f"{label}: their names", [n for n in rows if n != "z"] == (list(named) if listed == "joints" else list(named)[-1:]), list(rows))
        for name, i in named.items():
            if name not in rows:
                continue
            wanted = {"worst_case": e["joint_worst"][i], "worst_case_rigorous": e["joint_worst"][i], "sigma": e["joint_sigma"][i]}
            found = [(rows[name], wanted)]
            for d in report["derivatives"]:
                x = e["derivatives"][d["filter"]]
                found.append(({row["coordinate"]: row for row in d["coordinates"]}[name],
                              {"worst_case": x["l1"] * e["joint_half"][i] + abs(x["dc"]) * e["joint_mean"][i],
                               "sigma": x["h2"] * e["joint_sigma"][i]}))
            for row, values in found:
                for bound, value in values.items():
                    for statistic in STAT[:-1]:
                        worst.add(f"{name}.{bound}.{statistic}", row[bound][statistic], float(value))
        t.check(f"{label}: their figures", worst.holds(), worst.detail())


def check_position(t, label, report, case, e):
    names = [p["coordinate"] for p in report["position"]]
    units = [p["unit"] for p in report["position"]]
    if not t.check(f"{label}: coordinates", names == case.coordinates and units == [bound_unit(c) for c in names], f"{names} {units}"):
        return
    worst, sigma, share, rigorous, sane = Worst(), Worst(), Worst(), [], []
    box, ceiling = box_errors(case), rigorous_ceiling(case)
    for k, p in enumerate(report["position"]):
        name, floor = p["coordinate"], 1e-14 * e["scale"][k]
        compare_stat(worst, f"{name}.worst_case", p["worst_case"], e["worst"][:, k], floor, case)
        compare_stat(sigma, f"{name}.sigma", p["sigma"], e["sigma"][:, k], floor, case)
        if e["sigma"][:, k].min() > 1e-6 * e["scale"][k]:
            for i, n in enumerate(case.chain.names):
                share.add(f"{name}.share.{n}", p["share"].get(n), float(e["share"][:, k, i].mean()), 1e-10)
        bound = p["worst_case_rigorous"]
        if name in ("roll", "pitch", "yaw"):
            if bound is not None:
                rigorous.append(f"{name}: {bound} where null is due")
            continue
        for key, wanted in statistics(box[:, k]).items():
            if not bound[key] >= wanted * (1 - 1e-12) - 1e-14 * e["scale"][k] - 2e-16:
                rigorous.append(f"{name}.{key}: {bound[key]!r} < a corner's {wanted!r}")
        for key, wanted in statistics(e["worst"][:, k]).items():
            if not wanted * (1 - 1e-9) - floor <= bound[key] <= wanted * (1 + 1e-9) + ceiling[k] + floor:
                sane.append(f"{name}.{key}: {bound[key]!r} against the linear {wanted!r} and a remainder of at most {ceiling[k]:.3g}")
    t.check(f"{label}: worst case", worst.holds(), worst.detail())
    t.check(f"{label}: sigma", sigma.holds(), sigma.detail())
    if share.count:
        t.check(f"{label}: share", share.holds(), share.detail())
    t.check(f"{label}: rigorous bound holds at the corners", not rigorous, "; ".join(rigorous[:3]))
    t.check(f"{label}: rigorous bound is not far above the linear one", not sane, "; ".join(sane[:3]))


def check_derivatives(t, label, report, case, e):
    found = {d["filter"]: d for d in report["derivatives"]}
    if not t.check(f"{label}: filters", list(found) == list(case.filters), f"found {list(found)}") or not found:
        return
    worst, norm = Worst(), Worst()
    for name, d in found.items():
        f, x = case.filters[name], e["derivatives"][name]
        order = f.get("derivative", 0)
        norm.add(f"{name}.derivative", d["derivative"], order)
        norm.add(f"{name}.h2_norm", d["h2_norm"], x["h2"])
        low, high = d["l1_norm"]["lower"], d["l1_norm"]["upper"]
        norm.add(f"{name}.l1_norm.lower", low, x["l1"])
        norm.add(f"{name}.l1_norm.upper", high, x["l1"])
        if not (low <= x["l1"] * (1 + 1e-13) and high >= x["l1"] * (1 - 1e-13)):
            norm.add(f"{name}.l1_norm [{low!r}, {high!r}] misses {x['l1']!r}", None, 0)
        names = [(c["coordinate"], c["unit"]) for c in d["coordinates"]]
        if names != [(c, bound_unit(c, order)) for c in case.coordinates]:
            norm.add(f"{name}: coordinates {names}", None, 0)
            continue
        for k, c in enumerate(d["coordinates"]):
            compare_stat(worst, f"{name}.{c['coordinate']}.worst_case", c["worst_case"], x["worst"][:, k],
                         1e-14 * e["scale"][k] * x["l1"], case)
            compare_stat(worst, f"{name}.{c['coordinate']}.sigma", c["sigma"], x["sigma"][:, k], 1e-14 * e["scale"][k] * x["h2"], case)
    t.check(f"{label}: norms", norm.holds(), norm.detail())
    t.check(f"{label}: derivatives", worst.holds(), worst.detail())


def check_each(t, label, path, case, e):
    header, rows = reports.read_csv(path.read_text()) if path.exists() else ([], [])
    wanted = {f"{n} [{u}]": case.points[:, i] for i, (n, u) in enumerate(zip(case.chain.names, case.chain.units))}
    floors = dict.fromkeys(wanted, 1e-12)
    lower = {}
    for k, c in enumerate(case.coordinates):
        unit = bound_unit(c)
        for kind in ("worst", "sigma"):
            key = f"{c}.{'worst_case' if kind == 'worst' else kind} [{unit}]"
            wanted[key], floors[key] = e[kind][:, k], 1e-14 * e["scale"][k]
        if c not in ("roll", "pitch", "yaw"):
            lower[f"{c}.worst_case_rigorous [{unit}]"] = k
        for name, x in e["derivatives"].items():
            unit_d = bound_unit(c, case.filters[name].get("derivative", 0))
            for kind, size in (("worst", "l1"), ("sigma", "h2")):
                key = f"{name}.{c}.{'worst_case' if kind == 'worst' else kind} [{unit_d}]"
                wanted[key], floors[key] = x[kind][:, k], 1e-14 * e["scale"][k] * x[size]
    missing = [h for h in list(wanted) + list(lower) if h not in header]
    t.check(f"{label}: --per-configuration columns", not missing and len(rows) == len(case.points),
            f"{len(rows)} rows, missing {missing[:6]} of {header[:12]}")
    if missing or len(rows) != len(case.points):
        return
    table = {h: [row[i] for row in rows] for i, h in enumerate(header)}
    worst = Worst()
    for key, values in wanted.items():
        for i, (cell, value) in enumerate(zip(table[key], values)):
            worst.add(f"row {i + 1} {key}", float(cell or "nan"), float(value), floors[key])
    box, below = box_errors(case, interior=0), []
    for key, k in lower.items():
        for i, cell in enumerate(table[key]):
            if not float(cell or "nan") >= box[i, k] * (1 - 1e-12) - 1e-14 * e["scale"][k] - 2e-16:
                below.append(f"row {i + 1} {key}: {cell} < {box[i, k]!r}")
    t.check(f"{label}: --per-configuration values", worst.holds(), worst.detail())
    t.check(f"{label}: --per-configuration rigorous", not below, "; ".join(below[:3]))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--qerr", required=True)
    parser.add_argument("--shared", default=str(ROOT.parent / "shared"))
    parser.add_argument("--only", default="", help="only the cases whose name contains this")
    arguments = parser.parse_args()
    qerr, t = pathlib.Path(arguments.qerr).resolve(), Tally()
    robots = pathlib.Path(arguments.shared) / "robots"
    cases = own_cases()
    if robots.is_dir():
        cases += public_cases(robots)
    else:
        print(f"note: {robots} is absent: the public robots are left out, the corpus' own robots remain")
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        for case in cases:
            if arguments.only in case.name:
                try:
                    check_case(t, qerr, case, folder)
                except (KeyError, TypeError, ValueError, IndexError) as trouble:
                    t.check(f"{case.name}: the report satisfies the contract's schema", False, repr(trouble))
        if not arguments.only:
            reports.check_reproducible(t, qerr, ROOT, folder)
            reports.check_paper(t, qerr, ROOT, folder)
    return t.close()


if __name__ == "__main__":
    sys.exit(main())
