"""Runs a scene of links and joints with Exudyn and compares motion and joint forces with a trajectory.

    exudyn_peer.py SCENE.toml TRAJECTORY.csv [--substeps N] [--tolerance X]

Every link is a rigid body with three coordinates, every joint a constraint. The start is the first row. The implicit
trapezoidal rule of index 2 makes N and 2 N steps from row to row, whose results are extrapolated. Differences are
relative to the largest value of a column. Exit code 1 if one exceeds the tolerance.
"""

import argparse
import sys

import exudyn as exu
import numpy as np
from exudyn.utilities import (
    CoordinateConstraint, CoordinateSpringDamper, LoadForceVector, LoadTorqueVector, MarkerBodyPosition, MarkerBodyRigid,
    MarkerNodeCoordinate, NodePointGround, NodeRigidBody2D, ObjectGround, ObjectRigidBody2D, PrismaticJoint2D,
    RevoluteJoint2D, SpringDamper,
)  # fmt: skip
from free_body import Jet, Rows, Scene, compiled, jet, read_columns, value


class Peer:
    def __init__(self, path, columns):
        self.scene = scene = Scene(path)
        self.mbs = mbs = exu.SystemContainer().AddSystem()
        start = Rows(scene, columns, [0])
        self.bodies = {"ground": mbs.AddObject(ObjectGround())}
        self.first, self.angle_marker, self.reference = {}, {}, {}
        self.fixed = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
        for l in scene.moving:
            link = scene.links[l]
            com = [float(c.v[0]) for c in start.place(l, link.com)]
            rates = [float(c.d[0]) for c in start.place(l, link.com)]
            angle = start.angle[l]
            self.reference[l] = np.array([*com, float(angle.v[0])])
            node = mbs.AddNode(
                NodeRigidBody2D(referenceCoordinates=self.reference[l], initialVelocities=[*rates, float(angle.d[0])])
            )
            self.first[l] = 3 * (node - 1)
            self.bodies[l] = mbs.AddObject(
                ObjectRigidBody2D(nodeNumber=node, mass=link.mass, inertia=link.inertia)
            )
            self.angle_marker[l] = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=2))
        self.joints = {j.name: self.add_joint(j) for j in scene.joints.values()}
        for load in scene.loads.values():
            self.add_load(load)
        mbs.Assemble()
        self.rows = {n: [mbs.systemData.GetObjectLTGAE(o) for o, _ in made] for n, made in self.joints.items()}

    def local(self, link, at):
        com = self.scene.links[link].com if link != "ground" else (0.0, 0.0)
        return [at[0] - com[0], at[1] - com[1], 0.0]

    def marker(self, link, at, kind=MarkerBodyRigid):
        return self.mbs.AddMarker(kind(bodyNumber=self.bodies[link], localPosition=self.local(link, at)))

    def add_joint(self, j):
        """Constraints with the link that each of them acts on; the other one feels the opposite."""
        add, made = self.mbs.AddObject, []
        if j.kind == "revolute":
            last = "ground" if "ground" in j.links else j.links[-1]
            for l in j.links:
                if l != last:
                    markers = [self.marker(k, j.at[k], MarkerBodyPosition) for k in (last, l)]
                    made.append((add(RevoluteJoint2D(markerNumbers=markers)), (l, last)))
            if j.drive:
                sign, l = (1, j.links[0]) if j.links[1] == "ground" else (-1, j.links[1])
                at = lambda t: jet(eval(j.drive, {}, self.scene.names | {"t": Jet(t, 1.0)}))
                zero = self.reference[l][2]
                add(
                    CoordinateConstraint(
                        markerNumbers=[self.fixed, self.angle_marker[l]],
                        offsetUserFunction=lambda mbs, t, number, offset: float(sign * at(t).v - zero),
                        offsetUserFunction_t=lambda mbs, t, number, offset: float(sign * at(t).d),
                    )
                )
        elif j.kind in ("prismatic", "pin_in_slot"):
            a, b = j.links
            d, e = j.direction, j.direction - j.rotation
            joint = PrismaticJoint2D(
                markerNumbers=[self.marker(l, j.at[l]) for l in j.links],
                axisMarker0=[np.cos(e), np.sin(e), 0],
                normalMarker1=[-np.sin(d), np.cos(d), 0],
                constrainRotation=j.kind == "prismatic",
            )
            made.append((add(joint), (a, b)))
            assert not j.drive
        elif j.kind == "gear" and j.carrier == "ground":
            a, b = (self.angle_marker[l] for l in j.links)
            add(CoordinateConstraint(markerNumbers=[a, b], factor1=j.ratio))
        else:
            sys.exit(f"joint `{j.name}`: {j.kind} is not supported")
        return made

    def names(self, t):
        """Names in formulae at the present state."""
        data = self.mbs.systemData
        q, v = data.GetODE2Coordinates(), data.GetODE2Coordinates_t()
        names = dict(self.scene.names) | {"t": t}
        place = {"ground": (np.zeros(3), np.zeros(3))}
        for l in self.scene.moving:
            part = slice(self.first[l], self.first[l] + 3)
            place[l] = (self.reference[l] + q[part], v[part])
            name = self.scene.links[l].coordinate
            names |= {name: place[l][0][2], name + "_dot": place[l][1][2]}
        for p, (l, at) in self.scene.owners.items():
            names[p] = PointNow(*place[l], self.local(l, at))
        return names

    def add_load(self, load):
        mbs, scene = self.mbs, self.scene
        formula = lambda text: compiled(text)
        now = lambda code, t, more={}: float(value(eval(code, {}, self.names(t) | more)))
        if "gravity" in load:
            g = [*map(scene.number, load["gravity"]), 0.0]
            for l in scene.moving:
                marker = self.marker(l, scene.links[l].com, MarkerBodyPosition)
                mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVector=scene.links[l].mass * np.array(g)))
        elif "torque" in load:
            code = formula(load["torque"])
            marker = self.marker(load["on"], scene.links[load["on"]].com)
            act = lambda mbs, t, given: [0, 0, now(code, t)]
            mbs.AddLoad(LoadTorqueVector(markerNumber=marker, loadVectorUserFunction=act))
        elif "at" in load or "on" in load:
            l, at = scene.owners[load["at"]] if "at" in load else (load["on"], scene.links[load["on"]].com)
            codes = [formula(f) for f in load["force"]]
            act = lambda mbs, t, given: [*(now(c, t) for c in codes), 0]
            mbs.AddLoad(LoadForceVector(markerNumber=self.marker(l, at), loadVectorUserFunction=act))
        elif "between" in load:
            ends = [self.marker(*scene.owners[p], MarkerBodyPosition) for p in load["between"]]
            law = [scene.number(load.get(k, 0)) for k in ("rest", "spring", "damper")]
            mbs.AddObject(
                SpringDamper(markerNumbers=ends, referenceLength=law[0], stiffness=law[1], damping=law[2])
            )
        else:
            s = load["along"]
            potential = formula(load.get("potential", "0"))
            k, rest, c = (scene.number(load.get(key, 0)) for key in ("spring", "rest", "damper"))
            owner = next((l for l in scene.moving if scene.links[l].coordinate == s), None)
            rate = formula(s + "_dot")
            s = formula(s)

            def law(t):
                names = self.names(t)
                at = float(eval(s, {}, names))
                slope = jet(eval(potential, {}, names | {"s": Jet(at, 1.0)})).d
                return float(-k * (at - rest) - c * eval(rate, {}, names) - slope)

            if owner and not load.get("potential"):
                ends = [self.fixed, self.angle_marker[owner]]
                mbs.AddObject(
                    CoordinateSpringDamper(
                        markerNumbers=ends, stiffness=k, damping=c, offset=rest - self.reference[owner][2]
                    )
                )
            elif owner:
                act = lambda mbs, t, given: [0, 0, law(t)]
                marker = self.marker(owner, scene.links[owner].com)
                mbs.AddLoad(LoadTorqueVector(markerNumber=marker, loadVectorUserFunction=act))
            else:
                point, axis = load["along"].split(".")
                e = [float(axis == "x"), float(axis == "y"), 0.0]
                act = lambda mbs, t, given: [law(t) * x for x in e]
                mbs.AddLoad(LoadForceVector(markerNumber=self.marker(*scene.owners[point]), loadVectorUserFunction=act))

    def run(self, times, substeps):
        """Coordinates, rates and joint forces at the given times, which are at equal distances."""
        mbs, scene = self.mbs, self.scene
        steps = (len(times) - 1) * substeps
        found, step = [], times[-1] / steps
        data = mbs.systemData

        def after_step(mbs, t):
            number = round(t / step)
            if number > 0 and number % substeps == 0:
                found.append((data.GetODE2Coordinates(), data.GetODE2Coordinates_t(), data.GetAECoordinates()))
            return True

        mbs.SetPostStepUserFunction(after_step)
        settings = exu.SimulationSettings()
        integration = settings.timeIntegration
        integration.numberOfSteps, integration.endTime = steps, float(times[-1])
        integration.verboseMode = 0
        integration.newton.relativeTolerance = integration.newton.absoluteTolerance = 1e-11
        integration.newton.useModifiedNewton = False
        settings.solution.file.write = False
        settings.linearSolver.solverType = exu.LinearSolverType.EigenDense
        mbs.SolveDynamic(settings, solverType=exu.DynamicSolverType.TrapezoidalIndex2)
        result = {}
        q, v, multipliers = (np.array(x) for x in zip(*found))
        for l in scene.moving:
            name = scene.links[l].coordinate
            result[name] = self.reference[l][2] + q[:, self.first[l] + 2]
            result[name + "_dot"] = v[:, self.first[l] + 2]
        for name, o in scene.outputs.items():
            if not (isinstance(o, dict) and "joint" in o):
                continue
            j = scene.joints[o["joint"]]
            on = o.get("on", j.links[0])
            total = np.zeros((len(found), 2))
            for (_, links), rows in zip(self.joints[j.name], self.rows[j.name]):
                if on not in links:
                    continue
                sign = 1 if on == links[0] else -1
                if j.kind == "revolute":
                    total += sign * -multipliers[:, rows[:2]]
                else:
                    b = j.links[1]
                    angle = j.direction + (0 if b == "ground" else self.reference[b][2] + q[:, self.first[b] + 2])
                    normal = np.array([-np.sin(angle), np.cos(angle)]).T * np.ones((len(found), 1))
                    total += sign * multipliers[:, rows[0]][:, None] * normal
            result[name + "_x"], result[name + "_y"] = total.T
        return result


