"""Equations of motion in all coordinates of a scene, derived by SymPy from its bodies: the descriptor form.

    M(q) v' + G(q)' lambda = f(q, v),   g(q) = 0,   G = dg/dq

Functions are compiled by numba. `check.py` holds them against the reduced equations, and IDA integrates them.
"""
import functools
import numpy as np
import sympy as sy
from common import jit


def compiled(inputs, outputs, shape):
    """Straight-line code with common subexpressions: f(*arrays, out)."""
    names = [f'a{i}' for i in range(len(inputs))]
    access = {s: sy.Symbol(f'{n}_{j}') for n, group in zip(names, inputs) for j, s in enumerate(group)}
    shared, final = sy.cse([sy.sympify(e) for e in outputs], symbols=sy.numbered_symbols('t'), order='none')
    code = [f'def f({", ".join(names)}, out):']
    for n, group in zip(names, inputs):
        code += [f'    {s} = {n}[{j}]' for j, s in enumerate(group)]
    text = functools.partial(sy.pycode, fully_qualified_modules=False)
    code += [f'    {s} = {text(e)}' for s, e in shared]
    for k, e in enumerate(final):
        place = ', '.join(map(str, np.unravel_index(k, shape)))
        code += [f'    out[{place}] = {text(e)}']
    scope = {}
    exec('from math import sin, cos, sqrt\n' + '\n'.join(code), scope)
    return jit(scope['f'])


@functools.cache
def derive(problem):
    """Symbols and expressions of the descriptor form."""
    n = len(problem.COORDINATES)
    q, v = sy.symbols(f'q0:{n}'), sy.symbols(f'v0:{n}')
    p = sy.symbols(f'p0:{len(problem.PARAMETERS)}')
    s = problem.scene(q, p)
    rate = lambda e: sum((sy.diff(e, a) * b for a, b in zip(q, v)), sy.Integer(0))
    M, f = sy.zeros(n, n), sy.zeros(n, 1)
    for mass, x, y, angle, inertia in s['bodies']:
        for weight, e in (mass, x), (mass, y), (inertia, angle):
            e = sy.sympify(e)
            row = sy.Matrix([[sy.diff(e, a) for a in q]])
            M += weight * row.T * row
            f -= weight * row.T * rate(rate(e))
    f -= sy.Matrix([sy.diff(s['potential'], a) for a in q])
    power = 0
    for coefficient, e in s.get('dampers', []):
        f -= coefficient * rate(e) * sy.Matrix([sy.diff(e, a) for a in q])
        power -= coefficient * rate(e)**2
    g = sy.Matrix(s['constraints']) if s['constraints'] else sy.zeros(0, 1)
    G = g.jacobian(q) if len(g) else sy.zeros(0, n)
    energy = (sy.Matrix([v]) * M * sy.Matrix(v))[0] / 2 + s['potential']
    return dict(q=q, v=v, p=p, M=M, f=f, g=g, G=G, c=sy.Matrix([rate(rate(e)) for e in g]), energy=energy, power=power)


@functools.cache
def numeric(problem):
    """M, f, g, G, c = (G v)_q v, energy and power of dampers as functions of (q, v, p)."""
    d = derive(problem)
    n, m = len(d['q']), len(d['g'])
    shapes = dict(M=(n, n), f=(n,), g=(m,), G=(m, n), c=(m,), energy=(1,), power=(1,))

    def function(name):
        e = d[name]
        code = compiled([d['q'], d['v'], d['p']], list(e) if hasattr(e, 'shape') else [e], shapes[name])

        def call(q, v, p):
            out = np.zeros(shapes[name])
            code(np.array(q, float), np.array(v, float), np.array(p, float), out)
            return out
        return call
    return {name: function(name) for name in shapes}


def accelerations(problem, q, v, p):
    """v' and lambda from the linear system of the descriptor form."""
    f = numeric(problem)
    M, G = f['M'](q, v, p), f['G'](q, v, p)
    m = len(G)
    A = np.block([[M, G.T], [G, np.zeros((m, m))]])
    x = np.linalg.solve(A, np.concatenate([f['f'](q, v, p), -f['c'](q, v, p)]))
    return x[:len(M)], x[len(M):]


def consistent(problem, y, p):
    """All coordinates, all rates, accelerations and multipliers at a state of the independent coordinates."""
    h = len(y) // 2
    q = np.array(problem.coordinates(y, p), float)
    if hasattr(problem, 'velocities'):
        v = np.array(problem.velocities(y, p), float)
    elif len(q) == h:
        v = np.array(y[h:], float)
    else:
        G = numeric(problem)['G'](q, q, p)
        v = np.zeros(len(q))
        v[0] = y[1]
        v[1:] = np.linalg.solve(G[:, 1:], -G[:, 0] * y[1])
    return q, v, *accelerations(problem, q, v, p)
