"""The study's figures as text and CSV."""
import csv
import statistics
from dataclasses import dataclass

from score import binomial_lower, binomial_upper


@dataclass
class Criterion:
    """A rate that must be at least (or at most) a target; `hits` of `trials`, or a plain `value`."""
    text: str
    target: float
    at_least: bool
    hits: int = 0
    trials: int = 0
    value: float = None
    ceiling: float = None       # an upper limit of the rate

    @property
    def rate(self):
        return self.value if self.value is not None else (self.hits / self.trials if self.trials else None)

    def met(self):
        if self.rate is None:
            return None
        good = self.rate >= self.target if self.at_least else self.rate <= self.target
        return good and (self.ceiling is None or self.rate <= self.ceiling)

    def surely_missed(self):
        """Missed significantly (one-sided 99 %), for samples too small to test the rate itself."""
        if self.value is not None or not self.trials:
            return self.met() is False
        if self.at_least:
            return binomial_upper(self.hits, self.trials, 0.99) < self.target
        return binomial_lower(self.hits, self.trials, 0.99) > self.target

    def line(self):
        mark = {None: "  - ", True: "met ", False: "MISS"}[self.met()]
        wanted = f"{'>=' if self.at_least else '<='} {100 * self.target:.0f} %"
        if self.ceiling is not None:
            wanted = f"{100 * self.target:.0f}-{100 * self.ceiling:.0f} %"
        if self.rate is None:
            return f"{mark} {self.text:62} {'no case':>8}  wanted {wanted}"
        if self.value is not None:
            return f"{mark} {self.text:62} {100 * self.rate:6.1f} %  wanted {wanted}, {self.trials} cases"
        bounds = f"{100 * binomial_lower(self.hits, self.trials):.0f}-{100 * binomial_upper(self.hits, self.trials):.0f}"
        return f"{mark} {self.text:62} {100 * self.rate:6.1f} %  wanted {wanted}; {self.hits}/{self.trials} (each way 95 %: {bounds})"


def share(text, target, at_least, answers, good, ceiling=None):
    chosen = list(answers)
    return Criterion(text, target, at_least, sum(map(bool, map(good, chosen))), len(chosen), ceiling=ceiling)


def smallest(r):
    return min((e["amplitude_counts"] for e in r["truth"]["effects"]), default=0)


def criteria(results):
    """The lines 1 to 5 of the acceptance of `qerr diagnose`. A case without an answer counts as wrong."""
    of = lambda kinds: [r for r in results if r["truth"]["kind"] in kinds]
    right = lambda r: r["score"].get("right")
    b, c, clean, foreign = of("b"), of("c"), of("a"), of("d")
    intervals = [i for r in results for i in r["score"].get("intervals", [])]
    gains = [r["score"].get("gain") or 0.0 for r in b + c if reachable(r) > 1.1]
    second = [r for r in b + c if "second" in r]
    found = [r for r in second if r["score"].get("right")]
    again = [r for r in b + c if r.get("simulated") is not None]
    return [
        share("1 one effect of at least 1 count: named, nothing else", .95, True, [r for r in b if smallest(r) >= 1], right),
        share("1 one effect of 0.5 to 1 count: named, nothing else", .85, True, [r for r in b if .5 <= smallest(r) < 1], right),
        share("1 two effects: both named", .75, True, c, lambda r: all(r["score"].get("found") or [False])),
        share("2 clean logs: false alarms", .02, False, clean, lambda r: r["score"].get("false_alarm", True)),
        share("3 outside the catalogue: misnamed", .05, False, foreign, lambda r: r["score"].get("misnamed", True)),
        share("3 inseparable pairs: reported as such", .90, True, of("e"), right),
        Criterion("4 gain over what the true model reaches, median", .95, True, trials=len(gains),
                  value=statistics.median(gains) if gains else None),
        share("4 95 % intervals that hold the truth", .90, True, intervals, lambda i: i[3], ceiling=0.99),
        share("5 extended model on a second log: nothing_wrong", .95, True, second, lambda r: r["second"] == "nothing_wrong"),
        share("5 the same, where the cause was named right", .85, True, found, lambda r: r["second"] == "nothing_wrong"),
        share("5 simulate with the extended model: rms within 15 %", .85, True, again, lambda r: abs(r["simulated"] - 1) < .15),
    ]


def reachable(r):
    known = r["truth"].get("gain") or {}
    g = known.get("tip") if r["truth"].get("reference") == "tip" else known.get("all_joints")
    return (g or {}).get("ratio") or 1.0


def asides(results):
    """Figures in addition to the criteria, counted leniently."""
    b = [r for r in results if r["truth"]["kind"] == "b"]
    lines = []
    for text, chosen, good in [
            ("one effect: first cause right", b, lambda r: r["score"].get("first_right")),
            ("one effect: among the causes, whatever else", b, lambda r: all(r["score"].get("found") or [False])),
            ("two effects: both and nothing else", [r for r in results if r["truth"]["kind"] == "c"],
             lambda r: r["score"].get("right")),
            ("clean: declined to judge", [r for r in results if r["truth"]["kind"] == "a"], lambda r: r["score"].get("declined")),
            ("outside: not noticed at all", [r for r in results if r["truth"]["kind"] == "d"], lambda r: r["score"].get("missed")),
            ("inseparable: both reported", [r for r in results if r["truth"]["kind"] == "e"],
             lambda r: r["score"].get("both_reported")),
            ("no answer (crash, refusal, time)", results, lambda r: r["fault"])]:
        if chosen:
            n = sum(map(bool, map(good, chosen)))
            lines.append(f"     {text:62} {100 * n / len(chosen):6.1f} %  {n}/{len(chosen)}")
    joint = [r["score"]["joint_gain"] for r in results if r["score"].get("joint_gain")]
    if joint:
        lines.append(f"     {'gain of the first effect own joint over reachable, median':62} {100 * statistics.median(joint):6.1f} %")
    return lines


