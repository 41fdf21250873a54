"""A point mass on a rod, in Cartesian coordinates. Scene: pendulum. IFToMM benchmark A01, 42 swings.

Independent coordinate: the angle from the downward vertical.
"""
from math import pi, sin, cos, sqrt
import numpy as np

NAME, END = 'pendulum', 100.0
COORDINATES = ['x', 'y']
PARAMETERS = np.array([9.81])  # g / l
DESIGNS = None
START = np.array([pi / 2, 0.0])
# The Taylor series about the start has the powers 4 k + 2 alone. heyoka judges its step by the last two coefficients, and
# where both are zero (orders 12, 16, 20) the first step has no limit and the result is wrong without a warning.
FIRST_STEP = 0.05


def rates(y, p):
    return y[1], -p[0] * sin(y[0])


def coordinates(y, p):
    return [sin(y[0]), -cos(y[0])]


def velocities(y, p):
    return [cos(y[0]) * y[1], sin(y[0]) * y[1]]


def scene(q, p):
    x, y = q
    return dict(bodies=[(1, x, y, 0, 0)], constraints=[(x**2 + y**2 - 1) / 2], potential=p[0] * y)


# x, y at the end: sin, -cos of 2 asin(sqrt(1/2) sn(K - sqrt(g) t)) (references.py)
EXACT = [0.181513351427031385, -0.983388480334057505]
EXACT_DESIGNS = None
