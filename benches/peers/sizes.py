"""Cost against the size of a mechanism, and against error, beside programs for multibody systems: sizes.py QRM [OUT.csv]

Two mechanisms of `codegen/examples/make.rs`: chains of uniform links in relative angles, and coupled four-bars. qrm is
the command; its C is compiled by cc and stepped by its `rk4_step`. All programs run in turn in one process, on one core.

| column | meaning |
|---|---|
| `what` | `evaluation`: accelerations at one state; `step`: one step of the method, projection included |
| `step` | the step in seconds; empty for an evaluation |
| `microseconds` | processor time of one evaluation or step, median of seven repetitions |
| `spread` | third quartile minus first, over the median; of all steps together |
| `error` | largest error of an angle against the ground at the end, in rad, against an independent reference |

References: the accelerations of Pinocchio, integrated by DOP853 of SciPy to 1e-12 (chain); the cranks of equal
four-bars stay parallel and move like one pendulum, integrated likewise.
"""
import csv, ctypes, math, os, re, subprocess, sys, tempfile, time
sys.exudynFast = True
import exudyn as exu
import exudyn.itemInterface as item
import mujoco
import numpy as np
import pinocchio as pin
from scipy.integrate import solve_ivp

LENGTH, MASS, GRAVITY = 0.2, 0.5, 9.81          # a link of a chain
ROD = 1.0                                        # a rod of the four-bars: its length and mass, inertia 1/12
CHAINS = [5, 14, 28, 50, 100, 200]
FOUR_BARS = [1, 2, 5, 10, 20, 40]
END = dict(chain=0.2, four_bars=0.5)             # s
STEPS = dict(chain=[2e-3, 1e-3, 5e-4, 2.5e-4], four_bars=[1e-2, 5e-3, 2.5e-3, 1.25e-3])
FOR_ERRORS = dict(chain=28, four_bars=10)        # the sizes whose errors are measured
RUN = '''
#include "NAME.h"
#include <stddef.h>
static struct NAME_state start;
void *begin(void) {
    static struct NAME m;
    struct NAME_parameters p;
    NAME_default_parameters(&p);
    NAME_new(&p, &m);
    return NAME_initial_state(&m, &start) ? &m : NULL;
}
void run(const void *m, double h, int steps, double *q) {
    static struct NAME_step step;
    struct NAME_state state = start;
    for (int i = 0; i < steps; i++) {
        NAME_rk4_step(m, i * h, h, &state, &step);
        state = step.end;
    }
    for (size_t i = 0; i < sizeof state.q / sizeof *state.q; i++) q[i] = state.q[i];
}
double evaluate(const void *m, int times) {
    static struct NAME_position position;
    struct NAME_state state = start;
    double sum = 0;
    for (int i = 0; i < times; i++) {
        state.q[0] += 1e-9;
        NAME_angles(state.q, &state.angles);
        NAME_position(m, TIMEstate.q, &state.angles, &position);
        NAME_accelerations(m, &position, 0, state.q, state.qd, &state.angles, state.qdd, state.multipliers);
        sum += state.qdd[0];
    }
    return sum;
}
'''


def measured(work, times):
    """Median and spread of microseconds for each of the times that `work` does something."""
    work()
    found = []
    for _ in range(7):
        begun = time.process_time()
        work()
        found.append(1e6 * (time.process_time() - begun) / times)
    quarters = np.percentile(found, [25, 50, 75])
    return quarters[1], (quarters[2] - quarters[0]) / quarters[1]


def often(microseconds):
    """How often something is done in a repetition, by what it takes about."""
    return max(3, min(100_000, int(5e4 / microseconds)))


class Qrm:
    """Generated C."""
    name, version, method = 'qrm', '', 'RK4'

    def __init__(self, kind, size, command, folder):
        scene = {'chain': 'relative', 'four_bars': 'four-bars'}[kind]
        made = subprocess.run([*MAKE, scene, str(size)], check=True, capture_output=True, text=True).stdout
        path = os.path.join(folder, f'{kind}-{size}.toml')
        with open(path, 'w') as file:
            file.write(made)
        subprocess.run([command, 'code', path, '--language', 'c', '--out', folder], check=True, capture_output=True)
        name = re.search(r'name = "([^"]*)"', made)[1].replace('-', '_')
        with open(os.path.join(folder, f'{name}.h')) as file:
            is_timed = 'double t,' in re.search(rf'void {name}_position\((.*?)\);', file.read(), re.S)[1]
        text = RUN.replace('NAME', name).replace('TIME', '0, ' if is_timed else '')
        run, library = os.path.join(folder, f'{name}_run.c'), os.path.join(folder, f'{name}.so')
        with open(run, 'w') as file:
            file.write(text)
        subprocess.run(['cc', '-O3', '-march=native', '-shared', '-fPIC', '-o', library, run,
                        os.path.join(folder, f'{name}.c'), '-lm'], check=True)
        self.library = ctypes.CDLL(library)
        self.library.begin.restype = ctypes.c_void_p
        self.library.evaluate.restype = ctypes.c_double
        self.mechanism = ctypes.c_void_p(self.library.begin())
        if not self.mechanism:
            raise RuntimeError('the loops of the start cannot be closed')
        self.kind, self.size = kind, size
        self.q = np.zeros({'chain': size, 'four_bars': 2 * size + 1}[kind])

    def evaluations(self, times):
        self.library.evaluate(self.mechanism, times)

    def steps(self, h, steps):
        place = self.q.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
        self.library.run(self.mechanism, ctypes.c_double(h), steps, place)

    def angles(self):
        return np.cumsum(self.q) if self.kind == 'chain' else self.q


