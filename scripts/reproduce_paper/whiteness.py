"""Appendix B: whiteness of the error of a moving quantizer (57, 58)."""

import math

import numpy as np

from claims import CONFIRMED, LOOSE, WRONG, Claim, number, numbers, rounds_to
from quantized_sine import AMPLITUDE, SPEC
from section_v import SPEC as SECTION_V
from tool import write_csv


def share_above_nyquist(peak):
    """Fraction of the power of a slow sine's error above f/2, before sampling.

    The error's harmonic k, sin(2 pi k x), has 6/(pi k)^2 of the power; its frequency spreads like
    k peak sin(phi), in cycles per sample.
    """
    k = np.arange(1, 20_001)
    above = 2 / math.pi * np.arccos(np.minimum(1, 0.5 / (k * peak)))
    tail = 6 / (math.pi**2 * k[-1])
    return float((6 / (math.pi * k) ** 2 * above).sum() + tail)


def white_share(peak):
    """1 - integral (S - 1)+, S the sampled error's spectrum over its mean; from the same harmonics, folded.

    Those beyond the 60th, 1 % of the power, spread over many times the sample rate: they are taken as flat.
    """
    bins = 4000
    edges = np.linspace(-0.5, 0.5, bins + 1)
    spectrum = np.zeros(bins)
    for k in range(1, 61):
        width = k * peak
        for fold in range(-int(width) - 1, int(width) + 2):
            cumulated = np.arcsin(np.clip((edges + fold) / width, -1, 1)) / math.pi
            spectrum += 6 / (math.pi * k) ** 2 * np.diff(cumulated) * bins
    spectrum += 1 - spectrum.mean()
    return float(1 - np.maximum(spectrum - 1, 0).mean())


def whiteness(qerr, out):
    rows = []
    for peak in (2 / math.pi, math.pi / 2, 4.0, 2 * math.pi):
        frequency = peak * 1000 / (2 * math.pi * AMPLITUDE)
        command = qerr(
            "simulate",
            SPEC,
            set={
                "motion.sample_rate": "64kHz",
                "motion.duration": "4s",
                "motion.joints.slider.sines.0.frequency": f"{frequency:.9g}Hz",
            },
        )
        log = command.file("--log")
        error = np.array([1e-3 * float(r["slider.counts"]) - float(r["slider.reference [m]"]) for r in log])
        power = np.abs(np.fft.rfft(error)) ** 2
        above = power[np.fft.rfftfreq(len(error), 1 / 64_000) > 500].sum() / power.sum()
        rows.append([peak, share_above_nyquist(peak), float(above), white_share(peak)])
    write_csv(
        out / "appendix_b_whiteness.csv",
        [
            "peak speed [counts per sample]",
            "share above Nyquist",
            "share above Nyquist, simulated",
            "white share",
        ],
        rows,
    )
    text = "; ".join(f"{number(100 * r[1])} % ({number(100 * r[2])} %) at {number(r[0])}" for r in rows)
    at_four = next(r for r in rows if r[0] == 4.0)
    good = 0.925 < at_four[1] < 0.975
    return [
        Claim(
            "(58)",
            "(1/2) pi A > Delta f ensures that 95 % of the error's power is white",
            "95 %",
            (
                f"power above f/2 (simulated), by peak speed in counts per sample: {text}; white share at 4: "
                f"{number(100 * at_four[3])} %"
            ),
            LOOSE if good else WRONG,
            "A factor f_i is missing; with it (58) is v > 4 Delta f, where about 94 % is white",
        )
    ]


def speed_of_the_experiment(qerr, out):
    """Root mean square and peak speed of the waist, from the log's reference."""
    command = qerr("simulate", "configs/phantom_premium/experiment.yaml")
    angle = np.array([float(r["waist.reference [rad]"]) for r in command.file("--log")])
    speed = np.abs(np.diff(angle)) / 1e-3  # counts of 1 mrad per sample
    rms = float(np.sqrt((speed**2).mean()))
    printed = float(angle.max() - angle.min()) / 2 * 2.5 / math.sqrt(2)
    return Claim(
        "(42), (57)",
        "v_RMS = 3 Delta f, fast enough for white error",
        "3",
        (
            f"RMS {number(rms, 4)}, peak {number(float(speed.max()))} Delta f, where (58) as mended asks for 4;"
            f" (42) as printed, with 2.5 Hz for omega, gives {number(printed)}"
        ),
        LOOSE if rounds_to(rms, "3") and speed.max() > 4 else WRONG,
        "The figure is right; the formula lacks 2 pi",
    )


def constant_speed(qerr, out):
    command = qerr("filter", SECTION_V, "--noise", "--speed", "10,10.00006,10.5,1000.00006")
    ratio, thresholds = {}, {}
    for f in command.json()["filters"]:
        thresholds[f["name"]] = (f["ipqn_within_10_percent_above"], f["ipqn_within_1_percent_above"])
        ratio[f["name"]] = [r["sigma"] / r["sigma_ipqn"] for r in f["in_motion"]]
    return Claim(
        "(57)",
        "v >> Delta f: the error is white",
        "in words",
        (
            "d = 1, n = 2, sigma over IPQN at a constant 10, 10.00006, 10.5, 1000.00006 counts per sample:"
            f" {numbers(ratio['d1n2'])}; slow sines need a peak of {number(thresholds['d1n2'][0])} for 10 %"
            f" and {number(thresholds['d1n2'][1])} for 1 %"
        ),
        LOOSE if ratio["d1n2"][3] < 0.5 else CONFIRMED,
        "Never at constant speed, however high; true on average over speeds, as along a sine",
    )
