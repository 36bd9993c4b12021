"""Sec. VI-A: a truth that is quantized itself. App. B: the ripples of the spectrum."""
import math

import numpy as np

import independent
import premium
from claims import LOOSE, WRONG, Claim, number, numbers
from quantized_sine import AMPLITUDE, SPEC
from time_domain import angles_of
from whiteness import white_share


def quantized_truth(qerr, out):
    """The experiment as the paper did it: the robot's own counts of 0.125 mrad, quantized again to 1 mrad."""
    fine = premium.STEP / 8
    sigmas, means = [], {}
    for name in ("zero", "D"):
        overrides = premium.centers(premium.radians(premium.CONFIGURATIONS[name]))
        overrides["encoders"] = f"{{'*': {{resolution: {1e3 * fine:g} mrad}}}}"
        for joint in ("waist", "shoulder"):
            overrides[f"motion.joints.{joint}.sines.0.frequency"] = "2.4142 Hz"
        truth, coarse = angles_of(qerr("simulate", premium.SPEC, set=overrides).file("--log"))
        counts = np.rint(coarse / premium.STEP)  # the log's counts: angles_of takes them for 1 mrad
        own = counts * fine
        measured = np.sign(counts) * np.floor(np.abs(counts) / 8 + 0.5) * premium.STEP  # half a count away from 0
        ipqn = premium.STEP / math.sqrt(12)
        sigmas.append(((measured - own)[:, 0].std() / ipqn, (measured - truth)[:, 0].std() / ipqn))
        tip = independent.premium_tip
        means[name] = [1e6 * float(np.abs((tip(measured) - tip(x)).mean(axis=0)).max()) for x in (own, truth)]
    return Claim(
        "Sec. VI-A",
        "The signal without artificial quantization acts as truth (it has the robot's 0.125 mrad)",
        "in words",
        (
            "qerr's log at 0.125 mrad, rounded again to 1 mrad (halves away from 0), 2.4142 Hz: sigma of the waist over"
            f" IPQN {number(sigmas[0][0], 4)} against that truth, {number(sigmas[0][1], 4)} against the true angle"
            f" (by counting sqrt(1 + 2/64) = {number(math.sqrt(1 + 2 / 64), 4)} and sqrt(1 + 3/64) ="
            f" {number(math.sqrt(1 + 3 / 64), 4)}); largest mean of x, y, z at zero"
            f" {number(means['zero'][0], 2)} um, at (20, 30, 40) deg {number(means['D'][0], 2)} um"
        ),
        LOOSE,
        (
            "Good to 3 % of sigma; but one error in 8 is exactly half a count, so that rounding away from 0 gives a mean"
            " of 1/16 count wherever the angles keep their sign"
        ),
    )


def ripples(qerr, out):
    peaks = (2 / math.pi, math.pi / 2, 4.0, 10.0)
    ripples = [100 * (1 - white_share(peak)) for peak in peaks]
    entry = "n{0}: {{derivative: 1, sample_rate: 1 kHz, lowpass: {{family: first_order, order: {0}, cutoff: 50 Hz}}}}"
    filters = {"filters": "{" + ", ".join(map(entry.format, (1, 2, 3))) + "}"}
    worst = []
    for peak in peaks:
        frequency = peak * 1000 / (2 * math.pi * AMPLITUDE)
        command = qerr("filter", SPEC, "--sine", AMPLITUDE, f"{frequency:.9g}Hz", set=filters)
        ratios = [f["in_motion"][0]["sigma"] / f["in_motion"][0]["sigma_ipqn"] for f in command.json()["filters"]]
        worst.append(max(ratios, key=lambda r: abs(math.log(r))))
    constant = qerr("filter", SPEC, "--noise", "--speed", "20", set=filters).json()["filters"]
    line = max(f["in_motion"][0]["sigma"] / f["in_motion"][0]["sigma_ipqn"] for f in constant)
    return Claim(
        "App. B",
        "The spectrum has some ripples for any f; their power is small compared to the noise",
        "in words",
        (
            f"sine with a peak of {numbers(peaks)} counts per sample: {numbers(ripples, 2)} % of the power is above the mean"
            f" level; most extreme sigma over IPQN of a velocity, n = 1..3, 50 Hz: {numbers(worst)}; at a constant 20"
            f" counts per sample {number(line)}"
        ),
        LOOSE if ripples[2] < 10 else WRONG,
        "Small for fast sines; at constant speed all power is in lines, and a filter may pass or stop them",
    )
