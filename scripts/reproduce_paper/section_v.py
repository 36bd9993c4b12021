"""Sec. V: shared by Figs. 7 to 10."""

SPEC = "configs/paper/section_v.yaml"
ORDERS = (1, 2, 3, 4)
ALL = [f"d{d}n{n}" for d in (1, 2, 3) for n in (1, 2, 3, 4, 5)]
SIGMA_X = 1e-4  # [m], the paper's nominal value


def spaced(low, high, count):
    return [low * (high / low) ** (i / (count - 1)) for i in range(count)]


def cutoff(value):
    return {f"filters.{name}.lowpass.cutoff": f"{value:.12g}Hz" for name in ALL}


def rate(value):
    return {f"filters.{name}.sample_rate": f"{value:.12g}Hz" for name in ALL}


def norms(command):
    return {f["name"]: f["h2_norm"] for f in command.json()["filters"]}


def simulation(command):
    """Filter name -> the results of `simulate` for x."""
    return {r["filter"]: r for r in command.json()["results"]}


def line(axis, xs, ys, n, label="theory"):
    import style

    axis.plot(xs, ys, **style.theory(n), label=f"n = {n}, {label}")


def marks(axis, xs, ys, n):
    import style

    axis.plot(xs, ys, **style.simulated(n), label=f"n = {n}, simulated")
