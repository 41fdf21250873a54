"""CyRK: Runge-Kutta and other methods in C++ with a right-hand side compiled by numba (nbsolve2_ivp), so that no
Python runs between steps. A sweep integrates the designs in turn."""
import functools
import CyRK
import numpy as np
from numba import carray, njit
from CyRK.nb.numba_solver import nb_diffeq_addr, nbsolve2_ivp
from common import Case, TOLERANCES, designs, in_place, kinds

NAME, VERSION = 'CyRK', CyRK.__version__
METHODS = ['DOP853', 'Vern8', 'RADAU']


@functools.cache
def address(problem):
    f = in_place(problem, 'out, y, p')
    jitted = njit(error_model='numpy')(f)

    def callback(dy, t, y, args):
        jitted(dy, y, args)
    return nb_diffeq_addr(callback)


@njit
def drive(address, end, start, parameters, method, tolerance, out):
    for i in range(len(parameters)):
        s = nbsolve2_ivp(address, (0.0, end), start, method, None, False, parameters[i], tolerance, tolerance)
        if s.success:
            out[i] = s.y[:, -1]
        else:
            out[i] = np.nan
        s.free()


def prepare(problem, kind, method, tolerance):
    a, p = address(problem), designs(problem, kind).copy()
    out = np.zeros((len(p), len(problem.START)))
    end = lambda: [problem.coordinates(y, q) for y, q in zip(out, p)]
    return lambda: None, lambda: drive(a, problem.END, problem.START, p, method, tolerance, out), end


def cases(problem):
    for kind in kinds(problem):
        for method in METHODS if kind == 'run' else METHODS[:2]:
            for tolerance in TOLERANCES:
                if method != 'RADAU' or tolerance > 1e-12:
                    yield Case(kind, method, 'numba', tolerance,
                               lambda k=kind, m=method, t=tolerance: prepare(problem, k, m, t), len(designs(problem, kind)))
