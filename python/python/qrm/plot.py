"""Plots of results by matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from .result import Result


def plot(result: Result, *names: str, x: str = "t", axes: Axes | None = None) -> Axes:
    """Plots columns over another one, with units, and a band of the estimated error.

    Columns are plotted into `axes`, or a new figure. They should share a unit; the axis names it. Without a name, the
    first output is plotted, or else the first coordinate.
    """
    if axes is None:
        try:
            from matplotlib import pyplot
        except ImportError as error:
            raise ImportError("plots need matplotlib: pip install matplotlib") from error
        axes = pyplot.subplots(layout="constrained")[1]
    names = names or (_first(result),)
    for name in names:
        (line,) = axes.plot(result[x], result[name], label=name)
        if x == "t" and name in result.errors:
            low, high = result[name] - result.errors[name], result[name] + result.errors[name]
            axes.fill_between(result.t, low, high, color=line.get_color(), alpha=0.25, linewidth=0)
    units = {result.units[name] for name in names}
    label = names[0] if len(names) == 1 else ", ".join(names)
    axes.set_xlabel(_labelled(x, result.units[x]))
    axes.set_ylabel(_labelled(label, units.pop() if len(units) == 1 else ""))
    if len(names) > 1:
        axes.legend()
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
