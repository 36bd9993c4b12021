"""Tables II, III and IV."""
import math

import independent
from claims import LOOSE, WRONG, Claim, confirmed_if, number, numbers, rounds_to, within
from section_v import spaced
from tool import write_csv

SECTION_V = "configs/paper/section_v.yaml"
EXPERIMENT = "configs/phantom_premium/experiment.yaml"


def table_2(qerr, out):
    """The summary of both error models, with the figures of the Premium in its zero position."""
    command = qerr("analyze", EXPERIMENT)
    report = command.json()
    rows = [
        ["joint", joint["name"], joint["unit"], "Delta/2", joint["worst_case"], "Delta/sqrt(12)", joint["sigma"]]
        for joint in report["joints"]
    ]
    tip = ("operational", "|J| Delta/2", "sqrt(diag(J Sigma J^T))", report["position"])
    behind = [(d["filter"], "||H||_l1 |x|", "||H||_2 sigma_x", d["coordinates"]) for d in report["derivatives"]]
    for space, general, stochastic, coordinates in [tip, *behind]:
        for c in coordinates:
            worst, sigma = c["worst_case"]["max"], c["sigma"]["max"]
            rows.append([space, c["coordinate"], c["unit"], general, worst, stochastic, sigma])
    write_csv(
        out / "table_2.csv",
        ["space", "quantity", "unit", "general", "worst_case", "independent_pqn", "sigma"],
        rows,
    )

    jacobian = independent.premium_jacobian((0, 0, 0))
    expected = independent.ipqn_sigma(jacobian, [1e-3] * 3)
    gap = max(abs(c["sigma"]["max"] / s - 1) for c, s in zip(report["position"], expected))
    for d in report["derivatives"]:
        order = int(d["filter"][-1])
        h2 = independent.h2_by_lyapunov(d["derivative"], order, 50, 1000)
        l1 = independent.l1_by_sum(d["derivative"], order, 50, 1000)
        gap = max(gap, abs(d["h2_norm"] / h2 - 1), abs(d["l1_norm"]["upper"] / l1 - 1))
    extra = independent.steady_covariance(*independent.controller_form(1, 1, 50, 1000)[:2])[0, 0]
    fir = independent.steady_covariance(*independent.controller_form(2, 0, 50, 1000)[:2])[0, 0]
    return [
        Claim(
            "Table II; (16)-(28), (37), (38)",
            "Joint, operational and derivative error: worst cases and sigmas",
            "formulas",
            (
                "Premium, zero position: qerr, and an own Jacobian with (37) solved and sum |h| taken, agree"
                f" {within(gap, 1e-13)}"
            ),
            confirmed_if(gap < 1e-9),
            'Its caption, "nominal filter parameters", is another table\'s',
        ),
        Claim(
            "Sec. IV-C",
            "In controller canonical form the state holds the last positions",
            "in words",
            (
                f"Variance of a state over sigma_e^2: {number(fir)} without low-pass (d = 2),"
                f" {number(extra)} with one (d = n = 1)"
            ),
            confirmed_if(abs(extra - 1) < 1e-9),
            "True without feedback only: with it the states are filtered positions",
        ),
    ]


RATES = spaced(120, 3000, 150) + spaced(5000, 1e6, 10)  # the exceptions lie below 3 kHz
FAMILIES = ("matched", "tustin", "prewarped", "backward_euler")
CASES = [(d, n) for d in (1, 2, 3) for n in (1, 2, 3, 4, 5)]


def _norms_at(qerr, rate):
    """(discretization, d, n) -> H2 norm at one sample rate, in one run."""
    entry = (
        "{0}_{1}_{2}: {{derivative: {1}, sample_rate: {3:.9g} Hz, "
        "lowpass: {{family: first_order, order: {2}, cutoff: 50 Hz, discretization: {0}}}}}"
    )
    spec = ", ".join(entry.format(family, d, n, rate) for family in FAMILIES for d, n in CASES)
    found = qerr("filter", SECTION_V, set={"filters": "{" + spec + "}"}).json()["filters"]
    names = [(family, d, n) for family in FAMILIES for d, n in CASES]
    return dict(zip(names, (f["h2_norm"] for f in found)))


