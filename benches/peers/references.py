"""Recomputes the exact end states of all problems in two ways and compares them with the literals in problems/:

- Taylor series of heyoka in long double, tolerance 1e-20, on the reduced equations;
- extrapolation of the midpoint rule (order 20) by mpmath with 32 digits, in N and 3/2 N steps that must agree.

Takes a few minutes. Prints the literals and the differences; ends with an error if one exceeds 1e-13.
"""
import sys
import heyoka as hy
import mpmath as mp
import numpy as np
from common import designs, exact, kinds, with_functions
from problems import PROBLEMS

mp.mp.dps = 32
NAMES = dict(sin=mp.sin, cos=mp.cos, sqrt=mp.sqrt, asin=mp.asin, atan2=mp.atan2, pi=mp.pi)
STEPS = {'quick-return': 60, 'andrews': 160, 'slider-crank': 40, 'n-four-bar-2': 16, 'pendulum': 500, 'double-pendulum': 200}


def extrapolated(f, y, end, steps):
    n = [2 * k for k in range(1, 11)]
    h = end / steps
    for _ in range(steps):
        table = []
        for j, count in enumerate(n):
            d = h / count
            a, b = y, [u + d * v for u, v in zip(y, f(y))]
            for _ in range(count - 1):
                a, b = b, [u + 2 * d * v for u, v in zip(a, f(b))]
            # smoothing: half of the last point, a half step back, and a step from the one before
            row = [[(u + w + d * v) / 2 for u, w, v in zip(a, b, f(b))]]
            for k in range(1, j + 1):
                ratio = (mp.mpf(n[j]) / n[j - k])**2 - 1
                row.append([u + (u - w) / ratio for u, w in zip(row[k - 1], table[j - 1][k - 1])])
            table.append(row)
        y = table[-1][-1]
    return y


def by_mpmath(problem, p):
    # decimal parameters as they are written: doubles, as all tools have them
    f = with_functions(problem.rates, **NAMES)
    ends = with_functions(problem.coordinates, **NAMES)
    p, y, end = [mp.mpf(float(v)) for v in p], [mp.mpf(float(v)) for v in problem.START], mp.mpf(problem.END)
    runs = [extrapolated(lambda z: f(z, p), y, end, k) for k in (STEPS[problem.NAME], STEPS[problem.NAME] * 3 // 2)]
    runs = [ends(y, p) for y in runs]
    return runs[1], max(abs(a - b) for a, b in zip(*runs))


def by_heyoka(problem, p):
    real = np.longdouble
    y = hy.make_vars(*[f'y{i}' for i in range(len(problem.START))])
    f = with_functions(problem.rates, sin=hy.sin, cos=hy.cos, sqrt=hy.sqrt)(y, [hy.par[i] for i in range(len(p))])
    ta = hy.taylor_adaptive(list(zip(y, f)), problem.START.astype(real), pars=np.array(p, real), tol=real(1e-20),
                            fp_type=real, compact_mode=True)
    ta.propagate_until(real(problem.END))
    text = lambda v: mp.mpf(np.format_float_scientific(v, unique=False, precision=22))
    return with_functions(problem.coordinates, **NAMES)([text(v) for v in ta.state], [text(real(v)) for v in p])


if __name__ == '__main__':
    worst = 0
    for problem in PROBLEMS:
        if len(sys.argv) > 1 and problem.NAME not in sys.argv[1:]:
            continue
        for kind in kinds(problem):
            for p, literal in zip(designs(problem, kind), exact(problem, kind)):
                a, uncertainty = by_mpmath(problem, p)
                b = by_heyoka(problem, p)
                apart = max(abs(x - y) for x, y in zip(a, b))
                off = max(abs(x - mp.mpf(float(y))) for x, y in zip(a, literal))
                worst = max(worst, apart, off)
                print(problem.NAME, kind, '[' + ', '.join(mp.nstr(x, 18) for x in a) + ']', flush=True)
                print('    mpmath uncertain by', mp.nstr(uncertainty, 2), 'heyoka differs by', mp.nstr(apart, 2),
                      'literals by', mp.nstr(off, 2), flush=True)
    sys.exit(worst > 1e-13)
