"""Exudyn: a model of bodies and joints, without equations; planar rigid bodies, revolute joints, and what else a
problem needs. Its module without range checks (exudynFast), as its documentation advises for speed.

Generalized-alpha (index 3, spectral radius 0.95 as in its own test of the coupled four-bars) and the trapezoidal rule
of index 2, with constant steps: these are its methods for joints, of order 2. Its explicit Runge-Kutta methods take no
joints; they run where a kinematic tree needs none: the double pendulum. The column `tolerance` holds the step in seconds.
"""
import sys
sys.exudynFast = True
import exudyn as exu
import exudyn.itemInterface as item
import numpy as np
import sympy as sy
from common import Case
from descriptor import consistent

NAME, VERSION = 'Exudyn', exu.__version__
SOLVERS = {'generalized alpha': exu.DynamicSolverType.GeneralizedAlpha,
           'trapezoidal index 2': exu.DynamicSolverType.TrapezoidalIndex2}
TREE = {'RK67': exu.DynamicSolverType.RK67, 'DOPRI5': exu.DynamicSolverType.DOPRI5}


class Model:
    """Bodies at the start of a problem. Body -1 is the ground; joints are given by their place at the start."""

    def __init__(self, problem, bodies):
        self.container = exu.SystemContainer()
        self.mbs = self.container.AddSystem()
        self.ground = self.mbs.AddObject(item.ObjectGround())
        self.nodes, self.bodies, self.frames = [], [], []
        p = problem.PARAMETERS
        q, v, _, _ = consistent(problem, problem.START, p)
        names = sy.symbols(f'q0:{len(q)}')
        for mass, x, y, angle, inertia in bodies(names, p):
            place = sy.Matrix([x, y, angle])
            at = dict(zip(names, q))
            frame = [float(e) for e in place.subs(at)]
            rate = [float(e) for e in place.jacobian(names).subs(at) * sy.Matrix(v)]
            node = self.mbs.AddNode(item.NodeRigidBody2D(referenceCoordinates=frame, initialVelocities=rate))
            self.nodes.append(node)
            self.frames.append(frame)
            body = item.ObjectRigidBody2D(nodeNumber=node, physicsMass=mass, physicsInertia=inertia)
            self.bodies.append(self.mbs.AddObject(body))

    def marker(self, body, x, y, rigid=False):
        local = [x, y, 0]
        if body >= 0:
            fx, fy, angle = self.frames[body]
            c, s = np.cos(angle), np.sin(angle)
            local = [c * (x - fx) + s * (y - fy), -s * (x - fx) + c * (y - fy), 0]
        kind = item.MarkerBodyRigid if rigid else item.MarkerBodyPosition
        return self.mbs.AddMarker(kind(bodyNumber=self.bodies[body] if body >= 0 else self.ground, localPosition=local))

    def revolute(self, a, b, x, y):
        self.mbs.AddObject(item.ObjectJointRevolute2D(markerNumbers=[self.marker(a, x, y), self.marker(b, x, y)]))

    def slot(self, body, x, y, rail, direction):
        """A pin at (x, y) of a body slides along a rail in the given direction of the rail's frame."""
        normal = [-direction[1], direction[0], 0]
        self.mbs.AddObject(item.ObjectJointPrismatic2D(
            markerNumbers=[self.marker(body, x, y, True), self.marker(rail, x, y, True)],
            normalMarker1=normal, constrainRotation=False))

    def force(self, body, x, y, vector):
        self.mbs.AddLoad(item.LoadForceVector(markerNumber=self.marker(body, x, y), loadVector=[*vector, 0]))

    def weight(self, body, vector):
        marker = self.mbs.AddMarker(item.MarkerBodyMass(bodyNumber=self.bodies[body]))
        self.mbs.AddLoad(item.LoadMassProportional(markerNumber=marker, loadVector=[*vector, 0]))

    def spring(self, a, first, b, second, **constants):
        markers = [self.marker(a, *first), self.marker(b, *second)]
        self.mbs.AddObject(item.ObjectConnectorSpringDamper(markerNumbers=markers, **constants))

    def angle(self, body):
        return float(self.mbs.GetNodeOutput(self.nodes[body], exu.OutputVariableType.Coordinates)[2]) + self.frames[body][2]

    def place(self, body):
        d = self.mbs.GetNodeOutput(self.nodes[body], exu.OutputVariableType.Coordinates)
        return [float(d[k]) + self.frames[body][k] for k in (0, 1)]


def bodies_of(problem):
    return lambda q, p: problem.scene(q, p)['bodies']


