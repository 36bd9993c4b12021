#!/usr/bin/env python3
"""Every JSON report of every command against its schema (`qerr schema --output-of REPORT`, draft 2020-12).

    check_output_schemas.py --qerr build/qerr [--verbose]

The schemas permit further members, as later versions may have them; here members that a schema does not describe are
faults, so that none is forgotten. A report without some required member, or with a text in place of a number, must be
rejected.
"""
import copy
import json
import pathlib
import sys
import tempfile

import jsonschema

from tool import program_and_tally, run

ROOT = pathlib.Path(__file__).resolve().parents[2]
CONFIGS = ROOT / "configs"
DIAGNOSIS = CONFIGS / "diagnosis" / "spec.yaml"
EFFECTS = "effects=[{type: backlash, joint: j2, gap: 0.4 mrad}, {type: eccentricity, joint: j3, amplitude: 0.3 mrad, phase: 40 deg}]"
SPREAD = "effects=[{type: noise, joint: j1, sigma: 0.1 mrad}, {type: log_rounding, joint: j2, step: 1 urad}]"
DESIGN = """qerr: 1
robot: {{urdf: {urdf}}}
encoders: {{'*': {{bits: 16}}}}
filters:
  velocity: {{derivative: 1, sample_rate: 1 kHz, lowpass: {{family: first_order, order: 2, cutoff: 50 Hz}}}}
configurations: {{count: 50}}
requirements:
  - {{quantity: position.x.worst_case, statistic: max, at_most: 0.5 mm}}
  - {{quantity: velocity.delay, at_most: 10 ms}}
design:
  encoders: {{'*': {{bits: 10..18}}}}
  filters: {{velocity: {{families: [first_order, butterworth], tracking: {{band: 5 Hz, at_most: 25 %}}}}}}
"""
FILTERS = CONFIGS / "filters" / "filters.yaml"


