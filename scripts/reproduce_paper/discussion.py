"""Sec. VII: claims about today's robots, slow motion, other filters and dither."""
import math

from claims import CONFIRMED, LOOSE, WRONG, Claim, confirmed_if, number, numbers, within
from quantized_sine import SPEC as ONE_JOINT  # Delta = 1 mm, f = 1 kHz
from section_v import ORDERS, SPEC, spaced
from tables import TABLE_4

N2 = "{velocity: {derivative: 1, sample_rate: 1 kHz, lowpass: {family: first_order, order: 2, cutoff: 50 Hz}}}"


def _thresholds(qerr, rate=1000):
    """Peak speeds [counts per sample] from which IPQN holds to 10 % and 1 %, d = 1, n = 2, f0 = 50 Hz."""
    command = qerr("filter", SPEC, "--noise", set={"filters": N2.replace("1 kHz", f"{rate} Hz")})
    found = command.json()["filters"][0]
    return found["ipqn_within_10_percent_above"], found["ipqn_within_1_percent_above"]


def robots(qerr, out):
    tenth, hundredth = _thresholds(qerr)
    rows = qerr("threshold", *(f"configs/table_iv/{name}.yaml" for name, *_ in TABLE_4)).rows()
    speeds = [float(row["threshold_velocity_mm_s"]) for row in rows]
    fine = [1000 * float(row["resolution_mm"]) for row in rows]
    return Claim(
        "Sec. VII",
        "Essentially all of the robots feature fine resolution, and meet IPQN to a high approximation",
        "in words",
        (
            f"Premium, WAM, Kuka, Omni, Puma, with 2 pi: resolution {numbers(fine)} um; velocity, n = 2, f0 = 50 Hz:"
            f" IPQN holds to 10 % from peak speeds of {numbers(tenth * s for s in speeds)} mm/s, to 1 % from"
            f" {numbers(hundredth * s / 1000 for s in speeds)} m/s"
        ),
        LOOSE if max(speeds) * tenth > 100 else confirmed_if(max(speeds) * hundredth < 1000),
        "To 10 % at usual speeds of WAM, Kuka and Puma, for Premium and Omni in fast motion only; to 1 % for WAM and Kuka",
    )


def low_rate(qerr, out):
    rates = (200, 500, 1000, 4000, 10_000)
    speeds = [_thresholds(qerr, rate)[0] for rate in rates]
    counts = [v * rate for v, rate in zip(speeds, rates)]
    rising = all(a < b for a, b in zip(counts, counts[1:]))
    return Claim(
        "Sec. VII",
        "If the sample rate is sufficiently low, the conditions of IPQN are met",
        "in words",
        (
            f"velocity, n = 2, f0 = 50 Hz, f = {numbers(rates, 5)} Hz: IPQN holds to 10 % from {numbers(speeds)} counts"
            f" per sample, that is from {numbers(counts)} counts per second"
        ),
        confirmed_if(rising, LOOSE),
        "On average over speeds (row 28)",
    )


def slow(qerr, out):
    """Low-passed FDM against ITM, where IPQN fails."""
    one = {"filters": N2}
    report = qerr("filter", ONE_JOINT, "--estimators", set=one).json()
    fdm = report["filters"][0]["l1_norm"]["upper"] / 2 / 1000  # [Delta f]
    itm = {}
    for step in range(40):  # see estimators.py: other clocks give the speeds in between
        stretch = 10 ** (step / 40)
        rows = qerr("filter", ONE_JOINT, "--estimators", "--clock", f"{1000 * stretch:.9g}Hz", set=one).rows()
        for row in rows:
            if row["estimator"] == "inverse_time" and row["bound"] == "varying" and row["error"]:
                itm[float(row["quanta_per_sample"]) / stretch] = float(row["error"]) / stretch
    better = max(v for v, error in itm.items() if error < fdm)
    timed = 1000 * max(v for v, error in itm.items() if 1000 * error < fdm)  # the same in units of a clock of 1000 f
    worse = [error for v, error in itm.items() if error > fdm and v < 1]
    tenth, hundredth = _thresholds(qerr)
    return Claim(
        "Sec. VII",
        "Where IPQN does not apply, FDM with low-pass should not be used; ITM is better",
        "in words",
        (
            f"worst case of a velocity: FDM behind n = 2, f0 = 50 Hz {number(fdm)} Delta f at every speed; ITM less up to"
            f" {number(better, 2)} Delta f, more from there to Delta f (up to {number(max(worse))} Delta f), no bound above;"
            f" ITM with a clock of 1 MHz, 1000 f, less up to {number(timed, 2)} Delta f;"
            f" IPQN is off by more than 10 % up to {number(tenth)} Delta f, by more than 1 % up to {number(hundredth)} Delta f"
        ),
        WRONG if timed < tenth else LOOSE if better < 0.9 else CONFIRMED,
        (
            "With edges timed in whole samples, as in App. A, below Delta f/3 only: IPQN fails above, too, where ITM has no"
            " bound. True of ITM with a fast timer. It delays by a count, Delta/v, a low-pass by a constant time"
        ),
    )