class Pinocchio:
    """The articulated-body algorithm; with loops, its proximal constraint dynamics. It has no integrator of its own."""
    name, version, method = 'Pinocchio', pin.__version__, 'evaluation'

    def __init__(self, kind, size, *_):
        self.model = model = pin.Model()
        model.gravity.linear = np.array([0, -GRAVITY, 0])
        self.loops = pin.StdVec_RigidConstraintModel()

        def link(parent, place, length, mass):
            joint = model.addJoint(parent, pin.JointModelRZ(), pin.SE3(np.eye(3), np.array(place)), f'j{model.njoints}')
            about = np.eye(3) * mass * length**2 / 12
            model.appendBodyToJoint(joint, pin.Inertia(mass, np.array([length / 2, 0, 0]), about), pin.SE3.Identity())
            return joint
        if kind == 'chain':
            joint = 0
            for i in range(size):
                joint = link(joint, [LENGTH if i else 0.0, 0, 0], LENGTH, MASS)
            self.q, self.v = np.zeros(size), np.zeros(size)
            self.q[0] = 1 - math.pi / 2  # the angle of the scene is zero downward
        else:
            cranks = [link(0, [i * ROD, 0, 0], ROD, ROD) for i in range(size + 1)]
            tip = pin.SE3(np.eye(3), np.array([ROD, 0, 0]))
            self.q = np.r_[np.full(size + 1, math.pi / 2), np.full(size, -math.pi / 2)]
            self.v = np.r_[np.full(size + 1, -1.0), np.full(size, 1.0)]
            for i in range(size):
                coupler = link(cranks[i], [ROD, 0, 0], ROD, ROD)
                self.loops.append(pin.RigidConstraintModel(
                    pin.ContactType.CONTACT_3D, model, coupler, tip, cranks[i + 1], tip, pin.ReferenceFrame.LOCAL))
        self.data = model.createData()
        self.parts = pin.StdVec_RigidConstraintData()
        for loop in self.loops:
            self.parts.append(loop.createData())
        self.zero = np.zeros(model.nv)
        self.has_loops = len(self.loops) > 0
        if self.has_loops:
            pin.initConstraintDynamics(model, self.data, self.loops, self.parts)
            # Each loop has a redundant equation out of its plane.
            self.settings = pin.ProximalSettings(1e-12, 1e-10, 10)

    def accelerations(self, q, v):
        if not self.has_loops:
            return pin.aba(self.model, self.data, q, v, self.zero)
        return pin.constraintDynamics(self.model, self.data, q, v, self.zero, self.loops, self.parts, self.settings)

    def evaluations(self, times):
        for _ in range(times):
            self.accelerations(self.q, self.v)


