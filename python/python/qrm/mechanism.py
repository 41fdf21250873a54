"""A mechanism that is loaded: what can be asked of it."""

from __future__ import annotations

import json
import warnings
from functools import cached_property
from os import PathLike, fsdecode
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from . import _native
from .accuracy import Accuracy
from .equations import Equations
from .errors import OptionError, RunError, RunWarning
from .modes import At, LinearModel, Modes, positions
from .options import only_parameters, split
from .page import Page
from .quantity import Quantity
from .result import Result
from .sensitivity import Objectives, Sensitivity
from .steady import Steady
from .sweep import SweepTable, sweep

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike, NDArray

    from .options import Number


class Mechanism:
    """A mechanism with its parameters, constraints, coordinates and outputs.

    Arguments that are no options are parameters: `run(O2A=0.25)`. All numbers are in SI units and radians; a text such
    as `"3*pi"` is as good as a number. A `Mechanism` does not change, and threads can share it: the interpreter is free
    while it computes. Ctrl-C ends what is computed.
    """

    def __init__(self, scene: str | PathLike[str]):
        self._path = fsdecode(scene)
        try:
            self._scene = _native.load(self._path)
        except UnicodeEncodeError:
            raise OptionError(f"the path {self._path!r} is not UTF-8", ["rename the file"]) from None

    def __repr__(self) -> str:
        return f"<Mechanism {self.name}: {self.doc}>"

    def __getstate__(self) -> tuple[str, str]:
        # The file may have another text by the time that this is read.
        return self._path, self.source

    def __setstate__(self, state: tuple[str, str]) -> None:
        self._path, source = state
        self._scene = _native.load_source(self._path, source)

    @property
    def name(self) -> str:
        """The name of the scene."""
        return self._scene.name

    @property
    def doc(self) -> str:
        """What the mechanism is."""
        return self._scene.doc

    @property
    def source(self) -> str:
        """The text of the scene."""
        return self._scene.source

    @property
    def is_compiled(self) -> bool:
        """Whether its functions are compiled; otherwise they are interpreted, and give the same numbers more slowly."""
        return self._scene.is_compiled

    @cached_property
    def coordinates(self) -> tuple[Quantity, ...]:
        """The generalized coordinates, in the order of `q`."""
        return tuple(Quantity(*entry) for entry in self._scene.coordinates())

    @cached_property
    def constraints(self) -> tuple[Quantity, ...]:
        """The constraints, in the order of the multipliers."""
        return tuple(Quantity(*entry) for entry in self._scene.constraints())

    @cached_property
    def outputs(self) -> tuple[Quantity, ...]:
        """The outputs that the scene asks for."""
        return tuple(Quantity(*entry) for entry in self._scene.outputs())

    @cached_property
    def columns(self) -> tuple[Quantity, ...]:
        """The columns of the result of a run."""
        return tuple(Quantity(*entry) for entry in self._scene.columns())

    @cached_property
    def parameters(self) -> tuple[Quantity, ...]:
        """The parameters that can be set; `values()` has their values."""
        return tuple(Quantity(*entry) for entry in self._scene.parameters())

    def values(self, *, set: Mapping[str, Number] | None = None, **parameters: Number) -> dict[str, float]:
        """The value of each parameter, some of them replaced: by name, or in `set`."""
        names = (parameter.name for parameter in self.parameters)
        return dict(zip(names, self._scene.values(only_parameters(parameters, set))))

    def run(
        self,
        *,
        method: str | None = None,
        tolerance: Number | None = None,
        step: Number | None = None,
        end_time: Number | None = None,
        until: str | None = None,
        start: Mapping[str, Number] | None = None,
        max_step: Number | None = None,
        projection: str | None = None,
        closure_tolerance: Number | None = None,
        closure_iterations: int | None = None,
        every: int = 1,
        estimate_error: bool = True,
        set: Mapping[str, Number] | None = None,
        **parameters: Number,
    ) -> Result:
        """Runs the mechanism, as `qrm run` does, and returns the rows.

        Parameters
        ----------
        method : the integration method, `"rk4"` by default; see `qrm.methods()`.
        tolerance : largest error of a step of a method that chooses its steps, in the unit of each coordinate and rate.
        step : step of the integration in s; of the rows, if the method chooses its steps. The scene's by default.
        end_time : end of the run in s.
        until : a condition that ends the run when it becomes true, such as `"phi2 >= 2*pi"`.
        start : coordinates and rates at the start, such as `{"phi2": 0.5, "phi2_dot": 10}`.
        max_step : longest step of a method that chooses its steps, in s.
        projection : `"mass"` by default, `"euclidean"` or `"none"`.
        closure_tolerance, closure_iterations : when the correction of the coordinates ends.
        every : keep every so many rows; the last one is always kept.
        estimate_error : whether a second run estimates the errors.
        set : parameters by name, for names that are options too.
        **parameters : parameters by name.

        Raises
        ------
        OptionError, SceneError : the run cannot begin.
        RunError : the run did not come to its end, or its numbers are not to be trusted; `result` has its rows.
        """
        options = split(
            parameters,
            set=set,
            method=method,
            tolerance=tolerance,
            step=step,
            end_time=end_time,
            until=until,
            start=start,
            max_step=max_step,
            projection=projection,
            closure_tolerance=closure_tolerance,
            closure_iterations=closure_iterations,
        )
        return self._run(options, every, estimate_error)

    def steady(
        self,
        *,
        period: Number | None = None,
        phase: str | None = None,
        cycles: int = 1,
        settle: int = 30,
        rows: int = 720,
        solve: tuple[str, str] | None = None,
        **options: Any,
    ) -> Steady:
        """The periodic motion that the mechanism settles into, with its Floquet multipliers, as `qrm steady` finds it.

        >>> motion = qrm.load("shaper").steady(solve=("J2", "fluctuation(phi2_dot) = 0.1"))
        >>> motion.solved["value"], motion.multipliers, motion.columns["P_motor"]["work"]

        Parameters
        ----------
        period : the period of loads and drives in s; that of the sines in their formulae by default.
        phase : the coordinate whose turns or oscillations are the cycles of a motion with a period of its own.
        cycles : the number of cycles in a period.
        settle : the number of periods of the ordinary motion before the search; with 0 it begins at the start.
        rows : the number of rows of the run over a period.
        solve : a parameter, and a condition for which its value is sought, such as `"mean(phi_dot) = 8 rad/s"`.
        **options : parameters, and `start`, `max_step` and the options of the method as in `run`; `method="auto"` and
            `tolerance=1e-12` by default.

        Raises
        ------
        OptionError, SceneError : an option is wrong.
        RunError : there is no such motion, or it is not found.
        """
        period = None if period is None else str(period)
        text, run = self._scene.steady(split(options), period, phase, [cycles, settle, rows], solve)
        return Steady(text, self._result(*run))

    def _run(self, options: dict[str, Any], every: int = 1, estimate_error: bool = True) -> Result:
        return self._result(*self._scene.run(options, every, estimate_error))

    def _result(self, values: NDArray[np.float64], summary: str, notes: list[str], problem: Exception | None) -> Result:
        result = Result(self.columns, values, summary, notes)
        if problem is not None:
            if isinstance(problem, RunError):
                problem.result = result
            raise problem
        for note in notes:
            warnings.warn(note, RunWarning, stacklevel=4)
        return result

    def sweep(
        self,
        *,
        paired: bool = False,
        extremes: bool = True,
        estimate_error: bool = True,
        threads: int | None = None,
        device: Literal["cpu", "gpu"] = "cpu",
        **values: Any,
    ) -> SweepTable:
        """Runs many designs on all cores, as `qrm sweep` does, and returns a structured array with a row for each.

        A parameter with several values is varied: `sweep(O2A=np.linspace(0.15, 0.25, 100), J2=[50, 100])` runs the 200
        combinations, those of the last parameter changing first. Some designs are run once more by themselves, and a
        `RunWarning` tells if one differs.

        Parameters
        ----------
        paired : run a design for each place of the values, which are equally many, instead of all combinations.
        extremes : whether the columns `NAME_min` and `NAME_max` of the outputs are computed.
        estimate_error : whether the error of each design is estimated.
        threads : how many cores to use; all by default.
        device : the processor that runs the designs: `"cpu"`, or `"gpu"` for the first GPU with CUDA.
        **values : values of parameters, and `step`, `end_time`, `until`, `max_step` and the options of the method as in
            `run`; the method is `"dop853"` by default.

        Raises
        ------
        OptionError, SceneError : an option is wrong. A design that fails is a row with its reason.
        """
        return sweep(
            self._scene,
            values,
            paired=paired,
            extremes=extremes,
            estimate_error=estimate_error,
            threads=threads,
            device=device,
        )

    def sensitivity(
        self,
        *,
        by: Sequence[str] = (),
        of: Sequence[str] = (),
        hessian_vector: Mapping[str, float] | None = None,
        check: bool = True,
        **options: Any,
    ) -> Sensitivity:
        """Derivatives of the end of the motion, and of extremes and integrals of the outputs, by parameters.

        Parameters
        ----------
        by : the parameters; all by default.
        of : the outputs, and `"end"` for the end of the motion; everything by default.
        hessian_vector : entries of a vector by parameters, for the products of the Hessians with it.
        check : whether errors are estimated by steps half as long, and derivatives compared with difference quotients.
        **options : parameters, and `step`, `end_time`, `until`, `max_step` and the options of the method as in `run`.

        Raises
        ------
        OptionError, SceneError : an option is wrong, or the motion cannot begin.
        RunError : the motion has no derivatives, or a check contradicts them.
        """
        if isinstance(by, str) or isinstance(of, str):
            raise TypeError("`by` and `of` are sequences of names, such as by=['O2A']")
        vector = [(name, float(entry)) for name, entry in (hessian_vector or {}).items()]
        found = self._scene.sensitivity(split(options), list(by), list(of), vector, check)
        if found["problem"] is not None:
            raise found["problem"]
        return Sensitivity(found)

    def objectives(self, by: Sequence[str], of: str | Sequence[str], **options: Any) -> Objectives:
        """Quantities such as `"maximum N3"` as functions of parameters, for `scipy.optimize`.

        >>> peak = m.objectives(by=["O2A", "BC"], of="maximum N6")
        >>> scipy.optimize.minimize(peak.fun, peak.x0, jac=peak.jac)
        """
        return Objectives(self, by, of, options)

    def modes(
        self,
        *,
        at: At | None = None,
        others: bool = True,
        set: Mapping[str, Number] | None = None,
        **parameters: Number,
    ) -> Modes:
        """The equilibria, and the natural frequencies and mode shapes about the one near the start or near `at`.

        `at` has values of coordinates that the scene gives at its start, such as `{"phi": 0.5}` or `"phi=30deg"`.
        Without `others` no other equilibria are sought. All other arguments are parameters; `set` has those that are
        called `at` or `others`.

        Raises
        ------
        OptionError : an option is wrong, or the mechanism has no degree of freedom.
        RunError : there is no equilibrium near.
        """
        return Modes(json.loads(self._scene.modes(only_parameters(parameters, set), positions(at), others)))

    def linearize(
        self,
        *,
        input: str | Sequence[str],
        output: str | Sequence[str],
        at: At | None = None,
        set: Mapping[str, Number] | None = None,
        **parameters: Number,
    ) -> LinearModel:
        """A linear model about the equilibrium near the start or near `at`, from parameters of loads to outputs.

        >>> model = m.linearize(input="T", output="x6")
        >>> scipy.signal.StateSpace(*model.state_space)

        An output is a coordinate, its rate `NAME_dot`, its acceleration `NAME_ddot`, or an output of the scene.
        """
        inputs, outputs = ([names] if isinstance(names, str) else list(names) for names in (input, output))
        found = self._scene.linearize(only_parameters(parameters, set), positions(at), inputs, outputs)
        return LinearModel(json.loads(found))

    def start(self, **options: Any) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The coordinates and rates at the start, which meet the constraints: two arrays of shape `(n,)`."""
        q, qd = self._scene.start(split(options))
        return q, qd

    def equations(
        self,
        q: ArrayLike | None = None,
        qd: ArrayLike | None = None,
        *,
        t: float = 0.0,
        set: Mapping[str, Number] | None = None,
        **parameters: Number,
    ) -> Equations:
        """The terms of the equations of motion at a state, and the accelerations and multipliers that follow.

        `q` and `qd` have shape `(n,)`, in the order of `coordinates`; those of the start are the default. They need not
        meet the constraints. All other arguments are parameters; `set` has those that are called `q`, `qd` or `t`.
        """
        options = only_parameters(parameters, set)
        if q is None or qd is None:
            own = self._scene.start(options)
            q, qd = (own[0] if q is None else q), (own[1] if qd is None else qd)
        vectors = [_numbers(name, vector) for name, vector in (("q", q), ("qd", qd))]
        found = self._scene.equations(options, t, *vectors)
        found["outputs"] = dict(zip((output.name for output in self.outputs), found["outputs"].tolist()))
        return Equations(**found)

    def accuracy(
        self,
        *,
        at: Sequence[float] = (),
        of: str | None = None,
        reference: str | None = None,
        budget: float | str = 30.0,
        **options: Any,
    ) -> Accuracy:
        """Measures run time and error of every method, as `qrm accuracy` does.

        Parameters
        ----------
        at : times in s at which runs are compared; eight up to the end by default.
        of : the column whose error counts, such as an output; the coordinates by default.
        reference : `"energy"`, `"scene"` or `"run"`; the best that is available by default.
        budget : no further measurement begins after this time in s; or a text such as `"30s"`. References take theirs.
        **options : parameters, `step`, `end_time` and `until`.
        """
        found = self._scene.accuracy(
            split(options), list(at), of, reference, budget if isinstance(budget, str) else f"{budget!r}s"
        )
        return Accuracy(found)

    def plot(self, *names: str, x: str = "t", axes: Axes | None = None, **options: Any) -> Axes:
        """Runs the mechanism, and plots columns of the result over another one by matplotlib.

        `options` are those of `run`.
        """
        return self._run(split(options)).plot(*names, x=x, axes=axes)

    def animate(self, *, height: int = 720, **options: Any) -> Page:
        """A page that shows the mechanism moving, for a cell of a notebook or a file.

        Without options the page simulates the scene itself, with a slider for each parameter, and bodies can be
        dragged. With options, which are those of `run`, it plays that run.
        """
        text = self._scene.animation(split(options)) if options else self._scene.page()
        return Page(self.name, text, height)


def _numbers(name: str, vector: ArrayLike) -> list[float]:
    array = np.asarray(vector)
    if np.iscomplexobj(array):
        raise TypeError(f"`{name}` must be real numbers")
    if array.ndim > 1:
        raise ValueError(f"`{name}` has shape {array.shape} instead of (n,)")
    numbers: list[float] = array.astype(np.float64).ravel().tolist()
    return numbers