def closed(schema):
    """The schema without permission for members that it does not describe."""
    if isinstance(schema, list):
        return [closed(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    strict = {key: closed(value) for key, value in schema.items()}
    if isinstance(schema.get("properties"), dict) and schema.get("type") == "object":
        strict.setdefault("additionalProperties", False)
    return strict


def reports(qerr, folder):
    """(name of the report, words of a command)"""
    specs = sorted(CONFIGS.glob("*/spec.yaml"))
    few = ["--set", "configurations.count=50"]
    for spec in specs:
        yield "analyze", ["analyze", spec, *few]
        if "requirements:" in spec.read_text():
            yield "check", ["check", spec, *few]
    arm = CONFIGS / "kuka_lwr" / "spec.yaml"
    premium = CONFIGS / "phantom_premium" / "spec.yaml"
    proven = "requirements=[{quantity: position.x.sigma, statistic: proven_max, at_most: 1 mm}]"
    yield "analyze", ["analyze", premium, *few, "--prove", "5%"]
    yield "check", ["check", premium, *few, "--set", proven]
    yield "compare", ["compare", premium, premium, *few, "--set", proven]
    old = folder / "old.json"
    run(qerr, "analyze", arm, *few, "-q", "-o", old)
    yield "check", ["check", arm, *few, "--baseline", old, "--tolerance", "2%", "--set", "encoders.*.counts_per_rev=300"]
    yield "compare", ["compare", old, arm, *few]
    yield "compare", ["compare", arm, arm, *few, "--set", "filters={}", "--set", "requirements=[]"]
    yield "compare", ["compare", CONFIGS / "planar_prr" / "spec.yaml", arm, *few, "--set", "encoders.*.counts_per_rev=300"]
    for spec in specs:
        if "sweep:" in spec.read_text():
            yield "sweep", ["sweep", spec, *few, *(["--set", "motion.duration=0.4"] if "motion:" in spec.read_text() else [])]
    yield "sweep", ["sweep", arm, *few, "--set", "sweep=[{key: filters.velocity.lowpass.cutoff, values: [50, 1e5]}]", "--statistics", "max"]
    design = folder / "design.yaml"
    design.write_text(DESIGN.format(urdf=arm.parent / "kuka_lwr.urdf"))
    yield "design", ["design", design]
    yield "design", ["design", design, "--set", "requirements[0].at_most=1 nm"]
    yield "design", ["design", design, "--set", "design.minimize=position.x.sigma", "--set", "design.budget=110"]
    for effects in (EFFECTS, SPREAD):
        yield "analyze", ["analyze", DIAGNOSIS, "--set", effects]
        yield "simulate", ["simulate", DIAGNOSIS, "--set", effects, "--log", folder / "log.csv"]
        yield "diagnose", ["diagnose", DIAGNOSIS, folder / "log.csv", "--write-model", folder / "found.yaml", "--force"]
    yield "simulate", ["simulate", DIAGNOSIS, "--runs", "3"]
    moving = CONFIGS / "phantom_premium" / "experiment.yaml"
    yield "simulate", ["simulate", moving, "--tracking"]
    yield "simulate", ["simulate", moving, "--cutoffs", "velocity_1=10Hz..100Hz"]
    yield "analyze", ["analyze", arm, *few, "--above", "position.xyz.worst_case=50um", "--above", "position.x.sigma=1 m"]
    yield "analyze", ["analyze", arm, *few, "--set", "encoders={'*': {bits: 17, accuracy: 20 arcsec, gear_accuracy: 0, max_count_rate: 1 MHz}}", "--set", "frame=tip",
                      "--set", "coordinates=[x, y, z, rx, ry, rz]"]
    yield "plan", ["diagnose", DIAGNOSIS, "--plan"]
    yield "filter", ["filter", FILTERS, "--coefficients", "--at", "5,10", "--motion-band", "0.5Hz", "5Hz"]
    yield "filter", ["filter", CONFIGS / "phantom_premium" / "spec.yaml", "--noise", "--speed", "2rad/s,0.3", "--sine", "40", "3Hz"]
    yield "filter", ["filter", CONFIGS / "phantom_premium" / "spec.yaml", "--estimators", "--clock", "1MHz"]
    yield "threshold", ["threshold", *sorted((CONFIGS / "table_iv").glob("*.yaml"))]
    for urdf in sorted(CONFIGS.glob("*/*.urdf")):
        yield "robot", ["robot", urdf]
    for kind in ("effects", "filters", "encoders", "formats", "coordinates", "statistics"):
        yield "list", ["list", kind]


def required_members(schema, path=()):
    """Paths of the members that every report has, through objects."""
    for name in schema.get("required", []):
        yield (*path, name)
        yield from required_members(schema["properties"][name], (*path, name))


def without(report, path):
    changed = copy.deepcopy(report)
    at = changed
    for name in path[:-1]:
        at = at[name]
    del at[path[-1]]
    return changed


def main():
    qerr, t = program_and_tally()
    validators, seen = {}, set()
    with tempfile.TemporaryDirectory() as temporary:
        for name, words in reports(qerr, pathlib.Path(temporary)):
            if name not in validators:
                schema = json.loads(run(qerr, "schema", "--output-of", name).out)
                jsonschema.Draft202012Validator.check_schema(schema)
                validators[name] = jsonschema.Draft202012Validator(closed(schema))
            title = " ".join(pathlib.Path(str(w)).name if pathlib.Path(str(w)).is_absolute() else str(w) for w in words)
            ran = run(qerr, *words, "-q", "--format", "json")
            if not t.check(f"{title}: runs", ran.code in (0, 1), ran.err.decode()[:300]):
                continue
            report = json.loads(ran.out)
            faults = [f"{error.json_path}: {error.message[:200]}" for error in validators[name].iter_errors(report)]
            t.check(f"{title}: as its schema says", not faults, "; ".join(faults[:3]))
            if name in seen or not isinstance(report, dict):
                continue
            seen.add(name)
            for path in required_members(validators[name].schema):
                t.check(f"{name} without {'.'.join(path)} is rejected", not validators[name].is_valid(without(report, path)))
    answered = run(qerr, "schema", "--output-of", "nothing").err.decode()
    t.check("every report has a case here", all(word in answered for word in validators) and answered.count(", ") == len(validators),
            answered)
    return t.close()


if __name__ == "__main__":
    sys.exit(main())
