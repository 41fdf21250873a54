"""Two point masses on rods, released at rest. Scene: double-pendulum, to t = 5.

The motion is chaotic: an error grows by a factor of about 1e4 in the ten seconds of the scene. No constraint.
"""
from math import pi, sin, cos, sqrt
import numpy as np

NAME, END = 'double-pendulum', 5.0
COORDINATES = ['a', 'b']
PARAMETERS = np.array([9.81])  # g / l
DESIGNS = None
START = np.array([2 * pi / 3, 2 * pi / 3, 0.0, 0.0])


def rates(y, p):
    a, b, v, w = y
    g, = p
    sa, ca, sb, cb = sin(a), cos(a), sin(b), cos(b)
    s, c = sa * cb - ca * sb, ca * cb + sa * sb
    f1 = -s * w * w - 2.0 * g * sa
    f2 = s * v * v - g * sb
    i = 1.0 / (1.0 + s * s)
    return v, w, (f1 - c * f2) * i, (2.0 * f2 - c * f1) * i


def coordinates(y, p):
    return [y[0], y[1]]


def scene(q, p):
    from sympy import sin, cos
    a, b = q
    bodies = [(1, sin(a), -cos(a), 0, 0), (1, sin(a) + sin(b), -cos(a) - cos(b), 0, 0)]
    return dict(bodies=bodies, constraints=[], potential=p[0] * (bodies[0][2] + bodies[1][2]))


# a, b at the end (references.py)
EXACT = [-2.0769407430038126, -1.59711636659436626]
EXACT_DESIGNS = None
