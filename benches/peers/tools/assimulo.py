"""Assimulo: RADAU5 of Hairer and Wanner (its C translation) on the reduced equations. The right-hand side is compiled by
numba; the solver calls it through Python. The package is the project's test release, the only recent one for pip."""
import functools, importlib.metadata
import numpy as np
from assimulo.problem import Explicit_Problem
from assimulo.solvers import Radau5ODE
from common import Case, TOLERANCES, compiled_rates, jit, values

NAME, VERSION = 'Assimulo', importlib.metadata.version('assimulo-testing')


@functools.cache
def function(problem):
    scope = {'rates': compiled_rates(problem), 'np': np}
    n, p = len(problem.START), tuple(map(float, problem.PARAMETERS))
    scope['p'] = p
    exec(f'def f(t, y): return np.array(rates(({values("y", n)}), p))', scope)
    return jit(scope['f'])


def prepare(problem, tolerance):
    solver, out = [None], [None]
    f = function(problem)
    f(0.0, problem.START)

    def reset():
        s = Radau5ODE(Explicit_Problem(f, problem.START.copy(), 0.0))
        s.rtol = s.atol = tolerance
        s.verbosity = 50
        s.maxsteps = 1000000
        s.inith = 1e-4 * problem.END
        solver[0] = s

    def go():
        out[0] = solver[0].simulate(problem.END, 1)[1]
    return reset, go, lambda: [problem.coordinates(out[0][-1], problem.PARAMETERS)]


def cases(problem):
    for tolerance in TOLERANCES:
        if tolerance > 1e-12:
            yield Case('run', 'RADAU5', 'numba', tolerance, lambda t=tolerance: prepare(problem, t))
