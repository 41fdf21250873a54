"""Plots of results by matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

    from .result import Result


def plot(result: Result, *names: str, x: str = "t", axes: Axes | None = None) -> Axes:
    """Plots columns over another one, with units, and a band of the estimated error.

    Columns are plotted into `axes`, or a new figure. Those of other units have axes of their own on the right. Without
    a name, the first output is plotted, or else the first coordinate.
    """
    if axes is None:
        try:
            from matplotlib import pyplot
        except ImportError as error:
            raise ImportError("plots need matplotlib: pip install matplotlib") from error
        axes = pyplot.subplots(layout="constrained")[1]
    names = names or (_first(result),)
    by_unit: dict[str, list[str]] = {}
    for name in names:
        by_unit.setdefault(result.units[name], []).append(name)
    lines: list[Line2D] = list(axes.get_lines())
    for place, (unit, group) in enumerate(by_unit.items()):
        own = axes if place == 0 else axes.twinx()
        if place > 1:
            own.spines["right"].set_position(("outward", 60.0 * (place - 1)))
        own.set_ylabel(_labelled(", ".join(group), unit))
        for name in group:
            lines += own.plot(result[x], result[name], label=name, color=f"C{len(lines)}")
            if x == "t" and name in result.errors:
                low, high = result[name] - result.errors[name], result[name] + result.errors[name]
                own.fill_between(result.t, low, high, color=lines[-1].get_color(), alpha=0.25, linewidth=0)
    axes.set_xlabel(_labelled(x, result.units[x]))
    if len(names) > 1:
        axes.legend(handles=[line for line in lines if not str(line.get_label()).startswith("_")])
    elif result.docs[names[0]]:
        axes.set_title(result.docs[names[0]])
    return axes


def _first(result: Result) -> str:
    names = list(result)
    outputs = names[: names.index("residual_position")]
    others = [name for name in outputs[1:] if not name.startswith("lambda_") and not name.endswith(("_dot", "_ddot"))]
    coordinates = result.end_state
    return next((name for name in others if name not in coordinates), others[0])


def _labelled(name: str, unit: str) -> str:
    return f"{name} ({unit})" if unit else name
