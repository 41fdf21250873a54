"""Run times and errors of every method."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray


class Accuracy:
    """Measurements of every method with a series of steps or tolerances. A notebook shows them as a figure."""

    reference: str
    """What runs were compared with, and how uncertain it is."""
    recommendations: dict[str, str]
    """The cheapest method for each error, in a sentence."""
    svg: str | None
    """The figure: error against run time."""
    warnings: list[str]
    """Doubts that the measurements leave."""

    def __init__(self, found: Mapping[str, Any]):
        self._table, self._text = found["table"], found["text"]
        self.reference = found["reference"]
        self.recommendations = dict(found["recommendations"])
        self.svg = found["figure"]
        self.warnings = found["warnings"]

    def __str__(self) -> str:
        return str(self._text)

    def __repr__(self) -> str:
        return f"<Accuracy: {len(self.table)} measurements against {self.reference}>"

    def _repr_svg_(self) -> str | None:
        return self.svg

    @cached_property
    def table(self) -> NDArray[np.void]:
        """The measurements, a structured array with the columns of `accuracy.csv`.

        Among them are `method`, `step` in s or `tolerance`, `steps`, `run_seconds`, `error_position` in rad or m, and
        `failure`, a text that is empty where the method came to its end. Numbers that are not known are NaN. Errors
        below the uncertainty of the reference are given as that uncertainty.
        """
        header, *rows = csv.reader(self._table.splitlines())
        texts = ("method", "failure")
        table = np.empty(len(rows), dtype=[(name, "O" if name in texts else "f8") for name in header])
        for place, name in enumerate(header):
            entries = [row[place] for row in rows]
            table[name] = entries if name in texts else [float(entry.lstrip("<") or "nan") for entry in entries]
        return table
