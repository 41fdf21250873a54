"""The results of a run."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from .options import in_python

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from .quantity import Quantity


class Result(Mapping[str, "NDArray[np.float64]"]):
    """The rows of a run, by the names of their columns, and what is known of their accuracy.

    `result["x6"]` is an array of shape `(rows,)` in SI units and radians. The columns are the time `t`; `NAME`,
    `NAME_dot` and `NAME_ddot` of each coordinate; `lambda_NAME` of each constraint; the outputs; `residual_position`,
    `residual_velocity` and `energy`.
    """

    array: NDArray[np.float64]
    """All numbers, of shape `(rows, columns)`."""
    warnings: list[str]
    """What its user should know about the run."""

    def __init__(self, quantities: tuple[Quantity, ...], array: NDArray[np.float64], summary: str, warnings: list[str]):
        self._quantities = quantities
        self._summary = summary
        self._columns: dict[str, NDArray[np.float64]] = {}
        self.array = array
        self.warnings = warnings

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        found = self._columns.get(name)
        if found is None:
            place = self._places.get(name)
            if place is None:
                raise KeyError(f"there is no column {name!r}; columns: {', '.join(self._places)}")
            found = self._columns[name] = np.ascontiguousarray(self.array[:, place])
        return found

    def __iter__(self) -> Iterator[str]:
        return iter(self._places)

    def __len__(self) -> int:
        return len(self._places)

    def __repr__(self) -> str:
        summary = self.summary
        error = summary["estimated_error"]
        error = "" if error is None else f", error about {error:.1e}"
        what = f"{summary['scene']}: {in_python(summary['message'])}; {len(self.array)} rows by {summary['method']}"
        return f"<Result of {what}{error}>"

    @cached_property
    def _places(self) -> dict[str, int]:
        return {quantity.name: place for place, quantity in enumerate(self._quantities)}

    @property
    def t(self) -> NDArray[np.float64]:
        """The times of the rows in s, of shape `(rows,)`."""
        return self["t"]

    @cached_property
    def units(self) -> dict[str, str]:
        """The unit of each column."""
        return {quantity.name: quantity.unit for quantity in self._quantities}

    @cached_property
    def docs(self) -> dict[str, str]:
        """The meaning of each column."""
        return {quantity.name: quantity.doc for quantity in self._quantities}

    @cached_property
    def summary(self) -> dict[str, Any]:
        """What `qrm run` writes as `summary.json`: how the run ended, its steps, errors and extremes."""
        summary: dict[str, Any] = json.loads(self._summary)
        return summary

    @property
    def errors(self) -> dict[str, float]:
        """The estimated largest error of each column in any row, in the unit of the column; empty without estimates."""
        return cast("dict[str, float]", self.summary["estimated_errors"])

    @property
    def extremes(self) -> dict[str, dict[str, float]]:
        """The extremes of each column, between rows too: `min`, `min_time`, `min_error`, and the same of `max`."""
        return cast("dict[str, dict[str, float]]", self.summary["extremes"])

    @property
    def end_state(self) -> dict[str, float]:
        """The coordinates and rates at the end."""
        return cast("dict[str, float]", self.summary["end_state"])

    @property
    def end_time(self) -> float:
        """The time of the end in s."""
        return cast("float", self.summary["end_time"])

    @property
    def end_time_error(self) -> float | None:
        """The estimated error of the time at which a condition ended the run, in s; `None` where a time ended it."""
        return cast("float | None", self.summary["end_time_error"])

    @property
    def parameters(self) -> dict[str, float]:
        """The values of the parameters of this run."""
        return cast("dict[str, float]", self.summary["parameters"])

    def plot(self, *names: str, x: str = "t", axes: Axes | None = None) -> Axes:
        """Plots columns over another one by matplotlib; see `qrm.plot.plot`."""
        from .plot import plot

        return plot(self, *names, x=x, axes=axes)
