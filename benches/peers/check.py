"""Checks the reduced equations of every problem: constraints, accelerations against the descriptor form that SymPy
derives from the bodies, energy, and the end state against the literals by SciPy."""
import sys
import numpy as np
from scipy.integrate import solve_ivp
from common import compiled_rates, designs, exact, kinds
from descriptor import consistent, numeric
from problems import PROBLEMS


def trajectory(problem, p, points=50):
    f = compiled_rates(problem)
    n, p = len(problem.START), tuple(map(float, p))
    s = solve_ivp(lambda t, y: f(tuple(y), p), (0, problem.END), problem.START, 'DOP853', rtol=1e-13, atol=1e-13,
                  t_eval=np.linspace(0, problem.END, points))
    return s.t, s.y.T


def check(problem):
    f, functions, failures = compiled_rates(problem), numeric(problem), []

    def expect(name, size, limit):
        print(f'{problem.NAME:16} {name:36} {size:9.1e}  limit {limit:.0e}')
        if not size <= limit:
            failures.append(f'{problem.NAME}: {name}')

    for kind in kinds(problem):
        for p, end in zip(designs(problem, kind), exact(problem, kind)):
            t, states = trajectory(problem, p)
            residual = rate = difference = imbalance = 0.0
            energies = []
            for y in states:
                q, v, a, _ = consistent(problem, y, p)
                residual = max(residual, np.abs(functions['g'](q, v, p)).max(initial=0))
                rate = max(rate, np.abs(functions['G'](q, v, p) @ v).max(initial=0) / (1 + np.abs(v).max()))
                h = len(y) // 2
                reduced = np.array(f(tuple(y), tuple(map(float, p))))[h:]
                independent = [y0 for y0 in a[:h]]
                if hasattr(problem, 'velocities'):  # Cartesian coordinates of an angle
                    independent = [q[0] * a[1] - q[1] * a[0]]
                difference = max(difference, np.abs(reduced - independent).max() / (1 + np.abs(a).max()))
                energies.append([functions['energy'](q, v, p)[0], np.abs(functions['M'](q, v, p) @ v @ v) / 2])
            energies = np.array(energies)
            scale = energies[:, 1].max()
            if kind == 'run' or p is designs(problem, kind)[0]:
                expect('residual of the constraints', residual, 1e-13)
                expect('residual of their rates', rate, 1e-12)
                expect('accelerations, SymPy, relative', difference, 1e-11)
                if np.any(functions['power'](q, v, p)):
                    # the work of the dampers, by integration along with the motion
                    def extended(t, z):
                        q, v, _, _ = consistent(problem, z[:-1], p)
                        return np.append(f(tuple(z[:-1]), tuple(map(float, p))), functions['power'](q, v, p))
                    z = solve_ivp(extended, (0, problem.END), np.append(problem.START, 0.0), 'DOP853', rtol=1e-11,
                                  atol=1e-11)
                    energies[-1, 0] -= z.y[-1, -1]
                    imbalance = abs(energies[-1, 0] - energies[0, 0]) / scale
                else:
                    imbalance = np.abs(energies[:, 0] - energies[0, 0]).max() / scale
                expect('energy, relative', imbalance, 1e-9)
            expect('end state, DOP853 of SciPy', np.abs(np.array(problem.coordinates(states[-1], p)) - end).max(), 1e-9)
    return failures


if __name__ == '__main__':
    failed = sum((check(p) for p in PROBLEMS if len(sys.argv) == 1 or p.NAME in sys.argv[1:]), [])
    print('\n'.join('failed: ' + f for f in failed) or 'all checks passed')
    sys.exit(bool(failed))
