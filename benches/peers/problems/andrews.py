"""Andrews' squeezing mechanism: seven bodies, three loops, a constant torque. Scene: andrews.

Equations and parameters: Test Set for IVP Solvers, problem andrews. Independent coordinate: the angle beta of the
motor. Each loop is closed by the intersection of two circles, so no position drifts.
"""
from math import atan2, sin, cos, sqrt
import numpy as np

NAME, END = 'andrews', 0.03
COORDINATES = ['beta', 'Theta', 'gamma', 'Phi', 'delta', 'Omega', 'eps']
M1, M2, M3, M4, M5, M6, M7 = .04325, .00365, .02373, .00706, .07050, .00706, .05498
I1, I2, I3, I4, I5, I6, I7 = 2.194e-6, 4.410e-7, 5.255e-6, 5.667e-7, 1.169e-5, 5.667e-7, 1.912e-5
XA, YA, XB, YB, XC, YC, C0, L0 = -.06934, -.00227, -.03635, .03273, .014, .072, 4530., .07785
D, DA, E, EA, RR, RA, SS, SA, SB, SC, SD = .028, .0115, .02, .01421, .007, 9.2e-4, .035, .01874, .01043, .018, .02
TA, TB, U, UA, UB, ZF, ZT, FA = .02308, .00916, .04, .01228, .00449, .02, .04, .01421
PARAMETERS = np.array([0.033])  # torque of the motor
DESIGNS = 0.033 * np.linspace(0.99, 1.01, 8)[:, None]
START = np.array([-0.0617138900142764496358948458001, 0.0])


def meet(x1, y1, r1, x2, y2, r2, side):
    """The point at the distances r1 and r2 from two centres, on one side of their line."""
    dx, dy = x2 - x1, y2 - y1
    i = 1.0 / (dx * dx + dy * dy)
    a = 0.5 + 0.5 * (r1 * r1 - r2 * r2) * i
    h = side * sqrt(r1 * r1 * i - a * a)
    return x1 + a * dx - h * dy, y1 + a * dy + h * dx


def solve(a, b, c, d, r, s):
    i = 1.0 / (a * d - b * c)
    return (r * d - b * s) * i, (a * s - c * r) * i


def places(sb, cb):
    """Sine and cosine of beta + Theta, gamma, Phi + delta, delta, Omega + eps, eps."""
    px, py = meet(RR * cb, RR * sb, D, XB, YB, SS, 1.0)
    ex, ey = meet(XA, YA, ZT, px, py, E, 1.0)
    fx, fy = meet(XA, YA, U, px, py, ZF, -1.0)
    return ((RR * sb - py) * (1 / D), (RR * cb - px) * (1 / D), (px - XB) * (1 / SS), (YB - py) * (1 / SS),
            (px - ex) * (1 / E), (ey - py) * (1 / E), (ey - YA) * (1 / ZT), (ex - XA) * (1 / ZT),
            (py - fy) * (1 / ZF), (px - fx) * (1 / ZF), (fx - XA) * (1 / U), (YA - fy) * (1 / U))


