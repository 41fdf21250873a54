"""Many designs of a mechanism as one structured array."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from .errors import RunWarning
from .options import split

if TYPE_CHECKING:
    from . import _native


class SweepTable(np.ndarray):
    """A structured array with a row for each design, and the units and meanings of its columns.

    `table["N3_max"]` is an array of shape `(designs,)`. The columns are those of `qrm sweep`: `design`; the varied
    parameters; `status` (`"done"` or `"failed"`); `reason`; `end_time`; `end_time_error`, where a condition
    ends the designs; `steps`; `NAME` and `NAME_dot` of each coordinate at the end; `NAME_min` and `NAME_max` of each
    output; `estimated_error`. Numbers that are not known are
    NaN, and whole numbers 0.
    """

    units: dict[str, str]
    """The unit of each column."""
    docs: dict[str, str]
    """The meaning of each column."""

    def __array_finalize__(self, base: Any) -> None:
        self.units = getattr(base, "units", {})
        self.docs = getattr(base, "docs", {})

    def __getitem__(self, key: Any) -> Any:
        found = super().__getitem__(key)
        # A column is a plain array.
        return found.view(np.ndarray) if isinstance(found, SweepTable) and found.dtype.names is None else found

    def __reduce__(self) -> tuple[Any, ...]:
        reduced = cast("tuple[Any, ...]", super().__reduce__())
        return *reduced[:2], (reduced[2], self.units, self.docs)

    def __setstate__(self, state: Any) -> None:
        own, self.units, self.docs = state
        super().__setstate__(own)

    @property
    def done(self) -> np.ndarray:
        """Whether each design came to its end, and its numbers are to be trusted: of shape `(designs,)`."""
        return np.asarray(self["status"] == "done")


def sweep(
    scene: _native.Scene,
    arguments: Mapping[str, Any],
    *,
    paired: bool,
    extremes: bool,
    estimate_error: bool,
    threads: int | None,
    device: str,
) -> SweepTable:
    """Runs designs and makes a table of them; see `Mechanism.sweep`."""
    options = split(arguments)
    parameters = options["set"]
    varied = {name: value for name, value in parameters.items() if not isinstance(value, str) and np.ndim(value) > 0}
    options["set"] = {name: value for name, value in parameters.items() if name not in varied}
    vary = [(name, _numbers(name, values)) for name, values in varied.items()]
    if not vary:
        raise TypeError("a sweep varies at least one parameter: give it several values, as O2A=[0.2, 0.25]")
    columns, notes = scene.sweep(options, vary, paired, extremes, estimate_error, threads, device)
    for note in notes:
        warnings.warn(note, RunWarning, stacklevel=3)
    return _table(columns)


def _numbers(name: str, values: Sequence[float]) -> list[float]:
    array = np.asarray(values, dtype=np.float64)
    if array.ndim != 1:
        raise TypeError(f"the values of `{name}` must be a sequence of numbers, not an array of shape {array.shape}")
    return [float(value) for value in array]


def _table(columns: list[tuple[str, str, str, Any]]) -> SweepTable:
    # Reasons are of any length, and most of them empty.
    kinds = {"status": "U6", "reason": "O"}
    fields = [(name, "i8" if name in ("design", "steps") else kinds.get(name, "f8")) for name, *_ in columns]
    table = np.empty(len(columns[0][3]), dtype=fields).view(SweepTable)
    for name, _, _, values in columns:
        table[name] = values
    table.units = {name: unit for name, unit, _, _ in columns}
    table.docs = {name: doc for name, _, doc, _ in columns}
    return table
