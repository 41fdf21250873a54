"""Derivatives of a motion, and the problems of optimisers that they solve."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .errors import OptionError
from .options import split

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .mechanism import Mechanism


class MotionQuantity(NamedTuple):
    """A quantity of a whole motion."""

    kind: str
    """`end`, `minimum`, `time_of_minimum`, `maximum`, `time_of_maximum` or `integral`."""
    of: str
    """The coordinate, rate or output."""
    unit: str
    """Its unit."""

    def __str__(self) -> str:
        return f"{self.kind} {self.of}"


class Sensitivity:
    """Values of a motion with their derivatives by parameters.

    Rows are the quantities, columns the parameters in `by`. A quantity is named by its kind and its column, as
    `"maximum N3"`, `"end x6"` or `"end t"`.
    """

    by: list[str]
    """The parameters, `p` of them."""
    quantities: list[MotionQuantity]
    """The quantities, `k` of them."""
    values: NDArray[np.float64]
    """The values, of shape `(k,)`, in their units."""
    jacobian: NDArray[np.float64]
    """The derivatives, of shape `(k, p)`, in the units of the quantities over those of the parameters."""
    hessian_vector: NDArray[np.float64] | None
    """The products of the Hessian of each quantity with the vector, of shape `(k, p)`; `None` without a vector."""
    value_errors: NDArray[np.float64] | None
    """The estimated errors of `values`; `None` where they are not checked."""
    jacobian_errors: NDArray[np.float64] | None
    """The estimated errors of `jacobian`; `None` where they are not checked."""
    hessian_vector_errors: NDArray[np.float64] | None
    """The estimated errors of `hessian_vector`; `None` where they are not checked."""

    def __init__(self, found: Mapping[str, Any]):
        self.by = found["by"]
        self.quantities = [MotionQuantity(*entry) for entry in found["quantities"]]
        self.values, self.jacobian = found["values"], found["jacobian"]
        self.hessian_vector = found["hessian_vector"]
        self.value_errors, self.jacobian_errors = found.get("value_errors"), found.get("jacobian_errors")
        self.hessian_vector_errors = found.get("hessian_vector_errors")
        self._rows = {str(quantity): row for row, quantity in enumerate(self.quantities)}

    def __repr__(self) -> str:
        return f"<Sensitivity of {len(self.quantities)} quantities by {', '.join(self.by)}>"

    def __contains__(self, name: object) -> bool:
        return name in self._rows

    def row(self, name: str) -> int:
        """The row of a quantity such as `"maximum N3"`."""
        try:
            return self._rows[name]
        except KeyError:
            raise KeyError(f"there is no quantity {name!r}; quantities: {', '.join(self._rows)}") from None

    def value(self, name: str) -> float:
        """The value of a quantity such as `"maximum N3"`."""
        return float(self.values[self.row(name)])

    def gradient(self, name: str) -> NDArray[np.float64]:
        """The derivatives of a quantity by the parameters, of shape `(p,)`."""
        gradient: NDArray[np.float64] = self.jacobian[self.row(name)]
        return gradient

    def unit(self, name: str) -> str:
        """The unit of a quantity."""
        return self.quantities[self.row(name)].unit


_KINDS = ("end", "minimum", "time_of_minimum", "maximum", "time_of_maximum", "integral")


class Objectives:
    """Quantities of a motion as functions of some parameters, with their Jacobian, for `scipy.optimize`.

    `fun(x)` has shape `(k,)` and `jac(x)` shape `(k, p)`, with `x` in the order of `by`; one motion serves both. Of one
    quantity that is given as a text, `fun(x)` is a number and `jac(x)` has shape `(p,)`, as minimisers want them.
    """

    by: list[str]
    """The parameters, in the order of `x`."""
    quantities: list[str]
    """The quantities, such as `"maximum N3"`."""
    x0: NDArray[np.float64]
    """The values of the parameters to begin with, of shape `(p,)`."""

    def __init__(self, mechanism: Mechanism, by: Sequence[str], of: str | Sequence[str], options: Mapping[str, Any]):
        self._is_scalar = isinstance(of, str)
        self.by, self.quantities = list(by), [of] if isinstance(of, str) else list(of)
        self._mechanism, self._options = mechanism, dict(options)
        self._last: tuple[bytes, Sensitivity] | None = None
        self._asked = sorted({self._chosen_by(name) for name in self.quantities})
        values = mechanism.values(set=split(self._options)["set"])
        if len({*self.by} & {*values}) < len(self.by):
            # The error that the mechanism has for an unknown name, or one that is given twice.
            mechanism.sensitivity(by=self.by, check=False, **self._options)
        self.x0 = np.array([values[name] for name in self.by])

    def at(self, x: ArrayLike) -> Sensitivity:
        """The values and derivatives of all quantities at `x`."""
        x = np.asarray(x, dtype=np.float64)
        if x.shape != (len(self.by),):
            raise ValueError(f"x has shape {x.shape} instead of ({len(self.by)},)")
        key = x.tobytes()
        if self._last is None or self._last[0] != key:
            values = dict(zip(self.by, x.tolist()))
            found = self._mechanism.sensitivity(by=self.by, of=self._asked, check=False, **{**self._options, **values})
            self._last = key, found
        return self._last[1]

    def fun(self, x: ArrayLike) -> Any:
        """The values at `x`."""
        found = self.at(x)
        values = np.array([found.value(name) for name in self.quantities])
        return float(values[0]) if self._is_scalar else values

    def jac(self, x: ArrayLike) -> NDArray[np.float64]:
        """The derivatives at `x`."""
        found = self.at(x)
        rows = np.array([found.gradient(name) for name in self.quantities])
        return rows[0] if self._is_scalar else rows

    def _chosen_by(self, quantity: str) -> str:
        """The name by which a quantity is asked for: its output, or `end` for coordinates and rates at the end."""
        kind, _, of = quantity.partition(" ")
        if kind not in _KINDS or not of:
            hint = f"write its kind and its column, as `maximum N3` or `end x6`; kinds: {', '.join(_KINDS)}"
            raise OptionError(f"`{quantity}` is no quantity", [hint])
        outputs = [output.name for output in self._mechanism.outputs]
        if of in outputs:
            return of
        rates = [f"{coordinate.name}_dot" for coordinate in self._mechanism.coordinates]
        known = [*outputs, *(["t", *(c.name for c in self._mechanism.coordinates), *rates] if kind == "end" else [])]
        if of not in known:
            raise OptionError(f"there is no quantity `{quantity}`", [f"{kind} can be of: {', '.join(known)}"])
        return "end"
