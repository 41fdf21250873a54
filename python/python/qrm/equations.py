"""The equations of motion at one state, in numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class Equations(NamedTuple):
    """The terms of the equations of motion at a state, and their solution.

    `mass_matrix @ qdd + C_q.T @ multipliers == forces` and `C_q @ qdd == gamma`, for `n` coordinates and `m`
    constraints `C = 0`. All numbers are in SI units and radians.
    """

    mass_matrix: NDArray[np.float64]
    """The reduced mass matrix, of shape `(n, n)`."""
    forces: NDArray[np.float64]
    """The generalized forces with the terms of the rates, of shape `(n,)`."""
    C: NDArray[np.float64]
    """The residuals of the constraints, of shape `(m,)`."""
    C_q: NDArray[np.float64]
    """The Jacobian of the constraints, of shape `(m, n)`."""
    C_t: NDArray[np.float64]
    """The derivative of the constraints by time, of shape `(m,)`."""
    gamma: NDArray[np.float64]
    """`-(C_q qd)_q qd - 2 C_qt qd - C_tt`, of shape `(m,)`."""
    qdd: NDArray[np.float64]
    """The accelerations, of shape `(n,)`."""
    multipliers: NDArray[np.float64]
    """The multipliers lambda, of shape `(m,)`: the force of a constraint on a point is `-lambda dC/dP`."""
    outputs: dict[str, float]
    """The outputs of the scene."""
    kinetic_energy: float
    """The kinetic energy in J."""
    potential_energy: float
    """The potential of the conservative loads in J."""
