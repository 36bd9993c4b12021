"""Compares one answer of `qerr diagnose` with one truth. Pure functions on the two JSON documents.

`slow_motion`, `varying_jacobian` and `correlated_joints` are statements about the paper's formula and may stand beside anything.
An offset, and what the truth lists as tolerated, may be named beside the right cause.
"""
import math

STATEMENTS = {"slow_motion", "varying_jacobian", "correlated_joints"}
NAMING = {"explained", "partly_explained", "ambiguous"}
VERDICTS = NAMING | {"nothing_wrong", "unexplained", "cannot_judge"}
# Records for which no verdict is acceptable: no motion, or a reference hardly better than the encoder.
MAY_DECLINE = {"standstill", "poor_reference", "constant_speed"}


def number(x):
    good = isinstance(x, (int, float)) and not isinstance(x, bool) and math.isfinite(x)
    return float(x) if good else None


def rows(answer, key):
    return [r for r in answer.get(key) or [] if isinstance(r, dict)]


def causes_of(answer):
    return [c for c in rows(answer, "causes") if c.get("effect") not in STATEMENTS]


def parameters(cause):
    return {p.get("name"): p for p in rows(cause, "parameters")}


def close(x, wanted, tolerance):
    return x is not None and any(abs(abs(x) - abs(w)) <= tolerance * abs(w) for w in wanted)


def same_joint(effect, cause):
    return cause.get("joint") in (effect.get("joint"), None)


def is_cause(effect, cause):
    """Whether the cause names the true effect, or one that the truth accepts instead."""
    if not same_joint(effect, cause):
        return False
    if cause.get("effect") == effect["effect"]:
        return True
    for other in effect.get("also_accept") or []:
        if cause.get("effect") == other["effect"]:
            order = number(parameters(cause).get("order", {}).get("value"))
            if not other.get("orders") or close(order, other["orders"], other.get("tolerance", 0.01)):
                return True
    return False


def is_tolerated(truth, cause):
    return any(cause.get("effect") == t["effect"] and cause.get("joint") in (t.get("joint"), None)
               for t in truth.get("tolerated") or [])


def covered(effect, cause):
    """[(name, relative width, whether the 95 % interval contains the true value)] for each parameter that both state."""
    out, found = [], parameters(cause)
    for p in effect.get("parameters") or []:
        for name in [p["name"], *p.get("aliases", [])]:
            if name not in found:
                continue
            low, high = number(found[name].get("lower")), number(found[name].get("upper"))
            if low is None or high is None or not p["values"]:
                out.append((p["name"], None, False))
            elif low == high and p["name"] in ("order", "factor", "modulus"):  # an integer that was selected, not fitted
                pass
            else:
                slack = 1e-12 * max(abs(low), abs(high))
                holds = any(low - slack <= v <= high + slack for v in p["values"])
                out.append((p["name"], (high - low) / max(abs(p["values"][0]), 1e-300), holds))
            break
    return out


def pair_reported(truth, answer):
    """(both effects of a pair are named, or one of them with an ambiguous verdict; both are named)"""
    reported = {c.get("effect") for c in causes_of(answer)}
    for a in rows(answer, "alternatives"):
        reported |= {a.get("effect"), a.get("instead_of")}
    both = any(set(pair) <= reported for pair in truth.get("pair") or [])
    one = any(set(pair) & reported for pair in truth.get("pair") or [])
    return both or (answer.get("verdict") == "ambiguous" and one), both


def gains(truth, answer):
    """(reached over reachable of the whole residual, the same of the first true effect's joint); None if not reported.

    The gain is rms before over rms after on data that was not fitted."""
    def ratio(g):
        g = g if isinstance(g, dict) else {}
        before, after = number(g.get("rms_before")), number(g.get("rms_after"))
        return number(g.get("ratio")) or (before / after if before and after else None)
    known, whole, joint = truth.get("gain") or {}, None, None
    reachable = ratio(known.get("tip") if truth.get("reference") == "tip" else known.get("all_joints"))
    reached = 1.0 if answer.get("verdict") == "nothing_wrong" else ratio(answer.get("gain"))
    if reachable:
        whole = (reached or 0.0) / reachable
    if truth["effects"]:
        name = truth["effects"][0]["joint"]
        reachable = ratio((known.get("joints") or {}).get(name))
        mine = [ratio(c.get("gain")) for c in causes_of(answer) if c.get("joint") == name]
        mine = [m for m in mine if m]
        if reachable and truth.get("reference") != "tip":
            joint = (max(mine) if mine else 1.0) / reachable
    return whole, joint


def label(cause):
    return f"{cause.get('effect')}@{cause.get('joint', '-')}"


def score(truth, answer):
    """The figures of one case that the tables need."""
    causes, verdict, effects = causes_of(answer), answer.get("verdict"), truth["effects"]
    named = [any(is_cause(e, c) for c in causes) for e in effects]
    alternatives = rows(answer, "alternatives")
    as_alternative = [not n and verdict == "ambiguous" and any(is_cause(e, a) for a in alternatives)
                      for e, n in zip(effects, named)]
    stand_ins = {a.get("instead_of") for a in alternatives if any(is_cause(e, a) for e, t in zip(effects, as_alternative) if t)}
    extras = [c for c in causes if not any(is_cause(e, c) for e in effects) and not is_tolerated(truth, c)
              and c.get("effect") not in stand_ins]
    leading = [c for c in causes if not is_tolerated(truth, c)] or causes
    out = {"verdict": verdict if verdict in VERDICTS else f"unknown: {verdict}", "causes": [label(c) for c in causes],
           "unexplained": [str(u.get("what")) for u in rows(answer, "unexplained")],
           "found": [n or t for n, t in zip(named, as_alternative)], "extras": [label(c) for c in extras],
           "first": next((c.get("effect") for c in leading), None),
           "first_right": bool(leading) and any(is_cause(e, leading[0]) for e in effects),
           "intervals": [], "gain": None, "joint_gain": None, "declined": verdict == "cannot_judge"}
    for e in effects:
        for c in causes:
            if is_cause(e, c) and c.get("effect") == e["effect"]:
                out["intervals"] += [(e["effect"], *row) for row in covered(e, c)]
                break
    kind = truth["kind"]
    if kind == "a":
        quiet = verdict == "nothing_wrong" or (out["declined"] and truth["sub"] in MAY_DECLINE)
        out["right"] = quiet and not causes
        out["false_alarm"] = bool(causes) or verdict in NAMING | {"unexplained"}
    elif kind in "bc":
        out["right"] = bool(effects) and all(out["found"]) and not extras and verdict in NAMING
        out["gain"], out["joint_gain"] = gains(truth, answer)
    elif kind == "d":
        wrong = [c for c in causes if not any(is_cause(e, c) for e in effects) and not is_tolerated(truth, c)]
        out["misnamed"], out["missed"] = bool(wrong), verdict == "nothing_wrong"
        out["right"] = not wrong and not out["missed"]
    else:
        out["right"], out["both_reported"] = pair_reported(truth, answer)
    return out


def binomial_upper(hits, trials, level=0.95):
    """Upper one-sided Clopper-Pearson bound of a rate: the p with P(X <= hits) = 1 - level."""
    if trials == 0 or hits >= trials:
        return 1.0
    def below(p):
        term, total = (1 - p) ** trials, 0.0
        for k in range(hits + 1):
            total += term
            term *= (trials - k) / (k + 1) * p / (1 - p)
        return total
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if below(middle) > 1 - level else (low, middle)
    return high


def binomial_lower(hits, trials, level=0.95):
    return 1 - binomial_upper(trials - hits, trials, level)
