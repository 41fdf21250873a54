"""Slider-crank with a spring, a damper and a force. Scene: slider-crank. Haug (1992), example 6.1.8.

Independent coordinate: the crank angle q. The rod stays within (-pi/2, pi/2), so position follows in closed form.
"""
from math import asin, pi, sin, cos, sqrt
import numpy as np

NAME, END = 'slider-crank', 10.0
COORDINATES = ['q', 'x', 'p']
A, J1, M2, J2, K, C, L0, F = 0.5, 1.0, 1.0, 2.0, 1.0, 1.0, 1.0, 1.0
PARAMETERS = np.array([1.0])  # F
DESIGNS = None
START = np.array([pi / 2, 0.0])


def rates(y, par):
    q, w = y
    force, = par
    s, c = sin(q), cos(q)
    sp = -A * s
    cp = sqrt(1.0 - sp * sp)
    x = cp + A * c
    icp = 1.0 / cp
    kp = -A * c * icp
    kx = -sp * kp - A * s
    wp, wx = kp * w, kx * w
    dp = (A * s * w * w + sp * wp * wp) * icp
    dx = -cp * wp * wp - sp * dp - A * c * w * w
    s21, c21 = sp * c - cp * s, cp * c + sp * s
    e = cp + A * c
    il = 1.0 / sqrt(x * x - x * e + (0.25 + 0.25 * A * A) + 0.5 * A * c21)
    rate = (2.0 * x * wx - wx * e + x * (sp * wp + A * s * w) - 0.5 * A * s21 * (wp - w)) * (0.5 * il)
    tie = K + (C * rate - K * L0) * il  # force of spring and damper over length
    fq = -tie * (0.5 * A) * (0.5 * s21 + x * s)
    fx = tie * (0.5 * cp - x + 0.5 * A * c) + force
    fp = -tie * 0.5 * (x * sp - 0.5 * A * s21) - force * sp
    return w, (fq + kx * (fx - M2 * dx) + kp * (fp - J2 * dp)) / (J1 + M2 * kx * kx + J2 * kp * kp)


def coordinates(y, p):
    rod = asin(-A * sin(y[0]))
    return [y[0], cos(rod) + A * cos(y[0]), rod]


def scene(z, par):
    import sympy as sy
    q, x, p = z
    gx, gy = x - sy.cos(p) / 2 - A / 2 * sy.cos(q), -sy.sin(p) / 2 - A / 2 * sy.sin(q)
    length = sy.sqrt(gx**2 + gy**2)
    return dict(bodies=[(0, 0, 0, q, J1), (M2, x, 0, 0, 0), (0, 0, 0, p, J2)],
                constraints=[x - sy.cos(p) - A * sy.cos(q), -sy.sin(p) - A * sy.sin(q)],
                potential=K / 2 * (length - L0)**2 - par[0] * (x + sy.cos(p)), dampers=[(C, length)])


# q, x, p at the end (references.py)
EXACT = [1.2756758486502393, 1.0235785589798394, -0.4988130491824987]
EXACT_DESIGNS = None
