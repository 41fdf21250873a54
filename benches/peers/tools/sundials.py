"""SUNDIALS, the C library as scikit-sundae ships it, called through ctypes with callbacks compiled by numba.

CVODE: Adams methods with the fixed-point iteration, as its documentation advises for problems that are not stiff, on
the reduced equations. IDA: BDF on the descriptor form with the constraints on positions and on velocities
(Gear, Gupta and Leimkuhler; index 2), as in its example idaSlCrank, with an analytical Jacobian, and with the algebraic
variables left out of the error test, as its documentation advises for index 2. With one tolerance for all variables
the Newton iteration stalls at small tolerances; the rows `loose multipliers` allow the multipliers an absolute 1e4.
"""
import ctypes, functools, glob, os
import numba
import numpy as np
import sksundae
import sympy as sy
from numba import types
from common import Case, TOLERANCES, designs, in_place, jit, kinds
from descriptor import compiled, consistent, derive

NAME, VERSION = 'SUNDIALS', f'{sksundae.SUNDIALS_VERSION} (scikit-sundae {sksundae.__version__})'
FOLDER = os.path.join(os.path.dirname(os.path.dirname(sksundae.__file__)), 'scikit_sundae.libs')
POINTER, REAL, INT = ctypes.c_void_p, ctypes.c_double, ctypes.c_int


def library(name):
    return ctypes.CDLL(glob.glob(os.path.join(FOLDER, f'libsundials_{name}-*'))[0], ctypes.RTLD_GLOBAL)


CORE, VECTOR, MATRIX, LINEAR, CVODE, IDA = map(
    library, ['core', 'nvecserial', 'sunmatrixdense', 'sunlinsoldense', 'cvode', 'ida'])


def c(lib, name, *arguments, result=INT):
    f = getattr(lib, name)
    f.argtypes, f.restype = arguments, result
    return f


context_create = c(CORE, 'SUNContext_Create', INT, POINTER)
vector_make = c(VECTOR, 'N_VMake_Serial', INT, POINTER, POINTER, result=POINTER)
vector_data = c(VECTOR, 'N_VGetArrayPointer_Serial', POINTER, result=ctypes.POINTER(REAL))
matrix_make = c(MATRIX, 'SUNDenseMatrix', INT, INT, POINTER, result=POINTER)
matrix_data = c(MATRIX, 'SUNDenseMatrix_Data', POINTER, result=ctypes.POINTER(REAL))
linear_make = c(LINEAR, 'SUNLinSol_Dense', POINTER, POINTER, POINTER, result=POINTER)
CONTEXT = POINTER()
context_create(0, ctypes.byref(CONTEXT))
c(CORE, 'SUNContext_ClearErrHandlers', POINTER)(CONTEXT)


def vector(array):
    return vector_make(len(array), array.ctypes.data, CONTEXT)


def done(flag):
    if flag < 0:
        raise RuntimeError(f'SUNDIALS returned {flag}')


@functools.cache
def cvode_callback(problem):
    f, n, k = jit(in_place(problem, 'y, out, p')), len(problem.START), len(problem.PARAMETERS)

    @numba.cfunc(types.int32(types.float64, types.voidptr, types.voidptr, types.CPointer(types.float64)))
    def callback(t, y, dy, p):
        f(vector_data(y), vector_data(dy), p)
        return 0
    return callback


def prepare_cvode(problem, kind, tolerance):
    y, p = problem.START.copy(), np.ascontiguousarray(designs(problem, kind))
    out, current = np.zeros((len(p), len(y))), p[0].copy()
    start, state, t = vector(problem.START), vector(y), REAL()
    memory = c(CVODE, 'CVodeCreate', INT, POINTER, result=POINTER)(1, CONTEXT)  # CV_ADAMS
    done(c(CVODE, 'CVodeInit', POINTER, POINTER, REAL, POINTER)(memory, cvode_callback(problem).address, 0.0, start))
    done(c(CVODE, 'CVodeSStolerances', POINTER, REAL, REAL)(memory, tolerance, tolerance))
    done(c(CVODE, 'CVodeSetUserData', POINTER, POINTER)(memory, current.ctypes.data))
    done(c(CVODE, 'CVodeSetMaxNumSteps', POINTER, ctypes.c_long)(memory, 10**6))
    iteration = c(CVODE, 'SUNNonlinSol_FixedPoint', POINTER, INT, POINTER, result=POINTER)(state, 0, CONTEXT)
    done(c(CVODE, 'CVodeSetNonlinearSolver', POINTER, POINTER)(memory, iteration))
    restart = c(CVODE, 'CVodeReInit', POINTER, REAL, POINTER)
    stop, solve = c(CVODE, 'CVodeSetStopTime', POINTER, REAL), c(CVODE, 'CVode', POINTER, REAL, POINTER, POINTER, INT)
    keep = (y, current, t)

    def go():
        for i in range(len(p)):
            current[:] = p[i]
            restart(memory, 0.0, start)
            stop(memory, problem.END)
            done(solve(memory, problem.END, state, ctypes.byref(t), 1))
            out[i] = y

    return lambda: keep and None, go, lambda: [problem.coordinates(z, q) for z, q in zip(out, p)]