def table_3(qerr, out):
    """sigma = ||H||_2 sigma_x as a function of the sample rate, for every discretization of the low-pass."""
    norms = [_norms_at(qerr, rate) for rate in RATES]
    rows, slopes, limits, against = [], [], {}, {}
    for key in norms[0]:
        family, d, n = key
        series = [at[key] for at in norms]
        slope = math.log(series[-1] / series[-2]) / math.log(RATES[-1] / RATES[-2])
        slopes.append(slope - (d - n if n < d else 0 if n == d else -0.5))
        other_way = [rate for rate, a, b in zip(RATES[1:], series, series[1:]) if (b > a) == (n > d)]
        if other_way:
            against[key] = max(other_way)
        if n == d:
            limits.setdefault(family, []).append(series[-1] / (2 * math.pi * 50) ** d)
        rows += [[*key, rate, value, slope] for rate, value in zip(RATES, series)]
    write_csv(
        out / "table_3.csv",
        ["discretization", "derivative", "order", "sample_rate [Hz]", "h2_norm [1/s^d]", "exponent_at_1_MHz"],
        rows,
    )
    off = max(map(abs, slopes))

    def of(*families):
        return [key for key in against if key[0] in families]

    equal = {family: rate for (family, d, n), rate in against.items() if n == d}
    settled = max(against.values()) / 50
    return [
        Claim(
            "Table III",
            "Error as f rises, f0 < f/2: rises for n < d and for n = d, falls for n > d",
            "up, up, down",
            f"{len(RATES)} rates from 120 Hz to 1 MHz, f0 = 50 Hz, d = 1..3, n = 1..5: somewhere the other way in"
            f" {len(of('matched'))} of 15 cases for matched poles, in {len(of(*FAMILIES[1:]))} of 45 for the other"
            f" discretizations; for n = d with {' and '.join(equal) or 'none'}; in none above {number(settled)} f0",
            LOOSE if off < 0.02 else WRONG,
            f"True from about f = {math.ceil(settled)} f0 on, not from 2 f0 on",
        ),
        Claim(
            "Table III",
            "It tends to a value: no for n < d, yes for n = d, yes for n > d",
            "no, yes, yes",
            (
                f"exponents of f: d - n, 0, -1/2 (at 1 MHz {within(off, 2e-3)}); limits for n = d over w0^d:"
                f" matched {numbers(limits['matched'])}, Tustin {numbers(limits['tustin'])}"
            ),
            LOOSE if off < 0.02 else WRONG,
            "For n > d the value is 0",
        ),
    ]


# Rows of Table IV as printed: folder, label, n G as stated, Delta_x [mm], Delta_x f [mm/s].
TABLE_4 = [
    ("premium", "Premium", ".03", "15.0"),
    ("wam", "WAM (7dof)", None, "0.2"),
    ("kuka", "Kuka", ".05", "0.5"),
    ("omni", "Omni", ".055", "10.0"),
    ("puma", "Puma", ".01", "5"),
]


def table_4(qerr, out):
    command = qerr("threshold", *(f"configs/table_iv/{name}.yaml" for name, *_ in TABLE_4))
    rows, resolution_bad, speed_bad, factor = [], [], [], []
    for (_, label, printed_step, printed_speed), row in zip(TABLE_4, command.rows()):
        step, speed = float(row["resolution_mm_as_printed"]), float(row["threshold_velocity_mm_s_as_printed"])
        true_step, true_speed = float(row["resolution_mm"]), float(row["threshold_velocity_mm_s"])
        factor.append(true_step / step)
        if printed_step and not rounds_to(step, printed_step):
            resolution_bad.append(f"{label} {number(step)}")
        if not rounds_to(speed, printed_speed):
            speed_bad.append(f"{label} {number(speed)}")
        rows.append(
            [
                label,
                row["counts_per_rev"],
                row["gear_ratio"],
                row["length_mm"],
                row["sample_rate_hz"],
                printed_step or "?",
                step,
                true_step,
                printed_speed,
                speed,
                true_speed,
            ]
        )
    write_csv(
        out / "table_4.csv",
        [
            "robot",
            "n",
            "G",
            "l [mm]",
            "f [Hz]",
            "printed Delta_x [mm]",
            "(43) [mm]",
            "with 2 pi [mm]",
            "printed Delta_x f [mm/s]",
            "(44) [mm/s]",
            "with 2 pi [mm/s]",
        ],
        rows,
    )
    return [
        Claim(
            "(43), (44)",
            "Delta_x = l/(nG), n in counts per revolution",
            "l/(nG)",
            f"an angle of one count moves the tip by {number(factor[0], 5)} l/(nG)",
            confirmed_if(abs(factor[0] - 1) < 1e-9),
            "2 pi is missing",
        ),
        Claim(
            "Table IV",
            "Delta_x of Premium, Kuka, Omni, Puma [mm]",
            ".03, .05?, .055, .01?",
            "(43) gives " + (", ".join(resolution_bad) or "the same"),
            confirmed_if(not resolution_bad),
            "None follows from the table's own n, G, l; with 2 pi they do not either",
        ),
        Claim(
            "Table IV",
            "Delta_x f of Premium, WAM, Kuka, Omni, Puma [mm/s]",
            "15.0, 0.2, 0.5, 10.0, 5",
            "(44) gives "
            + (", ".join(speed_bad) + "; the others round as printed" if speed_bad else "the same"),
            confirmed_if(not speed_bad),
            "Omni is half; with 2 pi all are 6.28 times as fast",
        ),
    ]
