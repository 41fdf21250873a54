"""SciPy: solve_ivp with DOP853, Radau and LSODA. The right-hand side is compiled by numba; the stepping is Python,
except for LSODA. The documentation advises DOP853 for low tolerances and Radau for stiff problems."""
import numpy as np
import scipy
from scipy.integrate import solve_ivp
from common import Case, TOLERANCES, compiled_rates, jit, values

NAME, VERSION = 'scipy', scipy.__version__


def function(problem):
    scope = {'rates': compiled_rates(problem), 'np': np}
    n, k = len(problem.START), len(problem.PARAMETERS)
    exec(f'def f(t, y, p): return np.array(rates(({values("y", n)}), ({values("p", k)})))', scope)
    return jit(scope['f'])


def prepare(problem, method, tolerance):
    f, p, out = function(problem), problem.PARAMETERS, [None]

    def go():
        out[0] = solve_ivp(f, (0.0, problem.END), problem.START, method, t_eval=[problem.END], args=(p,),
                           rtol=tolerance, atol=tolerance)

    def end():
        if not out[0].success:
            raise RuntimeError(out[0].message)
        return [problem.coordinates(out[0].y[:, -1], p)]

    return lambda: None, go, end


def cases(problem):
    for method in 'DOP853', 'Radau', 'LSODA':
        for tolerance in TOLERANCES:
            if tolerance > 3e-14 and not (method == 'Radau' and tolerance < 1e-11):
                yield Case('run', method, 'numba', tolerance, lambda m=method, t=tolerance: prepare(problem, m, t))