def rates(y, p):
    beta, w0 = y
    mom, = p
    sb, cb = sin(beta), cos(beta)
    sbt, cbt, sg, cg, spd, cpd, sd, cd, soe, coe, se, ce = places(sb, cb)
    s1, c1 = sbt * cb - cbt * sb, cbt * cb + sbt * sb
    s3, c3 = spd * cd - cpd * sd, cpd * cd + spd * sd
    s5, c5 = soe * ce - coe * se, coe * ce + soe * se
    # velocities for beta' = 1, loop after loop
    g1, g2 = -RR * sb + D * sbt, RR * cb - D * cbt
    k1, k2 = solve(D * sbt, -SS * cg, -D * cbt, -SS * sg, -g1, -g2)
    v1, v2 = g1 + D * sbt * k1, g2 - D * cbt * k1  # of P
    k3, k4 = solve(-E * cpd, -E * cpd + ZT * sd, -E * spd, -E * spd - ZT * cd, -v1, -v2)
    k5, k6 = solve(ZF * soe, ZF * soe - U * ce, -ZF * coe, -ZF * coe - U * se, -v1, -v2)
    w1, w2, w3, w4, w5, w6 = k1 * w0, k2 * w0, k3 * w0, k4 * w0, k5 * w0, k6 * w0
    # accelerations for beta'' = 0
    be2, ga2, de2, ep2 = w0 * w0, w2 * w2, w4 * w4, w6 * w6
    bt, pd, oe = w0 + w1, w3 + w4, w5 + w6
    bt2, pd2, oe2 = bt * bt, pd * pd, oe * oe
    hx, hy = -RR * cb * be2 + D * cbt * bt2, -RR * sb * be2 + D * sbt * bt2
    d1, d2 = solve(D * sbt, -SS * cg, -D * cbt, -SS * sg, -hx - SS * sg * ga2, -hy + SS * cg * ga2)
    e1, e2 = hx + D * sbt * d1, hy - D * cbt * d1
    d3, d4 = solve(-E * cpd, -E * cpd + ZT * sd, -E * spd, -E * spd - ZT * cd,
                   -e1 - E * spd * pd2 - ZT * cd * de2, -e2 + E * cpd * pd2 - ZT * sd * de2)
    d5, d6 = solve(ZF * soe, ZF * soe - U * ce, -ZF * coe, -ZF * coe - U * se,
                   -e1 - ZF * coe * oe2 - U * se * ep2, -e2 - ZF * soe * oe2 + U * ce * ep2)
    # mass matrix
    b0 = M2 * DA * RR
    m00 = (M1 * RA * RA + M2 * (RR * RR + DA * DA) + I1 + I2) - 2 * b0 * c1
    m01, m11 = (M2 * DA * DA + I2) - b0 * c1, M2 * DA * DA + I2
    m22 = M3 * (SA * SA + SB * SB) + I3
    b3 = M4 * ZT * (E - EA)
    m33 = M4 * (E - EA) * (E - EA) + I4
    m34 = m33 + b3 * s3
    m44 = (M4 * (ZT * ZT + (E - EA) * (E - EA)) + M5 * (TA * TA + TB * TB) + I4 + I5) + 2 * b3 * s3
    b5 = M6 * U * (ZF - FA)
    m55 = M6 * (ZF - FA) * (ZF - FA) + I6
    m56 = m55 - b5 * s5
    m66 = (M6 * ((ZF - FA) * (ZF - FA) + U * U) + M7 * (UA * UA + UB * UB) + I6 + I7) - 2 * b5 * s5
    # forces
    dx, dy = SD * cg + SC * sg + (XB - XC), SD * sg - SC * cg + (YB - YC)
    force = C0 * L0 / sqrt(dx * dx + dy * dy) - C0
    f0 = mom - b0 * w1 * (w1 + 2.0 * w0) * s1
    f1 = b0 * be2 * s1
    f2 = force * (dx * (SC * cg - SD * sg) + dy * (SD * cg + SC * sg))
    f3 = b3 * de2 * c3
    f4 = -b3 * w3 * (w3 + 2.0 * w4) * c3
    f5 = -b5 * ep2 * c5
    f6 = b5 * w5 * (w5 + 2.0 * w6) * c5
    h1, h2, h3, h4 = m01 + m11 * k1, m22 * k2, m33 * k3 + m34 * k4, m34 * k3 + m44 * k4
    h5, h6 = m55 * k5 + m56 * k6, m56 * k5 + m66 * k6
    mass = m00 + m01 * k1 + h1 * k1 + h2 * k2 + h3 * k3 + h4 * k4 + h5 * k5 + h6 * k6
    load = f0 + f1 * k1 + f2 * k2 + f3 * k3 + f4 * k4 + f5 * k5 + f6 * k6
    return w0, (load - h1 * d1 - h2 * d2 - h3 * d3 - h4 * d4 - h5 * d5 - h6 * d6) / mass


