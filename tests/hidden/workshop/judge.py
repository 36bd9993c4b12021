"""Judges an answer of `qerr diagnose` by a workshop truth: right, acceptable or wrong.

A truth has `causes`: slots, each a list of effect names that a fair engineer would accept there (with `values`: parameter ->
true value, to be met within 25 %); `says`: patterns of what the findings about the data, or the description of the remainder, may
say instead; `tolerated` names beside them; `clean`: nothing is wrong; `may_decline`: cannot_judge is right.
Wrong is a cause that is not there, an alarm on a clean record, or an all-clear on a faulty one.
"""
import re

STATEMENTS = {"slow_motion", "varying_jacobian", "correlated_joints"}
NAMING = {"explained", "partly_explained", "ambiguous"}


def rows(answer, key):
    return [x for x in answer.get(key) or [] if isinstance(x, dict)]


def at(truth, x):
    return x.get("joint") in (truth.get("joint"), None, "") or truth.get("any_joint")


def fits(slot, cause):
    """None if the cause is none of this slot's; else whether its parameters are true within 25 %."""
    if cause.get("effect") not in slot["effects"]:
        return None
    values = {p["name"]: p["value"] for p in rows(cause, "parameters")}
    return all(abs(abs(values[k]) - abs(v)) <= 0.25 * abs(v) for k, v in (slot.get("values") or {}).items() if k in values)


def says(truth, answer, keys=("data", "unexplained")):
    words = [" ".join([str(x.get("what")), str(x.get("shape", ""))]) for k in keys for x in rows(answer, k) if at(truth, x)]
    return any(re.search(p, w) for p in truth.get("says") or [] for w in words)


def judge(truth, answer):
    """(right | acceptable | wrong, why)"""
    verdict, causes = answer.get("verdict"), [c for c in rows(answer, "causes") if c.get("effect") not in STATEMENTS]
    slots = truth.get("causes") or []
    mine = [[fits(s, c) for c in causes if at(truth, c) and fits(s, c) is not None] for s in slots]
    swaps = {a.get("instead_of") for a in rows(answer, "alternatives") for s in slots if at(truth, a) and a.get("effect") in s["effects"]}
    spare = [any(a.get("effect") in s["effects"] and at(truth, a) for a in rows(answer, "alternatives")) for s in slots]
    named = {n for s in slots for n in s["effects"]} | set(truth.get("tolerated") or [])
    extras = [f"{c['effect']}@{c.get('joint')}" for c in causes
              if not (at(truth, c) and c["effect"] in named) and not (verdict == "ambiguous" and c["effect"] in swaps)]
    heard = says(truth, answer)
    if extras:
        return "wrong", "names " + ", ".join(extras)
    if truth.get("clean"):
        if verdict == "nothing_wrong" or heard or (verdict == "cannot_judge" and truth.get("may_decline")):
            return "right", verdict
        return ("acceptable" if verdict == "cannot_judge" or causes else "wrong"), f"{verdict} on a clean record"
    found = [bool(m) or (verdict == "ambiguous" and s) for m, s in zip(mine, spare)]
    if slots and all(found) and verdict in NAMING:
        if any(m and not any(m) for m in mine):
            return "acceptable", "a parameter is off by more than 25 %"
        if verdict == "partly_explained" and not heard:
            return "acceptable", "partly explained"
        return "right", verdict
    if heard and (truth.get("says_is_enough", True)):
        return "right", "says so"
    if verdict == "nothing_wrong":
        return "wrong", "all-clear"
    return "acceptable", f"{verdict}: " + ("part of it named" if any(found) else "no cause")


def unfounded(truth, answer):
    """Findings about the data of a record of which the truth knows nothing; for the reader, not scored."""
    known = (truth.get("says") or []) + ["does not move", "noise of", "grid", "changes in steps"]
    return [str(d.get("what")) for d in rows(answer, "data") if not any(re.search(p, str(d.get("what"))) for p in known)]


GRADES = ("right", "acceptable", "wrong")


def passed(results):
    """What the acceptance asks for: at least 85 % right, at most 5 % wrong."""
    share = lambda g: sum(r["grade"] == g for r in results) / len(results)
    return share("right") >= 0.85 and share("wrong") <= 0.05


def table(results):
    lines = [f"{r['grade']} {r['sub']}: {r['why']}\n      {r['command']}" for r in results if r["grade"] != "right"]
    lines += [f"finding {r['sub']}: {w}\n      {r['command']}" for r in results for w in r["unfounded"]]
    lines.append(f"\n{'kind':24}" + "".join(f"{g:>12}" for g in GRADES))
    count = lambda rs: "".join(f"{sum(r['grade'] == g for r in rs):12}" for g in GRADES)
    for sub in sorted({r["sub"] for r in results}):
        lines.append(f"{sub:24}" + count([r for r in results if r["sub"] == sub]))
    for title, rs in (("clean", [r for r in results if r["clean"]]), ("all", results)):
        if rs:
            lines.append(f"{title:24}" + count(rs) + "".join(
                f"  {100 * sum(r['grade'] == g for r in rs) / len(rs):.1f} % {g}" for g in GRADES))
    return "\n".join(lines)