class MuJoCo:
    """Hinges; loops are its soft equality constraints, as stiff as it recommends."""
    name, version = 'MuJoCo', mujoco.__version__

    def __init__(self, kind, size, *_):
        self.method = 'RK4' if kind == 'chain' else 'implicitfast'

        def body(name, place, length, mass, inside, angle=0.0):
            half, inertia = length / 2, mass * length**2 / 12
            return (f'<body name="{name}" pos="{place} 0 0"><joint axis="0 0 1" ref="{angle}"/>'
                    f'<inertial pos="{half} 0 0" mass="{mass}" diaginertia="{inertia} {inertia} {inertia}"/>{inside}</body>')
        equality = ''
        if kind == 'chain':
            bodies = ''
            for i in reversed(range(size)):
                bodies = body(f'b{i}', LENGTH if i else 0, LENGTH, MASS, bodies)
        else:
            bodies = ''.join(body(f'b{i}', i * ROD, ROD, ROD, body(f'c{i}', ROD, ROD, ROD, '') if i < size else '')
                             for i in range(size + 1))
            site = '<connect body1="c{0}" body2="b{1}" anchor="{2} 0 0"/>'
            equality = ''.join(site.format(i, i + 1, ROD) for i in range(size))
        text = (f'<mujoco><compiler angle="radian"/><option gravity="0 {-GRAVITY} 0" integrator="{self.method}" '
                f'timestep="1e-3"><flag contact="disable"/></option><worldbody>{bodies}</worldbody>'
                f'<equality>{equality}</equality></mujoco>')
        self.model = mujoco.MjModel.from_xml_string(text)
        self.data = mujoco.MjData(self.model)
        self.kind, self.size = kind, size
        if kind == 'chain':
            self.q, self.v = np.zeros(size), np.zeros(size)
            self.q[0] = 1 - math.pi / 2
        else:  # bodies in depth-first order: crank 0, coupler 0, crank 1, ...
            order = [math.pi / 2 if i % 2 == 0 else -math.pi / 2 for i in range(2 * size + 1)]
            self.q, self.v = np.array(order), -np.sign(order)
            # The anchor of a loop is given in the position in which the model is written: the tip of the next crank.
            self.model.eq_data[:, :6] = [ROD, 0, 0, ROD, 0, 0]

    def evaluations(self, times):
        for _ in range(times):
            mujoco.mj_forward(self.model, self.data)

    def steps(self, h, steps):
        mujoco.mj_resetData(self.model, self.data)
        self.model.opt.timestep = h
        self.data.qpos[:], self.data.qvel[:] = self.q, self.v
        mujoco.mj_step(self.model, self.data, steps)

    def angles(self):
        if self.kind == 'chain':
            return np.cumsum(self.data.qpos) + math.pi / 2
        return self.data.qpos[::2]


class Exudyn:
    """A kinematic tree with explicit steps; loops by revolute joints and generalized alpha."""
    name, version = 'Exudyn', exu.__version__

    def __init__(self, kind, size, *_):
        self.kind, self.size = kind, size
        self.method = 'RK44 tree' if kind == 'chain' else 'generalized alpha'

    def model(self):
        container = exu.SystemContainer()
        mbs = container.AddSystem()
        size = self.size
        if self.kind == 'chain':
            turns, offsets, centres, inertias = exu.Matrix3DList(), exu.Vector3DList(), exu.Vector3DList(), exu.Matrix3DList()
            for i in range(size):
                turns.Append(np.eye(3))
                offsets.Append([LENGTH if i else 0.0, 0, 0])
                centres.Append([LENGTH / 2, 0, 0])
                inertias.Append(np.eye(3) * MASS * LENGTH**2 / 12)
            start = np.zeros(size)
            start[0] = 1 - math.pi / 2
            node = mbs.AddNode(item.NodeGenericODE2(
                referenceCoordinates=[0] * size, initialCoordinates=list(start), initialCoordinates_t=[0] * size,
                numberOfODE2Coordinates=size))
            mbs.AddObject(item.ObjectKinematicTree(
                nodeNumber=node, jointTypes=[exu.JointType.RevoluteZ] * size, linkParents=np.arange(-1, size - 1),
                jointTransformations=turns, jointOffsets=offsets, linkInertiasCOM=inertias, linkCOMs=centres,
                linkMasses=[MASS] * size, gravity=[0, -GRAVITY, 0]))
            return container, mbs, lambda: np.cumsum(mbs.GetNodeOutput(node, exu.OutputVariableType.Coordinates)) + math.pi / 2
        ground = mbs.AddObject(item.ObjectGround())

        def rod(x, y, angle, vx, vy, rate):
            node = mbs.AddNode(item.NodeRigidBody2D(referenceCoordinates=[x, y, angle], initialVelocities=[vx, vy, rate]))
            body = mbs.AddObject(item.ObjectRigidBody2D(nodeNumber=node, physicsMass=ROD, physicsInertia=ROD**3 / 12))
            centre = mbs.AddMarker(item.MarkerBodyMass(bodyNumber=body))
            mbs.AddLoad(item.LoadMassProportional(markerNumber=centre, loadVector=[0, -GRAVITY, 0]))
            ends = [mbs.AddMarker(item.MarkerBodyPosition(bodyNumber=body, localPosition=[s * ROD / 2, 0, 0])) for s in (-1, 1)]
            return node, ends

        def pin_together(a, b):
            mbs.AddObject(item.ObjectJointRevolute2D(markerNumbers=[a, b]))
        cranks = [rod(i * ROD, ROD / 2, math.pi / 2, ROD / 2, 0, -1.0) for i in range(size + 1)]
        for i, (_, ends) in enumerate(cranks):
            pin_together(mbs.AddMarker(item.MarkerBodyPosition(bodyNumber=ground, localPosition=[i * ROD, 0, 0])), ends[0])
        for i in range(size):
            _, ends = rod((i + 0.5) * ROD, ROD, 0.0, ROD, 0, 0.0)
            pin_together(cranks[i][1][1], ends[0])
            pin_together(ends[1], cranks[i + 1][1][1])
        angle = lambda node: mbs.GetNodeOutput(node, exu.OutputVariableType.Coordinates)[2] + math.pi / 2
        return container, mbs, lambda: np.array([angle(node) for node, _ in cranks])

    def steps(self, h, steps):
        container, mbs, self.found = self.model()
        mbs.Assemble()
        settings = exu.SimulationSettings()
        settings.solutionSettings.writeSolutionToFile = False
        settings.timeIntegration.endTime = h * steps
        settings.timeIntegration.numberOfSteps = steps
        settings.timeIntegration.automaticStepSize = False
        settings.timeIntegration.generalizedAlpha.spectralRadius = 0.95
        settings.timeIntegration.newton.relativeTolerance = 1e-10
        # Dense matrices are faster up to some twenty bodies, sparse ones beyond.
        settings.linearSolverType = exu.LinearSolverType.EigenSparse if self.size > 10 else exu.LinearSolverType.EXUdense
        solver = exu.DynamicSolverType.RK44 if self.kind == 'chain' else exu.DynamicSolverType.GeneralizedAlpha
        if not mbs.SolveDynamic(settings, solverType=solver):
            raise RuntimeError('no success')

    def angles(self):
        return self.found()