@functools.cache
def ida_callbacks(problem):
    d = derive(problem)
    n, m = len(d['q']), len(d['g'])
    lam, mu, dq, dv = sy.symbols(f'l0:{m}'), sy.symbols(f'm0:{m}'), sy.symbols(f'dq0:{n}'), sy.symbols(f'dv0:{n}')
    cj, v, G = sy.Symbol('cj'), sy.Matrix(d['v']), d['G']
    y, dy = [*d['q'], *d['v'], *lam, *mu], [*dq, *dv, *sy.symbols(f'x0:{2 * m}')]
    residual = sy.Matrix([sy.Matrix(dq) - v + G.T * sy.Matrix(mu),
                          d['M'] * sy.Matrix(dv) - d['f'] + G.T * sy.Matrix(lam), d['g'], G * v])
    jacobian = residual.jacobian(y) + cj * residual.jacobian(dy)
    size = len(y)
    f = compiled([y, dy, d['p']], list(residual), (size,))
    j = compiled([y, dy, [cj], d['p']], list(jacobian.T), (size * size,))  # by columns
    double = types.CPointer(types.float64)

    @numba.cfunc(types.int32(types.float64, types.voidptr, types.voidptr, types.voidptr, double))
    def res(t, y, dy, out, p):
        f(vector_data(y), vector_data(dy), p, vector_data(out))
        return 0

    @numba.cfunc(types.int32(types.float64, types.float64, types.voidptr, types.voidptr, types.voidptr, types.voidptr,
                             double, types.voidptr, types.voidptr, types.voidptr))
    def jac(t, cj, y, dy, r, matrix, p, a, b, c):
        j(vector_data(y), vector_data(dy), (cj,), p, matrix_data(matrix))
        return 0
    return res, jac


def prepare_ida(problem, tolerance, loose):
    res, jac = ida_callbacks(problem)
    p = problem.PARAMETERS.copy()
    q, v, a, lam = consistent(problem, problem.START, p)
    n, m = len(q), len(lam)
    first, rates = np.concatenate([q, v, lam, np.zeros(m)]), np.concatenate([v, a, np.zeros(2 * m)])
    kinds_of = np.concatenate([np.ones(2 * n), np.zeros(2 * m)])
    y, dy = first.copy(), rates.copy()
    arrays = (first, rates, kinds_of, y, dy, p)
    start, start_rates, identity, state, state_rates = map(vector, arrays[:5])
    memory, t = c(IDA, 'IDACreate', POINTER, result=POINTER)(CONTEXT), REAL()
    done(c(IDA, 'IDAInit', POINTER, POINTER, REAL, POINTER, POINTER)(memory, res.address, 0.0, start, start_rates))
    absolute = np.where(kinds_of == 1, tolerance, 1e4 if loose else tolerance)
    done(c(IDA, 'IDASVtolerances', POINTER, REAL, POINTER)(memory, tolerance, vector(absolute)))
    done(c(IDA, 'IDASetUserData', POINTER, POINTER)(memory, p.ctypes.data))
    done(c(IDA, 'IDASetMaxNumSteps', POINTER, ctypes.c_long)(memory, 10**6))
    done(c(IDA, 'IDASetId', POINTER, POINTER)(memory, identity))
    done(c(IDA, 'IDASetSuppressAlg', POINTER, INT)(memory, 1))
    matrix = matrix_make(len(y), len(y), CONTEXT)
    done(c(IDA, 'IDASetLinearSolver', POINTER, POINTER, POINTER)(memory, linear_make(state, matrix, CONTEXT), matrix))
    done(c(IDA, 'IDASetJacFn', POINTER, POINTER)(memory, jac.address))
    restart, stop = c(IDA, 'IDAReInit', POINTER, REAL, POINTER, POINTER), c(IDA, 'IDASetStopTime', POINTER, REAL)
    solve = c(IDA, 'IDASolve', POINTER, REAL, POINTER, POINTER, POINTER, INT)

    def go():
        restart(memory, 0.0, start, start_rates)
        stop(memory, problem.END)
        done(solve(memory, problem.END, ctypes.byref(t), state, state_rates, 1))

    return lambda: arrays and None, go, lambda: [y[:n]]


def cases(problem):
    for kind in kinds(problem):
        for tolerance in TOLERANCES:
            yield Case(kind, 'CVODE Adams', 'fixed point, numba', tolerance,
                       lambda k=kind, t=tolerance: prepare_cvode(problem, k, t), len(designs(problem, kind)))
    if len(derive(problem)['g']):
        for loose in False, True:
            for tolerance in TOLERANCES:
                yield Case('run', 'IDA', 'GGL, Jacobian, numba' + ', loose multipliers' * loose, tolerance,
                           lambda t=tolerance, l=loose: prepare_ida(problem, t, l))
