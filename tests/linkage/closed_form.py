"""Compares trajectories with closed forms, or with the pendulum that a mechanism amounts to.

    closed_form.py SCENE.toml TRAJECTORY.csv

Differences are relative to the largest value. Exit code 1 if one exceeds its tolerance.
"""

import sys
import tomllib

import numpy as np
from free_body import read_columns
from scipy.integrate import solve_ivp

G = 9.81


def engine(c, scene):
    """Slider-crank: the piston by the law of cosines, its forces by its own equation of motion, then the rod's."""
    r, l, w, m, mr, jr, d = 0.04, 0.14, 100 * np.pi, 0.45, 0.6, 0.0018, 0.042
    a = w * c["t"]
    root = np.sqrt(l**2 - (r * np.sin(a)) ** 2)
    x = r * np.cos(a) + root
    acceleration = -r * w**2 * np.cos(a) - w**2 * r**2 * (np.cos(2 * a) / root + r**2 * np.sin(2 * a) ** 2 / (4 * root**3))
    bar = scene["tables"]["bar"]
    gas = -1e5 * np.interp(np.degrees(a), bar["x"], bar["y"]) * np.pi * 0.08**2 / 4
    along = m * (acceleration + G) - gas  # what the rod does to the piston
    # The rod leans by b; moments about its big end give the side force.
    b = np.arcsin(r * np.sin(a) / l)
    b1 = r * w * np.cos(a) / root
    b2 = (b1**2 - w**2) * np.tan(b)
    bigx, bigy = r * w**2 * np.sin(a), -r * w**2 * np.cos(a)
    rod = np.array([np.sin(b), np.cos(b)])  # from the big end to the small end
    turn = np.array([np.cos(b), -np.sin(b)])
    comx = bigx + d * (turn[0] * b2 - rod[0] * b1**2)
    comy = bigy + d * (turn[1] * b2 - rod[1] * b1**2)
    # Clockwise about the big end: jr b2 + mr (com x a) = (what the piston does to the rod) x arm + weight.
    inertia = jr * b2 + mr * d * (comx * rod[1] - (comy + G) * rod[0])
    side = (inertia - along * l * rod[0]) / (l * rod[1])
    yield "piston", c["y"], x
    yield "piston pin, y", c["F_piston_pin_y"], along
    yield "side force", c["F_side_x"], side


def peaucellier(c, scene):
    half = 1.1 * np.sin(np.pi * c["t"]) / 2
    yield "x", c["x"], (0.5**2 - 0.2**2) / 0.4 + 0 * half
    yield "y", c["y"], (0.5**2 - 0.2**2) / 0.4 * np.tan(half)


def planetary(c, scene):
    t = c["t"]
    carrier = 20 * t**2 * 24 / 84
    yield "carrier", c["phi_carrier"], carrier
    yield "planet", c["phi_planet"], carrier * (1 - 60 / 18)
    w, a = 40 * t * 24 / 84, 40 * 24 / 84
    # Power: the torque of the drive by that of the brake and of the inertia.
    ratio = 24 / 84
    inertia = 1.2e-4 + ratio**2 * (6e-4 + 0.9 * 0.021**2 + 0.2 * 0.042**2) + 3.5e-5 * (ratio * (1 - 60 / 18)) ** 2
    weight = G * ratio * np.cos(carrier) * (0.9 * 0.021 + 0.2 * 0.042)
    torque = inertia * 40 + ratio * (5 + 0.1 * w) + weight
    yield "torque of the drive", -c["lambda_S_drive"], torque
    # The teeth of sun and ring push the planet across the line of the axes; the sun and the planet turn by them.
    of_sun = (torque - 1.2e-4 * 40) / 0.024
    of_ring = of_sun + 3.5e-5 * a * (1 - 60 / 18) / 0.018
    teeth = of_sun + of_ring
    along, across = -0.2 * 0.042 * w**2, 0.2 * 0.042 * a - teeth
    yield "planet pin, x", c["F_P_x"], along * np.cos(carrier) - across * np.sin(carrier)
    yield "planet pin, y", c["F_P_y"], along * np.sin(carrier) + across * np.cos(carrier) + 0.2 * G


def scissor_lift(c, scene):
    t = c["t"]
    x, v = 1.6 - 0.3 * (1 - np.cos(np.pi * t / 4)), -0.075 * np.pi * np.sin(np.pi * t / 4)
    a = -0.075 * np.pi**2 / 4 * np.cos(np.pi * t / 4)
    h = np.sqrt(4 - x**2)  # of one stage
    h1 = -x * v / h
    h2 = -(v**2 + x * a + h1**2) / h
    yield "height", c["h"], 2 * h
    # Work of the screw on the pin D: four arms of 40 kg, whose middles are at h/2 and 3h/2 and at x/2.
    angle1 = h1 / x
    angle2 = (h2 * x - h1 * v) / x**2
    power = 450 * (2 * h2 + G) * 2 * h1 + 4 * 40 * 4 / 12 * angle1 * angle2
    power = power + 2 * 40 * ((h2 / 2 + G) * h1 / 2 + (3 * h2 / 2 + G) * 3 * h1 / 2) + 4 * 40 * (a / 2) * (v / 2)
    inside = np.abs(v) > 0.05
    yield "force of the screw", c["F_D_x"][inside], (power / np.where(inside, v, 1))[inside]


def belt(c, scene):
    """phi_small = 2 phi_large + 90 degrees: a pendulum of one angle."""
    inertia = 0.4**2 / 3 * 4 + 2 * 0.6**2 / 3

    def slope(t, s):
        torque = -G * (2 * 0.2 * np.cos(2 * s[0] + np.pi / 2) + 2 * 0.3 * np.cos(s[0]))
        return [s[1], torque / inertia]

    start = [c["phi_large"][0], 0.0]
    run = solve_ivp(slope, (0, c["t"][-1]), start, "DOP853", c["t"], rtol=1e-13, atol=1e-13)
    yield "angle", c["phi_large"], run.y[0]
    yield "other angle", c["phi_small"], 2 * run.y[0] + np.pi / 2


KNOWN = {"engine": engine, "peaucellier": peaucellier, "planetary": planetary, "scissor-lift": scissor_lift, "belt": belt}
LIMITS = {"belt": 1e-8}


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    with open(sys.argv[1], "rb") as file:
        scene = tomllib.load(file)
    name = scene["name"]
    if name not in KNOWN:
        sys.exit(f"no closed form of `{name}`; known: {', '.join(KNOWN)}")
    bad = 0
    print(f"{name:24}{'difference':>12}{'scale':>12}{'relative':>12}")
    for what, have, want in KNOWN[name](read_columns(sys.argv[2]), scene):
        difference, scale = np.max(np.abs(have - want)), np.max(np.abs(want))
        wrong = not difference <= LIMITS.get(name, 1e-12) * scale
        bad += wrong
        print(f"  {what:22}{difference:12.2e}{scale:12.3g}{difference / scale:12.1e}{'  MISSED' if wrong else ''}")
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
