"""Steady motions."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .result import Result


class Steady:
    """The periodic motion that a machine settles into, and what becomes of small deviations from it."""

    period: float
    """The period in s."""
    period_error: float
    """Its estimated error; zero where loads or drives give the period."""
    stability: str
    """`attracting`, `repelling`, `undecided`, `one_of_many` or `no_deviation`."""
    multipliers: NDArray[np.complex128]
    """The Floquet multipliers, the largest first."""
    multiplier_errors: NDArray[np.float64]
    """Their estimated errors."""
    start: dict[str, float]
    """The coordinates and rates given at the start of the period, as `start` of `Mechanism.run` takes them."""
    start_errors: dict[str, float]
    """Their estimated errors."""
    turns: dict[str, float]
    """The whole turns of each angle in the period."""
    columns: dict[str, dict[str, Any]]
    """For each rate and output: `mean`, `min`, `max`, their errors, times and phases, `fluctuation` and `work`."""
    solved: dict[str, Any] | None
    """`parameter`, `value` and `error` that were solved for."""
    result: Result
    """A run over the period."""

    def __init__(self, text: str, result: Result):
        found = json.loads(text)
        self.period, self.period_error = found["period"], found["period_error"]
        self.stability = found["stability"]
        entries = found["multipliers"]
        self.multipliers = np.array([complex(entry["re"], entry["im"]) for entry in entries], dtype=complex)
        self.multiplier_errors = np.array([entry["error"] for entry in entries], dtype=float)
        self.start, self.start_errors, self.turns = found["start"], found["start_errors"], found["turns"]
        self.columns = found["columns"]
        self.solved = found.get("solved")
        self.result = result

    def __repr__(self) -> str:
        return f"<Steady motion of period {self.period:.7g} s, {self.stability.replace('_', ' ')}>"