TOOLS = [Qrm, Pinocchio, MuJoCo, Exudyn]


def reference(kind, size):
    """The angles at the end: all of a chain, those of the cranks of four-bars."""
    if kind == 'chain':
        chain = Pinocchio(kind, size)
        rates = lambda _, x: np.r_[x[size:], chain.accelerations(x[:size], x[size:])]
        start = np.r_[chain.q, chain.v]
    else:
        inertia, moment = (size + 1) / 3 + size, (size + 1) / 2 + size  # of one pendulum, for rods of one
        rates = lambda _, x: np.array([x[1], -GRAVITY * moment / inertia * math.cos(x[0])])
        start = np.array([math.pi / 2, -1.0])
    end = solve_ivp(rates, (0, END[kind]), start, method='DOP853', rtol=1e-12, atol=1e-13).y[:, -1]
    return np.cumsum(end[:size]) + math.pi / 2 if kind == 'chain' else np.full(size + 1, end[0])


def rows(kind, size, tool, exact):
    """What a tool takes for one evaluation, and for steps with their errors."""
    if hasattr(tool, 'evaluations'):
        begun = time.process_time()
        tool.evaluations(3)
        times = often(1e6 * (time.process_time() - begun) / 3)
        yield ['evaluation', '', *measured(lambda: tool.evaluations(times), times), '']
    if not hasattr(tool, 'steps'):
        return
    for h in STEPS[kind] if size == FOR_ERRORS[kind] else STEPS[kind][1:2]:
        steps = round(END[kind] / h)
        # Preparations of a run are not part of a step.
        few, many = measured(lambda: tool.steps(h, 1), 1), measured(lambda: tool.steps(h, steps), 1)
        found = np.asarray(tool.angles())[:exact.size]
        cost = (many[0] - few[0]) / (steps - 1)
        yield ['step', f'{h:g}', cost, many[1], float(np.max(np.abs(found - exact)))]


def main(command, out):
    with tempfile.TemporaryDirectory() as folder, open(out, 'w', newline='') as file:
        table = csv.writer(file, lineterminator='\n')
        table.writerow('mechanism,size,tool,version,method,what,step,microseconds,spread,error'.split(','))
        for kind, sizes in (('chain', CHAINS), ('four_bars', FOUR_BARS)):
            for size in sizes:
                exact = reference(kind, size)
                for make in TOOLS:
                    tool = make(kind, size, command, folder)
                    for what, step, cost, spread, error in rows(kind, size, tool, exact):
                        error = error if error == '' else f'{error:.2e}'
                        row = [kind, size, tool.name, tool.version, tool.method, what, step, f'{cost:.3g}', f'{spread:.2g}', error]
                        table.writerow(row)
                        print(*row, flush=True)


if __name__ == '__main__':
    HERE = os.path.dirname(os.path.abspath(__file__))
    MAKE = ['cargo', 'run', '--quiet', '--release', '--package', 'qrm-codegen', '--example', 'make', '--']
    main(sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else os.path.join(HERE, 'sizes.csv'))