class PointNow:
    def __init__(self, place, rate, at):
        c, s = np.cos(place[2]), np.sin(place[2])
        dx, dy = c * at[0] - s * at[1], s * at[0] + c * at[1]
        self.x, self.y = place[0] + dx, place[1] + dy
        self.x_dot, self.y_dot = rate[0] - rate[2] * dy, rate[1] + rate[2] * dx


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("trajectory")
    parser.add_argument("--substeps", type=int, default=4, help="steps from row to row")
    parser.add_argument("--tolerance", type=float, default=1e-6)
    options = parser.parse_args()
    columns = read_columns(options.trajectory)
    t = columns["t"]
    step = t[1] - t[0]
    # The last row may end a shorter step.
    t = t[: -1] if abs(t[-1] - t[-2] - step) > 1e-9 * step else t
    coarse, fine = (Peer(options.scene, columns).run(t, options.substeps * n) for n in (1, 2))
    print(f"{'':24}{'difference':>12}{'scale':>12}{'relative':>12}{'peer itself':>12}")
    worst, bad = 0.0, 0
    for name in fine:
        if name not in columns:
            continue
        have = columns[name][1 : len(t)]
        whole = name[:-2] if name[-2:] in ("_x", "_y") else name
        scale = max(np.max(np.abs(columns[whole])), 1e-6)
        want = (4 * fine[name] - coarse[name]) / 3
        relative, own = (np.max(np.abs(x)) / scale for x in (have - want, fine[name] - want))
        wrong = not relative <= options.tolerance
        bad, worst = bad + wrong, max(worst, relative)
        print(f"  {name:22}{relative * scale:12.2e}{scale:12.3g}{relative:12.1e}{own:12.1e}{'  MISSED' if wrong else ''}")
    print(f"  largest: {worst:.1e}")
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