def nothing_to_say(qerr, out):
    speeds = (0.05, 0.1017, 0.2017, 0.5017)
    scale = {"encoders.slider": "{resolution: 1 um}", "filters": N2}
    listed = ",".join(map(str, speeds))
    found = qerr("filter", ONE_JOINT, "--noise", "--speed", listed, set=scale).json()["filters"][0]["in_motion"]
    theory = [r["sigma"] / r["sigma_ipqn"] for r in found]
    gap = 0
    for v, ratio in zip(speeds, theory):
        motion = {"motion.joints.slider": f"{{velocity: {v:.9g} mm/s}}", "motion.settling": "0.2 s"}
        r = qerr("simulate", ONE_JOINT, "--runs", 20, set={**scale, **motion}).json()["results"]
        r = next(row for row in r if row["filter"] == "velocity")
        gap = max(gap, abs(r["sigma_simulated"] / r["sigma_ipqn"] / ratio - 1))
    return Claim(
        "Sec. VII",
        "Where IPQN does not apply, not much can be said about the error of a derivative",
        "in words",
        (
            f"velocity, n = 2, f0 = 50 Hz, constant {numbers(speeds, 4)} counts per sample: sigma over IPQN"
            f" {numbers(theory)} by the harmonics of the error, a simulation {within(gap, 1e-3)}"
        ),
        WRONG if gap < 0.02 else LOOSE,
        "Sigma is exact at any constant speed and along any motion; the worst case (26) holds always",
    )


def structures(qerr, out):
    families = ("first_order", "butterworth", "bessel", "chebyshev1")
    extra = {"chebyshev1": ", ripple: 1"}

    def sigmas(cutoff):
        entries = [
            f"{family}{n}: {{derivative: 1, sample_rate: 1 kHz, lowpass: {{family: {family}, order: {n},"
            f" cutoff: {cutoff:.9g} Hz{extra.get(family, '')}}}}}"
            for family in families
            for n in ORDERS
        ]
        found = qerr("filter", SPEC, set={"filters": "{" + ", ".join(entries) + "}"}).json()["filters"]
        return {f["name"]: f["h2_norm"] for f in found}

    low, high = spaced(0.5, 499, 60)[0], spaced(0.5, 499, 60)[10]
    at_low, at_high, nominal = sigmas(low), sigmas(high), sigmas(50)
    slopes = {
        family: [math.log(at_high[f"{family}{n}"] / at_low[f"{family}{n}"]) / math.log(high / low) for n in ORDERS]
        for family in families
    }
    alike = max(abs(a - b) for s in slopes.values() for a, b in zip(s, slopes["first_order"]))
    values = "; ".join(f"{f} {numbers(nominal[f'{f}{n}'] for n in ORDERS)}" for f in families)
    falls = all(nominal[f"{f}{n + 1}"] < nominal[f"{f}{n}"] for f in families for n in (1, 2, 3))
    return Claim(
        "Sec. VII",
        "The results for other structures with a cut-off and an order are similar",
        "in words",
        (
            f"velocity, n = 1..4, exponents of f0: {numbers(slopes['first_order'])}, the other families' within"
            f" {number(alike, 1)}; sigma_v/sigma_x at 50 Hz [1/s]: {values}"
        ),
        LOOSE if alike < 0.05 else confirmed_if(falls),
        (
            f"Exponents are alike; but from n = 2 to 4 sigma falls to {_percent(nominal, 'first_order')} % for the cascade,"
            f" whose -3 dB frequency falls, too, and to {_percent(nominal, 'butterworth')} % for Butterworth"
        ),
    )


def _percent(sigmas, family):
    return number(100 * sigmas[f"{family}4"] / sigmas[f"{family}2"], 2)


def dither(qerr, out):
    """Noise before the quantizer at a speed of whole counts per sample, where the error is far from white."""
    scale = {"encoders.slider": "{resolution: 1 um}", "filters": N2}
    motions = {"at 10 counts per sample": "{velocity: 10 mm/s}", "at 0.01": "{velocity: 0.01 mm/s}"}
    sigmas = (0, 0.25, 0.5)
    texts, white = [], 0
    for where, motion in motions.items():
        ratios = []
        for sigma in sigmas:
            overrides = {**scale, "motion.joints.slider": motion, "motion.settling": "0.2 s"}
            if sigma:
                overrides["effects"] = f"[{{type: noise, joint: slider, sigma: {sigma} um}}]"
            rows = qerr("simulate", ONE_JOINT, "--runs", 2000, set=overrides).json()["results"]
            found = next(r for r in rows if r["filter"] == "velocity")
            ipqn = 1e-6 / math.sqrt(12) * _norm(qerr, scale)
            ratio = found["sigma_simulated"] / ipqn
            ratios.append(ratio if ratio > 1e-6 else 0)  # rounding errors
            if sigma == max(sigmas):
                white = max(white, abs(ratios[-1] / math.sqrt(1 + 12 * sigma**2) - 1))
        texts.append(f"{numbers(ratios)} {where}")
    return Claim(
        "Sec. VII",
        "Dither makes the noise of an encoder more like PQN",
        "in words",
        (
            f"velocity, n = 2, white noise of {numbers(sigmas)} counts before the quantizer: sigma over IPQN"
            f" {', '.join(texts)}; with half a count {number(100 * white, 1)} % from sqrt(1 + 12 sigma^2), independent white errors"
        ),
        confirmed_if(white < 0.05),
        "It also adds its own variance: with half a count, sigma is twice IPQN's",
    )


def _norm(qerr, overrides):
    return qerr("filter", ONE_JOINT, set=overrides).json()["filters"][0]["h2_norm"]
