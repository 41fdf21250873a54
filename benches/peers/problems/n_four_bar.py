"""Two coupled four-bars of equal rods under gravity. Scene: n-four-bar-2, to t = 0.6.

At t = 0.714 all rods lie in line for the first time and the loops lose their rank. Reduced equations divide by zero
there, so the end lies before it. The scene itself goes on. The cranks stay parallel; that is not used: each loop is
closed by the intersection of two circles. Independent coordinate: the angle a0 of the first crank.
"""
from math import atan2, pi, sin, cos, sqrt
import numpy as np

NAME, END = 'n-four-bar-2', 0.6
COORDINATES = ['a0', 'a1', 'a2', 'b0', 'b1']
L, M, G = 1.0, 1.0, 9.81
J = M * L * L / 12
PARAMETERS = np.array([G])
DESIGNS = None
START = np.array([pi / 2, -1.0])


def close(bx, by, ax, ay):
    """The tip of a crank on (ax, ay) at the end of a coupler from (bx, by)."""
    dx, dy = ax - bx, ay - by
    h = sqrt(L * L / (dx * dx + dy * dy) - 0.25)
    return 0.5 * (ax + bx) - h * dy, 0.5 * (ay + by) + h * dx


def loop(rx, ry, sx, sy, ux, uy, w, d, v):
    """Ratios of a loop: crank r, next crank s, coupler u. From the rate ratio w of r, its acceleration d and the speed v
    of the independent coordinate: ratios and accelerations of s and u."""
    i = 1.0 / (ux * sy - uy * sx)
    ws = w * (ux * ry - uy * rx) * i
    wu = w * (rx * sy - ry * sx) * -i
    # e = d perp(r) - r w^2 v^2 - u wu^2 v^2 + s ws^2 v^2 = ds perp(s) - du perp(u)
    w2, s2, u2 = w * w * v * v, ws * ws * v * v, wu * wu * v * v
    ex, ey = -d * ry - rx * w2 - ux * u2 + sx * s2, d * rx - ry * w2 - uy * u2 + sy * s2
    return ws, wu, -(ux * ex + uy * ey) * i, -(sx * ex + sy * ey) * i


def rates(y, p):
    a0, v = y
    g, = p
    rx, ry = L * cos(a0), L * sin(a0)
    b1x, b1y = close(rx, ry, L, 0.0)
    b2x, b2y = close(b1x, b1y, 2 * L, 0.0)
    sx, sy, tx, ty = b1x - L, b1y, b2x - 2 * L, b2y
    ux, uy, qx, qy = b1x - rx, b1y - ry, b2x - b1x, b2y - b1y
    k1, k3, d1, d3 = loop(rx, ry, sx, sy, ux, uy, 1.0, 0.0, v)
    k2, k4, d2, d4 = loop(sx, sy, tx, ty, qx, qy, k1, d1, v)
    crank, carrying, coupler = J + M * L * L / 4, J + M * L * L * 1.25, J + M * L * L / 4
    m03, m14 = 0.5 * M * (rx * ux + ry * uy), 0.5 * M * (sx * qx + sy * qy)
    c03, c14 = 0.5 * M * (ux * ry - uy * rx), 0.5 * M * (qx * sy - qy * sx)
    w1, w3, w4 = k1 * v, k3 * v, k4 * v
    f0, f3 = -1.5 * M * g * rx - c03 * w3 * w3, -0.5 * M * g * ux + c03 * v * v
    f1, f4 = -1.5 * M * g * sx - c14 * w4 * w4, -0.5 * M * g * qx + c14 * w1 * w1
    f2 = -0.5 * M * g * tx
    h1, h2, h3, h4 = carrying * k1 + m14 * k4, crank * k2, m03 + coupler * k3, m14 * k1 + coupler * k4
    h0 = carrying + m03 * k3
    load = f0 + f1 * k1 + f2 * k2 + f3 * k3 + f4 * k4 - h1 * d1 - h2 * d2 - h3 * d3 - h4 * d4
    return v, load / (h0 + h1 * k1 + h2 * k2 + h3 * k3 + h4 * k4)


def coordinates(y, p):
    bx, by = L * cos(y[0]), L * sin(y[0])
    cx, cy = close(bx, by, L, 0.0)
    ex, ey = close(cx, cy, 2 * L, 0.0)
    return [y[0], atan2(cy, cx - L), atan2(ey, ex - 2 * L), atan2(cy - by, cx - bx), atan2(ey - cy, ex - cx)]


def scene(q, p):
    from sympy import sin, cos
    tips = [(i * L + L * cos(q[i]), L * sin(q[i])) for i in range(3)]
    bodies = [(M, i * L + L / 2 * cos(q[i]), L / 2 * sin(q[i]), q[i], J) for i in range(3)]
    bodies += [(M, tips[i][0] + L / 2 * cos(q[3 + i]), tips[i][1] + L / 2 * sin(q[3 + i]), q[3 + i], J) for i in range(2)]
    return dict(bodies=bodies, potential=p[0] * sum(m * y for m, x, y, a, i in bodies),
                constraints=[e for i in range(2) for e in (tips[i][0] + L * cos(q[3 + i]) - tips[i + 1][0],
                                                            tips[i][1] + L * sin(q[3 + i]) - tips[i + 1][1])])


# a0, a1, a2, b0, b1 at the end (references.py)
EXACT = [0.485744534059416059, 0.485744534059416059, 0.485744534059416059, 0.0, 0.0]
EXACT_DESIGNS = None
