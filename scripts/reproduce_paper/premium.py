"""The experiment of Sec. VI: specs of its runs, shared by Figs. 12 and 13 and by the claims about them."""
import math

SPEC = "configs/phantom_premium/experiment.yaml"
STEP = 1e-3  # rad, the artificial quantization
CUTOFFS = (10, 20, 30, 50, 70, 100, 150, 200)
ORDERS = (1, 2, 3)
# t1, t2, t3 [deg]; the paper gives none but the zero position.
CONFIGURATIONS = {
    "zero": (0, 0, 0),
    "A": (20, 0, 0),
    "B": (0, 25, 0),
    "C": (0, 0, 30),
    "D": (20, 30, 40),
    "E": (-20, -10, 20),
}
AVERAGED = 500  # runs with random sub-count phases
SINGLE = 24  # runs that are evaluated individually


def centers(angles):
    """t1, t2, t3 [rad] -> the joints of the URDF, whose elbow is t3 - t2."""
    t1, t2, t3 = angles
    values = {"waist": t1, "shoulder": t2, "elbow": t3 - t2}
    return {f"motion.joints.{name}.center": f"{value:.9g} rad" for name, value in values.items()}


def radians(angles):
    return tuple(map(math.radians, angles))


def displaced(angles, run):
    """The same configuration, shifted by a random fraction of a count in every angle."""
    return tuple(
        a + STEP * ((0.37 + run * irrational) % 1 - 0.5)
        for a, irrational in zip(angles, (0.8191725134, 0.6710436067, 0.5497004779))
    )


def aligned(angles):
    """The nearest configuration at an integer number of counts from zero: all quantizers are in phase."""
    return tuple(STEP * round(a / STEP) for a in angles)


def filters(cutoffs=CUTOFFS):
    """--set that replaces the spec's filters: d1n2_50 and so on."""
    entry = (
        "d{d}n{n}_{f}: {{derivative: {d}, sample_rate: 1 kHz, "
        "lowpass: {{family: first_order, order: {n}, cutoff: {f} Hz}}}}"
    )
    text = ", ".join(entry.format(d=d, n=n, f=f) for d in (1, 2) for n in ORDERS for f in cutoffs)
    return {"filters": "{" + text + "}"}


def results(command):
    """(filter, coordinate) -> row of figures."""
    rows = command.rows()
    words = ("filter", "coordinate", "unit")
    return {
        (r["filter"], r["coordinate"]): {k: float(v) for k, v in r.items() if k not in words and v}
        for r in rows
    }


def spread(runs, key, field="sigma_simulated"):
    """Minimum and maximum of several results."""
    values = [run[key][field] for run in runs]
    return min(values), max(values)
