"""Equilibria, natural frequencies and linear models."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Union

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

At = Union[str, Mapping[str, Union[float, str]]]
"""Values of coordinates near which an equilibrium is sought: `{"phi": 0.5}` or `"phi=30deg"`."""


def positions(at: At | None) -> list[str]:
    """The values of coordinates as the extension module takes them."""
    if at is None:
        return []
    if isinstance(at, str):
        return [at]
    return [f"{name}={value if isinstance(value, str) else repr(float(value))}" for name, value in at.items()]


class Modes:
    """An equilibrium of a mechanism, and the modes about it: `f` degrees of freedom, `n` coordinates."""

    equilibrium: dict[str, float]
    """The coordinates, in rad and m."""
    stability: str
    """`asymptotically_stable`, `stable`, `free`, `unstable` or `undecided`."""
    frequencies: NDArray[np.float64]
    """The natural frequencies without damping in Hz, of shape `(f,)`; zero where a mode does not oscillate."""
    frequency_errors: NDArray[np.float64]
    """Their estimated errors."""
    shapes: NDArray[np.float64]
    """The mode shapes, of shape `(f, n)`, in the order of the coordinates."""
    eigenvalues: NDArray[np.complex128]
    """The eigenvalues with damping in 1/s, one of each complex pair."""
    others: list[dict[str, float]]
    """The coordinates of the other equilibria that were found."""
    report: dict[str, Any]
    """Everything that `modes.json` holds, derivatives of frequencies by parameters among it."""

    def __init__(self, report: dict[str, Any]):
        self.report = report
        self.equilibrium = report["equilibrium"]["coordinates"]
        self.stability = report["equilibrium"]["stability"]
        modes = report["modes"]
        self.frequencies = np.array([mode["frequency"] for mode in modes], dtype=float)
        self.frequency_errors = np.array([mode["frequency_error"] for mode in modes], dtype=float)
        shapes = [list(mode["shape"].values()) for mode in modes]
        self.shapes = np.array(shapes, dtype=float).reshape(len(modes), len(self.equilibrium))
        eigenvalues = [complex(value["re"], value["im"]) for value in report["eigenvalues"]]
        self.eigenvalues = np.array(eigenvalues, dtype=complex)
        self.others = [other["coordinates"] for other in report["others"]]

    def __repr__(self) -> str:
        hertz = ", ".join(f"{frequency:.6g}" for frequency in self.frequencies)
        return f"<Modes of {self.report['scene']}: {hertz} Hz, {self.stability}>"


class LinearModel:
    """A linear model about an equilibrium: `x' = A x + B u`, `y = C x + D u` in deviations from it."""

    A: NDArray[np.float64]
    B: NDArray[np.float64]
    C: NDArray[np.float64]
    D: NDArray[np.float64]
    states: list[str]
    """The states: independent coordinates and their rates."""
    inputs: list[str]
    """The parameters that are inputs."""
    outputs: list[str]
    """The outputs."""
    equilibrium: dict[str, float]
    """The coordinates of the equilibrium, in rad and m."""
    report: dict[str, Any]
    """Everything that `linear.json` holds: errors, units and values at the equilibrium among it."""

    def __init__(self, report: dict[str, Any]):
        self.report = report
        self.A, self.B, self.C, self.D = (np.array(report[name], dtype=float) for name in "ABCD")
        self.states, self.inputs, self.outputs = (
            [own["name"] for own in report[part]] for part in ("states", "inputs", "outputs")
        )
        self.equilibrium = report["equilibrium"]

    @property
    def state_space(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """`(A, B, C, D)`, as in `scipy.signal.StateSpace(*model.state_space)`."""
        return self.A, self.B, self.C, self.D

    def __repr__(self) -> str:
        outputs, inputs = ", ".join(self.outputs), ", ".join(self.inputs)
        return f"<LinearModel of {self.report['scene']}: {outputs} by {inputs}, {len(self.states)} states>"