def quick_return(m):
    def bodies(q, p):  # the mass of the block turns with the crank; the ram has a place of its own
        s = m.scene(q, p)['bodies']
        return [(1.0, 0.0, m.O4O2, q[0], p[1] + m.M3 * p[0]**2), s[2], s[3], (m.M6, s[4][1], m.YC, 0, 1.0)]
    x = Model(m, bodies)
    q = m.coordinates(m.START, m.PARAMETERS)
    a, b = (m.PARAMETERS[0], m.O4O2), (m.O4B * np.cos(q[1]), m.O4B * np.sin(q[1]))
    x.revolute(-1, 0, 0, m.O4O2)
    x.revolute(-1, 1, 0, 0)
    x.slot(0, *a, 1, (1, 0))
    x.revolute(1, 2, *b)
    c = (b[0] + m.BC * np.cos(q[2]), m.YC)
    x.revolute(2, 3, *c)
    for coordinate in 1, 2:  # the ram moves along x alone
        pair = [x.mbs.AddMarker(item.MarkerNodeCoordinate(nodeNumber=x.nodes[3], coordinate=coordinate)),
                x.mbs.AddMarker(item.MarkerNodeCoordinate(nodeNumber=x.mbs.AddNode(item.NodePointGround()), coordinate=0))]
        x.mbs.AddObject(item.ObjectConnectorCoordinate(markerNumbers=pair[::-1]))
    x.force(3, *c, (m.F6, 0))
    return x, lambda: [x.angle(0), x.angle(1), x.angle(2)]


def slider_crank(m):
    # the mass of the slider is that of the rod, at the end where they meet: the rod of the scene has inertia alone
    x = Model(m, lambda q, p: [(1.0, 0.0, 0.0, q[0], m.J1), (m.M2, q[1], 0.0, q[2], m.J2)])
    q, s, p = m.coordinates(m.START, m.PARAMETERS)
    a = (m.A * np.cos(q), m.A * np.sin(q))
    x.revolute(-1, 0, 0, 0)
    x.revolute(0, 1, *a)
    x.slot(1, s, 0, -1, (1, 0))
    x.spring(0, (a[0] / 2, a[1] / 2), 1, (s - np.cos(p) / 2, -np.sin(p) / 2), stiffness=m.K, damping=m.C,
             referenceLength=m.L0)
    x.force(1, s + np.cos(p), np.sin(p), (m.PARAMETERS[0], 0))
    return x, lambda: [x.angle(0), x.place(1)[0], x.angle(1)]


def andrews(m):
    x = Model(m, bodies_of(m))
    q = m.coordinates(m.START, m.PARAMETERS)
    r = (m.RR * np.cos(q[0]), m.RR * np.sin(q[0]))
    p = (r[0] - m.D * np.cos(q[0] + q[1]), r[1] - m.D * np.sin(q[0] + q[1]))
    e = (m.XA + m.ZT * np.cos(q[4]), m.YA + m.ZT * np.sin(q[4]))
    f = (m.XA + m.U * np.sin(q[6]), m.YA - m.U * np.cos(q[6]))
    d = (m.XB + m.SD * np.cos(q[2]) + m.SC * np.sin(q[2]), m.YB + m.SD * np.sin(q[2]) - m.SC * np.cos(q[2]))
    for a, b, at in [(-1, 0, (0, 0)), (0, 1, r), (1, 2, p), (-1, 2, (m.XB, m.YB)), (1, 3, p), (3, 4, e),
                     (-1, 4, (m.XA, m.YA)), (1, 5, p), (5, 6, f), (-1, 6, (m.XA, m.YA))]:
        x.revolute(a, b, *at)
    x.spring(2, d, -1, (m.XC, m.YC), stiffness=m.C0, referenceLength=m.L0)
    x.mbs.AddLoad(item.LoadTorqueVector(markerNumber=x.marker(0, 0, 0, True), loadVector=[0, 0, m.PARAMETERS[0]]))

    def end():
        a = [x.angle(i) for i in range(7)]
        return [a[0], a[1] - a[0], a[2], a[3] - a[4], a[4], a[5] - a[6], a[6]]
    return x, end


def n_four_bar(m):
    x = Model(m, bodies_of(m))
    for i in range(3):
        x.revolute(-1, i, i * m.L, 0)
    for i in range(2):
        x.revolute(i, 3 + i, i * m.L, m.L)
        x.revolute(i + 1, 3 + i, (i + 1) * m.L, m.L)
    for i in range(5):
        x.weight(i, (0, -m.G))
    return x, lambda: [x.angle(i) for i in range(5)]


