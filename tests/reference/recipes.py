"""Ends of the scenes in scenes/recipes by other equations:

    python3 tests/reference/recipes.py > tests/reference/recipes.csv

Needs numpy, scipy and sympy. Each mechanism is integrated in as many coordinates as it has degrees of freedom, rods as
rigid or flexible continua, by DOP853 with a relative tolerance of 1e-13.
"""

import numpy as np
import sympy
from scipy.integrate import solve_ivp


def end(rates, start, t):
    found = solve_ivp(rates, (0, t), start, method="DOP853", rtol=1e-13, atol=1e-15, first_step=1e-7)
    assert found.success, found.message
    return found.y[:, -1]


def governor():
    """Momentum about the shaft is constant, so the shaft is eliminated; the rods have integrals."""
    h, a, l, m, ball, ms, k, c, l0, g = 1, 0.05, 1, 0.3, 5, 3, 8e5, 4e4, 0.5, 9.81
    own = 0.3 * (0.01**2 + 0.01**2) / 12 + 3 * (0.1**2 + 0.1**2) / 12
    about_joint = 2 * (m * l**2 / 3 + ball * l**2)

    def about_shaft(alpha):
        cos, sin = np.cos(alpha), np.sin(alpha)
        r = a + l * cos
        rods = m * (a**2 + a * l * cos + l**2 * cos**2 / 3)
        return own + 2 * (rods + ball * r**2), -2 * sin * (m * (a * l + 2 * l**2 * cos / 3) + 2 * ball * l * r)

    alpha0, s0 = np.pi / 6, 0.5
    momentum = about_shaft(alpha0)[0] * 2 * np.pi

    def rates(_, y):
        _, alpha, s, alpha_dot, s_dot = y
        inertia, slope = about_shaft(alpha)
        omega = momentum / inertia
        across, up = l / 2 * np.cos(alpha), h - l / 2 * np.sin(alpha) - s
        length = np.hypot(across, up)
        by_alpha = (-across * np.sin(alpha) - up * np.cos(alpha)) * l / 2 / length
        by_s = -up / length
        force = -2 * (k * (length - l0) + c * (by_alpha * alpha_dot + by_s * s_dot))
        weight = 2 * g * np.cos(alpha) * (m * l / 2 + ball * l)
        alpha_ddot = (omega**2 * slope / 2 + weight + force * by_alpha) / about_joint
        return [omega, alpha_dot, s_dot, alpha_ddot, force * by_s / ms - g]

    theta, alpha, s, _, _ = end(rates, [0, alpha0, s0, 0, 0], 10)
    yield from {"theta": theta, "alpha": alpha, "s": s}.items()


def bricard():
    """One angle: the joints turn by two angles in turn, of which one follows from the other. Each rod is rigid."""
    a = sympy.Symbol("a")
    c = sympy.asin(-sympy.sin(a) / (1 + sympy.sin(a)))

    def turn(axis, angle):
        cos, sin = sympy.cos(angle), sympy.sin(angle)
        rows = [[1, 0, 0], [0, cos, -sin], [0, sin, cos]]
        return sympy.Matrix(3, 3, lambda i, j: rows[(i - axis) % 3][(j - axis) % 3])

    # Along edges of a cube where all angles are zero; the joints turn about the axes y, z, x, y, z and x.
    joints = [sympy.Matrix(v) for v in [(0, 0, 0), (1, 0, 0), (1, -1, 0), (1, -1, 1), (0, -1, 1), (0, 0, 1)]]
    frame, place, ends = sympy.eye(3), joints[0], [joints[0]]
    kinetic, potential = 0, 0
    for i in range(6):
        frame = frame * turn((i + 1) % 3, a if i % 2 == 0 else c)
        place = place + frame * (joints[(i + 1) % 6] - joints[i])
        ends.append(place)
    loop = sympy.lambdify(a, list(frame - sympy.eye(3)) + list(place), "numpy")
    assert max(abs(value) for x in (-0.3, 0.4, 1.2, 2.9) for value in loop(x)) < 1e-13
    for p, q in zip(ends[:5], ends[1:6]):
        v, w = p.diff(a), q.diff(a)
        # The integral along a rod of unit mass whose velocity is linear between its ends.
        kinetic += (v.dot(v) + v.dot(w) + w.dot(w)) / 6
        potential += 9.81 * (p[1] + q[1]) / 2
    functions = [kinetic, sympy.diff(kinetic, a), sympy.diff(potential, a)]
    inertia, slope, weight = (sympy.lambdify(a, f, "numpy", cse=True) for f in functions)

    def rates(_, y):
        return [y[1], -(weight(y[0]) + slope(y[0]) * y[1] ** 2) / (2 * inertia(y[0]))]

    a_end, rate = end(rates, [0, 0], 10)
    yield from {"a": a_end, "a_dot": rate}.items()


def flexible_crank():
    """The crank is driven, so the chord of the rod is known; its modes have integrals, and linear equations."""
    r, l, w = 0.15, 0.3, 50
    mass, stiffness = 7870 * np.pi * 0.006**2 / 4 * l, 2e11 * np.pi * 0.006**4 / 64 / l**3
    one = np.polynomial.Polynomial
    modes = [one([0, 16 / 5, 0, -32 / 5, 16 / 5]), one([0, 1, 0, -10, 15, -6])]

    def integral(polynomial):
        return polynomial.integ()(1) - polynomial.integ()(0)

    masses = np.array([integral(mode**2) for mode in modes]) * mass
    springs = np.array([integral(mode.deriv(2) ** 2) for mode in modes]) * stiffness
    shifts = np.array([integral(mode) for mode in modes]) * mass
    turns = np.array([integral(mode * one([0, l])) for mode in modes]) * mass

    def rates(t, y):
        q, q_dot = y[:2], y[2:]
        phi = w * t
        psi = np.arcsin(-r / l * np.sin(phi))
        psi_dot = -r / l * w * np.cos(phi) / np.cos(psi)
        psi_ddot = (r / l * w**2 * np.sin(phi) + psi_dot**2 * np.sin(psi)) / np.cos(psi)
        across = r * w**2 * (np.cos(phi) * np.sin(psi) - np.sin(phi) * np.cos(psi))
        q_ddot = psi_dot**2 * q - (springs * q + shifts * across + turns * psi_ddot) / masses
        return [*q_dot, *q_ddot]

    q1, q2, q1_dot, _ = end(rates, [0, 0, 0, 0], 0.3)
    yield from {"q1": q1, "q2": q2, "q1_dot": q1_dot}.items()


if __name__ == "__main__":
    print("scene,quantity,value")
    for scene in (governor, bricard, flexible_crank):
        for name, value in scene():
            print(f"{scene.__name__.replace('_', '-')},{name},{value:.17g}")