def coordinates(y, p):
    s = places(sin(y[0]), cos(y[0]))
    bt, gamma, pd, delta, oe, eps = [atan2(s[i], s[i + 1]) for i in range(0, 12, 2)]
    return [y[0], bt - y[0], gamma, pd - delta, delta, oe - eps, eps]


def scene(q, p):
    from sympy import sin, cos, sqrt
    be, th, ga, ph, de, om, ep = q
    px, py = RR * cos(be) - D * cos(be + th), RR * sin(be) - D * sin(be + th)
    ex, ey = XA + ZT * cos(de), YA + ZT * sin(de)
    fx, fy = XA + U * sin(ep), YA - U * cos(ep)
    length = sqrt((XB + SD * cos(ga) + SC * sin(ga) - XC)**2 + (YB + SD * sin(ga) - SC * cos(ga) - YC)**2)
    return dict(
        bodies=[(M1, RA * cos(be), RA * sin(be), be, I1),
                (M2, RR * cos(be) - DA * cos(be + th), RR * sin(be) - DA * sin(be + th), be + th, I2),
                (M3, XB + SA * sin(ga) + SB * cos(ga), YB - SA * cos(ga) + SB * sin(ga), ga, I3),
                (M4, ex + (E - EA) * sin(ph + de), ey - (E - EA) * cos(ph + de), ph + de, I4),
                (M5, XA + TA * cos(de) - TB * sin(de), YA + TA * sin(de) + TB * cos(de), de, I5),
                (M6, fx + (ZF - FA) * cos(om + ep), fy + (ZF - FA) * sin(om + ep), om + ep, I6),
                (M7, XA + UA * sin(ep) - UB * cos(ep), YA - UA * cos(ep) - UB * sin(ep), ep, I7)],
        constraints=[px - SS * sin(ga) - XB, py + SS * cos(ga) - YB, px - E * sin(ph + de) - ex,
                     py + E * cos(ph + de) - ey, px - ZF * cos(om + ep) - fx, py - ZF * sin(om + ep) - fy],
        potential=C0 * (length - L0)**2 / 2 - p[0] * be)


# at the end (references.py)
EXACT = [15.8107711951537091, -15.7563710584118422, 0.0408222401196458445, -0.534730116342079564,
         0.524409965879954032, 0.534730116342079564, 1.04808074104193794]
EXACT_DESIGNS = [
    [15.7289589657400217, -15.654109870542646, 0.0408667919615890718, -0.534652208147922359,
     0.524412281143871617, 0.534652208147922359, 1.04808204878022604],
    [15.7523766356377681, -15.6833844824095454, 0.0406830842381381563, -0.534973460743043527,
     0.524402723162547768, 0.534973460743043527, 1.04807669132436931],
    [15.775764899607756, -15.7126208774408003, 0.0406364788550782619, -0.535054960858444506,
     0.524400293713677246, 0.535054960858444506, 1.04807534685255521],
    [15.7991141594312072, -15.741804050183374, 0.0407263793291381127, -0.534897749624975272,
     0.524404978364067076, 0.534897749624975272, 1.04807794562408207],
    [15.8224149401329139, -15.7709192587885383, 0.0409518509657607679, -0.53450346528435555,
     0.524416696699804175, 0.53450346528435555, 1.0480845606007152],
    [15.8456579581709835, -15.7999521207555365, 0.0413116313350050252, -0.533874324629522445,
     0.524435304171097849, 0.533874324629522445, 1.04809540366588161],
    [15.8688341853642125, -15.8288887018940532, 0.0418041441647023296, -0.533013098265081364,
     0.524460594773117683, 0.533013098265081364, 1.0481108198851592],
    [15.8919349072660463, -15.8577155967786023, 0.0424275162793217656, -0.531923080357381117,
     0.524492304482067628, 0.531923080357381117, 1.04813127998771671]]