def points(m):
    """Point masses on rods: distance constraints."""
    x = Model(m, lambda q, p: [])
    q, v, _, _ = consistent(m, m.START, m.PARAMETERS)
    symbols = sy.symbols(f'q0:{len(q)}')
    last, nodes = x.marker(-1, 0, 0), []
    for mass, px, py, _, _ in m.scene(symbols, m.PARAMETERS)['bodies']:
        place = sy.Matrix([px, py])
        at = dict(zip(symbols, q))
        position = [float(e) for e in place.subs(at)]
        rate = [float(e) for e in place.jacobian(symbols).subs(at) * sy.Matrix(v)]
        node = x.mbs.AddNode(item.NodePoint2D(referenceCoordinates=position, initialVelocities=rate))
        body = x.mbs.AddObject(item.ObjectMassPoint2D(nodeNumber=node, physicsMass=mass))
        marker = x.mbs.AddMarker(item.MarkerNodePosition(nodeNumber=node))
        x.mbs.AddObject(item.ObjectConnectorDistance(markerNumbers=[last, marker], distance=1.0))
        x.mbs.AddLoad(item.LoadMassProportional(markerNumber=x.mbs.AddMarker(item.MarkerBodyMass(bodyNumber=body)),
                                                loadVector=[0, -m.PARAMETERS[0], 0]))
        last = marker
        nodes.append((node, position))
    return x, lambda: [x.mbs.GetNodeOutput(n, exu.OutputVariableType.Position)[:2] for n, _ in nodes]


def pendulum(m):
    x, places = points(m)
    return x, lambda: list(places()[0])


def double_pendulum(m):
    x, places = points(m)

    def end():  # the turns of the rods are those of the exact end
        (ax, ay), (bx, by) = places()
        raw = [np.arctan2(ax, -ay), np.arctan2(bx - ax, ay - by)]
        return [r + 2 * np.pi * round((e - r) / (2 * np.pi)) for r, e in zip(raw, m.EXACT)]
    return x, end


def tree(m):
    """The double pendulum in minimal coordinates: relative angles from the downward vertical."""
    x = Model(m, lambda q, p: [])
    matrix, vector = exu.Matrix3DList(), exu.Vector3DList
    offsets, centres, inertias = vector(), vector(), exu.Matrix3DList()
    for i in range(2):
        matrix.Append(np.eye(3))
        offsets.Append([0, -float(i), 0])
        centres.Append([0, -1.0, 0])
        inertias.Append(np.zeros((3, 3)))
    a, b, v, w = m.START
    node = x.mbs.AddNode(item.NodeGenericODE2(referenceCoordinates=[0, 0], initialCoordinates=[a, b - a],
                                              initialCoordinates_t=[v, w - v], numberOfODE2Coordinates=2))
    x.mbs.AddObject(item.ObjectKinematicTree(
        nodeNumber=node, jointTypes=[exu.JointType.RevoluteZ] * 2, linkParents=np.array([-1, 0]),
        jointTransformations=matrix, jointOffsets=offsets, linkInertiasCOM=inertias, linkCOMs=centres,
        linkMasses=[1.0, 1.0], gravity=[0, -m.PARAMETERS[0], 0]))

    def end():
        a, d = x.mbs.GetNodeOutput(node, exu.OutputVariableType.Coordinates)
        return [a, a + d]
    return x, end


MODELS = {'quick-return': quick_return, 'andrews': andrews, 'slider-crank': slider_crank, 'n-four-bar-2': n_four_bar,
          'pendulum': pendulum, 'double-pendulum': double_pendulum}
# steps of the first row; each further row has three times as many
STEPS = {'quick-return': 100, 'andrews': 300, 'slider-crank': 100, 'n-four-bar-2': 10, 'pendulum': 3000,
         'double-pendulum': 300}


def prepare(problem, model, solver, steps, tolerance=None):
    system, end = model(problem)
    system.mbs.Assemble()
    s = exu.SimulationSettings()
    s.solutionSettings.writeSolutionToFile = False
    s.timeIntegration.endTime = problem.END
    s.timeIntegration.numberOfSteps = steps
    s.timeIntegration.generalizedAlpha.spectralRadius = 0.95
    s.timeIntegration.newton.relativeTolerance = 1e-10
    s.timeIntegration.verboseMode = 0
    if tolerance:
        s.timeIntegration.relativeTolerance = s.timeIntegration.absoluteTolerance = tolerance
    else:
        s.timeIntegration.automaticStepSize = False

    def go():
        if not system.mbs.SolveDynamic(s, solverType=solver):
            raise RuntimeError('no success')
    return lambda: None, go, lambda: [end()]


def cases(problem):
    exu.config.suppressWarnings = True
    for name, solver in SOLVERS.items():
        for k in range(6):
            steps = STEPS[problem.NAME] * 3**k
            yield Case('run', name, 'spectral radius 0.95' if 'alpha' in name else '', problem.END / steps,
                       lambda m=MODELS[problem.NAME], s=solver, n=steps: prepare(problem, m, s, n))
    if problem.NAME == 'double-pendulum':
        for k in range(6):
            steps = 100 * 3**k
            yield Case('run', 'RK67 tree', 'minimal coordinates', problem.END / steps,
                       lambda n=steps: prepare(problem, tree, TREE['RK67'], n))
        for tolerance in [10.0**-k for k in range(3, 14)]:
            yield Case('run', 'DOPRI5 tree', 'minimal coordinates', tolerance,
                       lambda t=tolerance: prepare(problem, tree, TREE['DOPRI5'], 20, t))
