"""Quick-return mechanism: a crank drives a slotted rocker, whose rod pushes a ram. Scene: quick-return.

Independent coordinate: the crank angle phi2. The sines of the rocker and of the rod follow in closed form, so no
position drifts. The end time is that of two revolutions, rounded up.
"""
from math import atan2, asin, pi, sin, cos, sqrt
import numpy as np

NAME, END = 'quick-return', 1.756
COORDINATES = ['phi2', 'phi4', 'phi5']
O4B, BC, O4O2, O4G4, BG5, YC = 0.7, 0.6, 0.3, 0.4, 0.3, 0.9
M3, M4, M5, M6, J4, J5, F6 = 0.5, 6.0, 4.0, 2.0, 10.0, 6.0, 1000.0
PARAMETERS = np.array([0.2, 100.0])  # O2A, J2
DESIGNS = np.column_stack([np.linspace(0.196, 0.204, 8), np.linspace(90.0, 110.0, 8)])
START = np.array([0.0, 150 * pi / 60])


def rates(y, p):
    p2, w2 = y
    O2A, J2 = p
    s2, c2 = sin(p2), cos(p2)
    ax, ay = O2A * c2, O4O2 + O2A * s2
    length = sqrt(ax * ax + ay * ay)
    il = 1.0 / length
    s4, c4 = ay * il, ax * il
    s5 = (YC - O4B * s4) * (1.0 / BC)
    c5 = -sqrt(1.0 - s5 * s5)
    i5 = 1.0 / c5
    c24, s24 = c2 * c4 + s2 * s4, s2 * c4 - c2 * s4
    k4 = O2A * c24 * il  # phi4' / phi2'
    k54 = (-O4B / BC) * c4 * i5  # phi5' / phi4'
    k5 = k54 * k4
    w4, w5 = k4 * w2, k5 * w2
    # accelerations for phi2'' = 0
    d4 = -(O2A * s24 * (w2 - w4) * w2 - O2A * s24 * w2 * w4) * il
    d5 = k54 * d4 + (O4B * s4 * w4 * w4 + BC * s5 * w5 * w5) * i5 * (1.0 / BC)
    c45, s45 = c4 * c5 + s4 * s5, s4 * c5 - c4 * s5
    u4, u5 = -O4B * s4, -BC * s5
    m22 = J2 + M3 * O2A * O2A
    m44 = (J4 + M4 * O4G4 * O4G4 + M5 * O4B * O4B) + M6 * u4 * u4
    m45 = M5 * O4B * BG5 * c45 + M6 * u4 * u5
    m55 = (J5 + M5 * BG5 * BG5) + M6 * u5 * u5
    ram = F6 + M6 * (O4B * c4 * w4 * w4 + BC * c5 * w5 * w5)
    f4 = u4 * ram - M5 * O4B * BG5 * s45 * w5 * w5
    f5 = u5 * ram + M5 * O4B * BG5 * s45 * w4 * w4
    h4, h5 = m44 * k4 + m45 * k5, m45 * k4 + m55 * k5
    return w2, (k4 * f4 + k5 * f5 - h4 * d4 - h5 * d5) / (m22 + k4 * h4 + k5 * h5)


def coordinates(y, p):
    p4 = atan2(O4O2 + p[0] * sin(y[0]), p[0] * cos(y[0]))
    return [y[0], p4, pi - asin((YC - O4B * sin(p4)) / BC)]


def scene(q, p):
    """Bodies (mass, x, y, angle, inertia), constraints, potential, other loads as virtual power by rates."""
    import sympy as sy
    p2, p4, p5 = q
    O2A, J2 = p
    ax, ay = O2A * sy.cos(p2), O4O2 + O2A * sy.sin(p2)
    bx, by = O4B * sy.cos(p4), O4B * sy.sin(p4)
    cx, cy = bx + BC * sy.cos(p5), by + BC * sy.sin(p5)
    return dict(
        bodies=[(0, 0, 0, p2, J2), (M3, ax, ay, p4, 0), (M4, O4G4 * sy.cos(p4), O4G4 * sy.sin(p4), p4, J4),
                (M5, bx + BG5 * sy.cos(p5), by + BG5 * sy.sin(p5), p5, J5), (M6, cx, YC, 0, 0)],
        constraints=[ax - sy.sqrt(ax**2 + ay**2) * sy.cos(p4), cy - YC],
        potential=-F6 * cx)


# phi2, phi4, phi5 at the end (references.py)
EXACT = [12.5664155467634835, 0.982807548781690632, 2.58385776518379506]
EXACT_DESIGNS = [
    [12.4439345480389818, 0.956943404285040988, 2.56362102515383761],
    [12.4823127975902928, 0.964742704469393697, 2.56983154629141808],
    [12.5178395112903491, 0.972223759508506369, 2.5757004948789497],
    [12.5508090180090388, 0.979366143572755865, 2.58122399060381058],
    [12.5814752075688112, 0.98616210587727049, 2.58640789447887842],
    [12.6100582140445976, 0.992612159947573347, 2.59126381392054705],
    [12.6367498225385084, 0.998722132066796053, 2.59580653714820242],
    [12.6617178697759876, 1.00450117137898176, 2.60005238828083751]]
