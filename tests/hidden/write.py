"""A case as files: spec.yaml (the ideal model), robot.urdf, log.csv and log2.csv, truth.json."""
import json
import math

import numpy as np


def digits(step, finer=400):
    """Decimals of a grid that is `finer` times finer than the step."""
    return max(3, math.ceil(-math.log10(step / finer)))


def spec(case):
    rate, robot = case.rate, case.robot
    lines = ["qerr: 1", "robot:", "  urdf: robot.urdf", "  base: base_link", "  tip: tool0", "encoders:"]
    lines += [f"  {j}: {e.spec()}" for j, e in zip(robot.joints, case.encoders)]
    if case.coupling is not None:
        lines.append(f"coupling: {json.dumps(case.coupling)}")
    lines += ["coordinates: [x, y, z]", "filters:",
              f"  velocity: {{derivative: 1, sample_rate: {rate:g} Hz, lowpass: {{family: first_order, order: "
              f"{case.filter_order}, cutoff: {case.cutoff:g} Hz}}}}",
              "configurations: {method: sobol, count: 1000, seed: 1}", "motion:", f"  sample_rate: {rate:g} Hz",
              "  duration: 5 s", "  joints:"]
    for j, path in zip(robot.joints, case.spec_motion.joints):
        sines = ", ".join(f"{{amplitude: {a:.8g}, frequency: {f:.6g} Hz, phase: {p:.6g}}}" for a, f, p in path.sines)
        lines.append(f"    {j}: {{center: {path.centre:.8g}, sines: [{sines}]}}")
    return "\n".join(lines) + "\n"


def significant(x):
    return np.char.mod("%.4g", x)


def columns(case, record):
    """(header, texts) of the log."""
    robot, resolution = case.robot, [e.resolution for e in case.encoders]
    stamp_digits = 6 if case.uneven else max(3, len(f"{1 / case.rate:.6f}".rstrip("0")) - 2)
    yield "time [s]", np.char.mod(f"%.{stamp_digits}f", record.time)
    for i, j in enumerate(robot.joints):
        unit = robot.unit(i)
        if i in case.logged_as_measured:
            yield f"{j}.measured [{unit}]", np.char.mod(f"%.{case.logged_as_measured[i]}f", record.measured[i])
        else:
            yield f"{j}.counts", np.char.mod("%d", record.counts[i])
        if case.reference in ("joints", "both"):
            step = min(resolution[i], 20 * case.reference_noise[i]) if case.reference_noise[i] else resolution[i]
            yield f"{j}.reference [{unit}]", np.char.mod(f"%.{digits(step)}f", record.reference[i])
        if "effort" in case.columns:
            yield f"{j}.effort [{'N' if unit == 'm' else 'N m'}]", significant(record.effort[i])
        if "velocity" in case.columns:
            yield f"{j}.velocity [{unit}/s]", np.char.mod("%.7f", record.velocity[i])
        if "command" in case.columns:
            yield f"{j}.command [{unit}]", np.char.mod(f"%.{digits(resolution[i], 10)}f", record.link[i])
        if "temperature" in case.columns and i == case.warm_joint:
            yield f"{j}.temperature [degC]", np.char.mod("%.6g", np.round(16 * case.temperature(record.time)) / 16)
    if case.reference in ("tip", "both"):
        for k, name in enumerate("xyz"):
            yield f"tip.{name} [m]", np.char.mod(f"%.{digits(case.tip_noise, 20)}f", record.tip[:, k])


def log(case, record, path):
    head, texts = zip(*columns(case, record))
    with open(path, "w", encoding="utf-8") as out:
        if case.comment:
            out.write(f"# recorded at {case.rate:g} Hz\n")
        out.write(",".join(head) + "\n")
        out.writelines(",".join(row) + "\n" for row in zip(*texts))


def case_files(case, folder):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "spec.yaml").write_text(spec(case), encoding="utf-8")
    (folder / "robot.urdf").write_text(case.robot.urdf(), encoding="utf-8")
    log(case, case.record, folder / "log.csv")
    if case.record2 is not None:
        log(case, case.record2, folder / "log2.csv")
    (folder / "truth.json").write_text(json.dumps(case.truth, indent=1, default=plain) + "\n", encoding="utf-8")


def plain(x):
    if isinstance(x, np.generic):
        return x.item()
    if isinstance(x, np.ndarray):
        return x.tolist()
    raise TypeError(type(x))
