"""The style of all plots: one text size, lines distinguishable in greyscale, legends outside the data."""
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend must be selected first)

plt.rcParams.update(
    {
        "figure.dpi": 130,
        "font.size": 10,
        "axes.grid": True,
        "axes.grid.which": "both",
        "axes.axisbelow": True,
        "axes.titlesize": 10,
        "grid.color": "0.9",
        "grid.linewidth": 0.6,
        "legend.frameon": False,
        "legend.fontsize": 9,
        "lines.linewidth": 1.6,
        "lines.markersize": 6,
        "axes.spines.top": False,
        "axes.spines.right": False,
    }
)

# Orders 1, 2, 3, 4 of a filter differ in dash, marker and lightness, so that colour is not needed.
_ORDERS = {
    1: ("#000000", "-", "o"),
    2: ("#1f5fa8", "--", "s"),
    3: ("#c2410c", "-.", "^"),
    4: ("#808080", ":", "D"),
}


def theory(n):
    colour, dash, _ = _ORDERS[n]
    return {"color": colour, "linestyle": dash}


def simulated(n):
    colour, _, marker = _ORDERS[n]
    return {
        "color": colour,
        "linestyle": "none",
        "marker": marker,
        "markerfacecolor": "white",
        "markeredgewidth": 1.3,
    }


def figure(columns=1, width=None, height=3.8):
    """Axes in a row, with the legend at their right."""
    fig, axes = plt.subplots(
        1, columns, figsize=(width or 4.6 * columns + 2.2, height), squeeze=False, constrained_layout=True
    )
    return fig, axes[0]


def legend(axis, title=None, right=1.02):
    """At the right of the axes; bars, then points, then lines, each label once."""
    handles, labels = axis.get_legend_handles_labels()
    unique = dict(zip(labels, handles))
    bars_first = sorted(unique, key=lambda label: not hasattr(unique[label], "patches"))
    axis.legend(
        [unique[label] for label in bars_first],
        bars_first,
        title=title,
        loc="upper left",
        bbox_to_anchor=(right, 1.0),
        borderaxespad=0.0,
        handlelength=3.0,
        alignment="left",
    )


def save(fig, path):
    fig.savefig(path)
    plt.close(fig)