def row_name(truth):
    if truth["kind"] == "a":
        return "clean: " + truth["sub"]
    if truth["kind"] == "b":
        return truth["effects"][0]["effect"]
    return {"c": "two: ", "d": "outside: ", "e": "pair: "}[truth["kind"]] + ("" if truth["kind"] == "c" else truth["sub"])


def answer_name(r):
    """One word for an answer: its first cause, else its verdict."""
    if r["fault"]:
        return "no answer"
    return r["score"]["first"] or r["score"]["verdict"]


def confusion(results):
    """{truth: {answer: count}}"""
    out = {}
    for r in results:
        line = out.setdefault(row_name(r["truth"]), {})
        line[answer_name(r)] = line.get(answer_name(r), 0) + 1
    return out


def confusion_text(results):
    table = confusion(results)
    columns = sorted({a for line in table.values() for a in line}, key=lambda a: (a in ("nothing_wrong", "unexplained",
                                                                                    "cannot_judge", "no answer"), a))
    marks = {c: chr(ord("a") + i) if i < 26 else chr(ord("A") + i - 26) for i, c in enumerate(columns)}
    lines = [" " * 32 + "".join(f"{marks[c]:>4}" for c in columns)]
    for truth in sorted(table, key=lambda t: (":" in t, t)):
        cells = "".join(f"{table[truth].get(c, '.'):>4}" for c in columns)
        lines.append(f"{truth:32}{cells}")
    lines.append("first cause named, or the verdict: " + ", ".join(f"{m} {c}" for c, m in marks.items()))
    return "\n".join(lines)


def effect_table(results):
    """Per effect: records, right, by size, gain, second log, interval coverage."""
    head = f"{'effect':22}{'n':>4}{'right':>8}{'<1':>9}{'1-3':>9}{'>3':>9}{'joint gain':>12}{'2nd log':>10}{'intervals':>11}"
    lines, names = [head], sorted({row_name(r["truth"]) for r in results if r["truth"]["kind"] == "b"})
    for name in names:
        mine = [r for r in results if r["truth"]["kind"] == "b" and row_name(r["truth"]) == name]
        part = lambda rs: f"{sum(bool(r['score'].get('right')) for r in rs)}/{len(rs)}" if rs else "-"
        gain = [r["score"]["joint_gain"] for r in mine if r["score"].get("joint_gain")]
        second = [r for r in mine if "second" in r]
        held = [i for r in mine for i in r["score"].get("intervals", [])]
        ran = sum(r["second"] == "nothing_wrong" for r in second)
        cells = [part([r for r in mine if low <= smallest(r) < high]).rjust(9) for low, high in ((0, 1), (1, 3), (3, 1e99))]
        cells += [(f"{100 * statistics.median(gain):.0f} %" if gain else "-").rjust(12),
                  (f"{ran}/{len(second)}" if second else "-").rjust(10),
                  (f"{sum(i[3] for i in held)}/{len(held)}" if held else "-").rjust(11)]
        lines.append(f"{name:22}{len(mine):>4}{part(mine):>8}" + "".join(cells))
    return "\n".join(lines)


def write_csv(results, folder):
    with open(folder / "cases.csv", "w", newline="", encoding="utf-8") as f:
        w = csv.writer(f)
        w.writerow(["case", "kind", "sub", "hidden", "size [counts]", "verdict", "causes", "extra", "right", "gain", "joint_gain",
                    "second_log", "simulated_rms", "seconds", "fault"])
        for r in results:
            s = r["score"]
            hidden = " ".join(f"{e['effect']}@{e['joint']}" for e in r["truth"]["effects"])
            w.writerow([r["case"], r["truth"]["kind"], r["truth"]["sub"], hidden, f"{smallest(r):.3g}", s.get("verdict", ""),
                        " ".join(s.get("causes", [])), " ".join(s.get("extras", [])), int(bool(s.get("right"))),
                        s.get("gain"), s.get("joint_gain"), r.get("second", ""), r.get("simulated", ""), f"{r['seconds']:.2f}",
                        r["fault"]])
    with open(folder / "confusion.csv", "w", newline="", encoding="utf-8") as f:
        w = csv.writer(f)
        w.writerow(["truth", "answer", "records"])
        w.writerows([t, a, n] for t, line in sorted(confusion(results).items()) for a, n in sorted(line.items()))
    with open(folder / "intervals.csv", "w", newline="", encoding="utf-8") as f:
        w = csv.writer(f)
        w.writerow(["case", "effect", "parameter", "relative_width", "holds"])
        w.writerows([r["case"], *i[:3], int(i[3])] for r in results for i in r["score"].get("intervals", []))
