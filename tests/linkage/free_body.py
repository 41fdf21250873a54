"""Checks the rows of a trajectory of a mechanism of links and joints, link by link.

    free_body.py SCENE.toml TRAJECTORY.csv [--rows N] [--tolerance X] [--motion-tolerance X]

The places of the links follow from the angles in the table and from the joints. All joints must close, with their
rates and accelerations. Then the equations of Newton and Euler of every link are solved for the forces and moments of
all joints, which are compared with the columns of the outputs. They are 3 equations a link: where the mechanism can
move freely there are more equations than unknowns, and the rest of them is the equation of motion. At last, rates are
integrated and compared with positions, accelerations with rates. Exit code 1 if a difference exceeds its tolerance.

Friction in joints is that of the forces found. Teeth of gears act at the pitch point, across the line of the axes;
belts, and gears without axes on their carrier, act by moments alone. A load at a point that several links share acts on
the one that is nearest to the ground by pins and welds.
"""

import argparse
import csv
import heapq
import re
import sys
import tomllib

import numpy as np
from scipy.interpolate import CubicSpline, make_interp_spline

KINDS = ("revolute", "prismatic", "pin_in_slot", "weld", "rod", "gear", "belt", "rack", "cam")
IDENTIFIER = r"[A-Za-z_]\w*"


class Jet:
    """A value with its first and second derivative: arrays over the rows."""

    def __init__(self, v, d=0.0, dd=0.0):
        self.v, self.d, self.dd = v, d, dd

    def __add__(a, b):
        b = jet(b)
        return Jet(a.v + b.v, a.d + b.d, a.dd + b.dd)

    def __mul__(a, b):
        b = jet(b)
        return Jet(a.v * b.v, a.d * b.v + a.v * b.d, a.dd * b.v + 2 * a.d * b.d + a.v * b.dd)

    def of(self, f, df, ddf):
        """f(self), by the values of f and its derivatives."""
        return Jet(f, df * self.d, ddf * self.d**2 + df * self.dd)

    def __pow__(a, b):
        if isinstance(b, Jet):
            return exp(b * log(a))
        if b in (0, 1):
            return a * b + (1 - b)
        return a.of(a.v**b, b * a.v ** (b - 1), b * (b - 1) * a.v ** (b - 2 if b != 2 else 0))

    def __truediv__(a, b):
        return a * jet(b) ** -1

    __radd__ = __add__
    __rmul__ = __mul__
    __neg__ = lambda a: a * -1.0
    __pos__ = lambda a: a
    __sub__ = lambda a, b: a + -jet(b)
    __rsub__ = lambda a, b: -a + b
    __rtruediv__ = lambda a, b: a**-1 * b
    __rpow__ = lambda a, b: jet(float(b)) ** a


def jet(x):
    return x if isinstance(x, Jet) else Jet(x)


def value(x):
    return x.v if isinstance(x, Jet) else x


def sin(x):
    x = jet(x)
    return x.of(np.sin(x.v), np.cos(x.v), -np.sin(x.v))


def cos(x):
    x = jet(x)
    return x.of(np.cos(x.v), -np.sin(x.v), -np.cos(x.v))


def exp(x):
    x = jet(x)
    return x.of(*[np.exp(x.v)] * 3)


def log(x):
    x = jet(x)
    return x.of(np.log(x.v), 1 / x.v, -(x.v**-2.0))


def tanh(x):
    x = jet(x)
    t = np.tanh(x.v)
    return x.of(t, 1 - t * t, -2 * t * (1 - t * t))


def atan(x):
    x = jet(x)
    return x.of(np.arctan(x.v), 1 / (1 + x.v**2), -2 * x.v / (1 + x.v**2) ** 2)


def sign(x):
    return Jet(np.sign(value(x)))


def sqrt(x):
    return jet(x) ** 0.5


def hypot(x, y):
    return sqrt(x * x + y * y)


def maximum(x, y):
    x, y = jet(x), jet(y)
    return Jet(*(np.where(x.v >= y.v, a, b) for a, b in ((x.v, y.v), (x.d, y.d), (x.dd, y.dd))))


FUNCTIONS = {
    "pi": np.pi, "sin": sin, "cos": cos, "exp": exp, "log": log, "tanh": tanh, "sign": sign, "sqrt": sqrt,
    "hypot": hypot, "atan": atan, "max": maximum, "min": lambda x, y: -maximum(-jet(x), -jet(y)),
    "abs": lambda x: maximum(x, -jet(x)), "tan": lambda x: sin(x) / cos(x),
    "asin": lambda x: atan(x / sqrt(1 - x * x)), "acos": lambda x: np.pi / 2 - atan(x / sqrt(1 - x * x)),
}  # fmt: skip


def compiled(text):
    text = re.sub(r"((?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)deg\b", r"(\1*(pi/180))", str(text))
    return compile(text.replace("^", "**"), text, "eval")


def table(t):
    x, y = np.array(t["x"], float), np.array(t["y"], float)
    if "spline" in t:
        spline = CubicSpline(x, y, bc_type=t["spline"])
        orders = [spline.derivative(order) for order in (1, 2)]
        return lambda a: jet(a).of(spline(jet(a).v), *(derivative(jet(a).v) for derivative in orders))
    return lambda a: Jet(np.interp(value(a), x, y))


class Point:
    """A point of a link, as formulae see it."""

    def __init__(self, x, y):
        self.x, self.y, self.x_dot, self.y_dot = x, y, Jet(x.d), Jet(y.d)


class Link:
    def __init__(self, name, keys, number):
        self.name = name
        self.points = {p: tuple(map(number, at)) for p, at in keys.get("points", {}).items()}
        self.coordinate = keys.get("coordinate", "phi_" + name)
        mass = number(keys.get("mass", 0))
        com, inertia = None, 0.0
        if "bar" in keys:
            a, b = keys["bar"]
            length = number(keys["length"])
            self.points |= {a: (0.0, 0.0), b: (length, 0.0)}
            mass = number(keys["density"]) * length if "density" in keys else mass
            com, inertia = (length / 2, 0.0), mass * length**2 / 12
        if "triangle" in keys:
            a, b, c = keys["triangle"]
            ab, bc, ca = map(number, keys["sides"])
            x = (ab**2 + ca**2 - bc**2) / (2 * ab)
            y = np.sqrt(ca**2 - x**2)
            self.points |= {a: (0.0, 0.0), b: (ab, 0.0), c: (x, y)}
            mass = number(keys["density"]) * ab * y / 2 if "density" in keys else mass
            com, inertia = ((ab + x) / 3, y / 3), mass * (ab**2 + bc**2 + ca**2) / 36
        if "com" in keys:
            com = keys["com"]
            com, inertia = self.points[com] if isinstance(com, str) else tuple(map(number, com)), 0.0
        self.mass, self.com = mass, com or (0.0, 0.0)
        self.inertia = number(keys["inertia"]) if "inertia" in keys else inertia


class Joint:
    def __init__(self, name, keys, links, number):
        self.name, self.keys = name, keys
        self.kind = next(k for k in KINDS if k in keys)
        if self.kind == "belt":
            first, second = map(number, keys["radii"])
            ratio = -second / first if keys.get("crossed") else second / first
            keys, self.kind = {**keys, "gear": keys["belt"], "ratio": ratio}, "gear"
        ends = [(e.split(".") + [name])[:2] for e in keys[self.kind]]
        self.links = [e[0] for e in ends]
        if self.kind == "gear":
            ends = []
        self.at = {l: links[l].points[p] for l, p in ends}
        self.point_names = dict(ends)
        for key in ("length", "ratio", "radius", "phase", "direction", "rotation"):
            setattr(self, key, number(keys.get(key, 0)))
        self.carrier = keys.get("carrier", "ground")
        self.drive = compiled(keys["drive"]) if "drive" in keys else None
        self.profile = compiled(keys["profile"]) if "profile" in keys else None
        self.face = number(keys["face"]) if "face" in keys else None
        self.friction = {key: number(value) for key, value in keys.get("friction", {}).items()}


class Scene:
    def __init__(self, path):
        with open(path, "rb") as file:
            self.keys = keys = tomllib.load(file)
        if any(k in keys for k in ("points", "bodies", "constraints")):
            sys.exit(f"{path}: only links and joints are supported")
        self.names = dict(FUNCTIONS)
        for name, p in keys.get("parameters", {}).items():
            self.names[name] = self.number(p["value"] if isinstance(p, dict) else p)
        for name, t in keys.get("tables", {}).items():
            self.names[name] = table(t)
        keys["links"].setdefault("ground", {})
        self.links = {n: Link(n, k, self.number) for n, k in keys["links"].items()}
        self.joints = {n: Joint(n, k, self.links, self.number) for n, k in keys.get("joints", {}).items()}
        self.loads, self.outputs = keys.get("loads", {}), keys.get("outputs", {})
        self.moving = [l for l in self.links if l != "ground"]
        self.find_owners()

    def number(self, text):
        return float(value(eval(compiled(text), {}, self.names)))

    def find_owners(self):
        """For each name of a point the link whose point it is."""
        distance, queue = {}, [(0, 0, "ground")]
        while queue:
            d, _, link = heapq.heappop(queue)
            if link in distance:
                continue
            distance[link] = d
            for j in self.joints.values():
                if link in j.links and j.kind != "gear":
                    cost = 1 if j.kind in ("revolute", "weld") else 100
                    queue += [(d + cost, i, l) for i, l in enumerate(j.links) if l not in distance]
                    heapq.heapify(queue)
        self.owners = {}
        for l, link in self.links.items():
            for p, at in link.points.items():
                self.owners[f"{l}_{p}"] = self.owners[f"{l}.{p}"] = (l, at)
        for l in sorted(self.links, key=lambda l: distance.get(l, 1e9)):
            for p, at in self.links[l].points.items():
                self.owners.setdefault(p, (l, at))


class Rows:
    """Places of all links in some rows of a trajectory."""

    def __init__(self, scene, columns, rows):
        self.scene = scene
        self.t = columns["t"][rows]
        self.index = rows
        self.count = len(rows)
        self.columns = columns
        at = lambda n: Jet(*(columns[n + s][rows] for s in ("", "_dot", "_ddot")))
        zero = np.zeros(self.count)
        self.angle = {"ground": Jet(zero, zero, zero)}
        for l in scene.moving:
            if scene.links[l].coordinate in columns:
                self.angle[l] = at(scene.links[l].coordinate)
        for _ in scene.links:
            for j in scene.joints.values():
                if j.kind in ("prismatic", "weld"):
                    a, b = j.links
                    if a not in self.angle and b in self.angle:
                        self.angle[a] = self.angle[b] + j.rotation
                    if b not in self.angle and a in self.angle:
                        self.angle[b] = self.angle[a] - j.rotation
        missing = [l for l in scene.links if l not in self.angle]
        if missing:
            sys.exit(f"no column and no joint gives the angle of {', '.join(missing)}")
        # The origins are the solution of equations that are linear once the angles are known.
        self.origin = {l: [Jet(zero, zero, zero), Jet(zero, zero, zero)] for l in scene.links}
        self.given = []
        for j in scene.joints.values():
            if "s_" + j.name in columns:
                self.given.append((j, at("s_" + j.name)))
        self.free = [(l, i, at(f"{c}_{l}")) for l in scene.moving for i, c in enumerate("xy") if f"{c}_{l}" in columns]
        unknown = [self.origin[l][i] for l in scene.moving for i in (0, 1)]
        base = [r.v for r in self.place_equations()]
        matrix = np.zeros((self.count, len(base), len(unknown)))
        for k, u in enumerate(unknown):
            u.v = zero + 1
            matrix[:, :, k] = np.array([r.v - b for r, b in zip(self.place_equations(), base)]).T
            u.v = zero
        inverse = np.linalg.pinv(matrix)
        if np.linalg.matrix_rank(matrix[0]) < len(unknown):
            sys.exit("the columns and joints do not give the place of every link")
        for order in ("v", "d", "dd", "v", "d", "dd"):
            right = np.array([getattr(r, order) + zero for r in self.place_equations()]).T
            for k, u in enumerate(unknown):
                setattr(u, order, getattr(u, order) - np.einsum("rm,rm->r", inverse[:, k], right))

    def place(self, link, at, origin=None, angle=None):
        """A point of a link, by its components."""
        x, y = origin or self.origin[link]
        c, s = cos(angle or self.angle[link]), sin(angle or self.angle[link])
        return x + c * at[0] - s * at[1], y + s * at[0] + c * at[1]

    def ends(self, j):
        return [self.place(l, j.at[l]) for l in j.links]

    def line(self, j):
        """Direction and normal of the line of a joint."""
        angle = self.angle[j.links[1]] + j.direction
        return (cos(angle), sin(angle)), (-sin(angle), cos(angle))

    def along(self, j):
        """Place of the first point along the line of the second link, and its distance from the line."""
        (ax, ay), (bx, by) = self.ends(j)
        u, n = self.line(j)
        return u[0] * (ax - bx) + u[1] * (ay - by), n[0] * (ax - bx) + n[1] * (ay - by)

    def contact(self, j):
        """Angle of the contact of a cam in its frame, the profile there, and where and how the follower is met."""
        theta = Jet(*(self.columns[f"theta_{j.name}{s}"][self.index] for s in ("", "_dot", "_ddot")))
        profile = eval(j.profile, {}, self.scene.names | {"theta": theta})
        at = eval(j.profile, {}, self.scene.names | {"theta": Jet(theta.v, 1.0)})
        return theta, profile, jet(at).d

    def place_equations(self):
        """What closes the joints and is linear in the origins."""
        for j in self.scene.joints.values():
            if j.kind in ("revolute", "weld"):
                first, *others = self.ends(j)
                for other in others:
                    yield from (first[0] - other[0], first[1] - other[1])
            elif j.kind in ("prismatic", "pin_in_slot"):
                yield self.along(j)[1]
                if j.drive:
                    yield self.along(j)[0] - eval(j.drive, {}, self.scene.names | {"t": Jet(self.t, 1.0)})
            elif j.kind == "rack":
                a, b = (self.angle[l] for l in j.links)
                yield self.along(j)[0] + j.radius * (a - b) - j.phase
        for j, s in self.given:
            yield self.along(j)[0] - s
        for l, i, x in self.free:
            yield self.origin[l][i] - x

    def other_equations(self):
        for j in self.scene.joints.values():
            angles = [self.angle[l] for l in j.links]
            if j.kind in ("prismatic", "weld"):
                yield angles[0] - angles[1] - j.rotation
            elif j.kind == "rod":
                (ax, ay), (bx, by) = self.ends(j)
                yield hypot(ax - bx, ay - by) - j.length
            elif j.kind == "cam":
                (px, py), (ox, oy) = self.ends(j)
                theta, profile, _ = self.contact(j)
                turned = self.angle[j.links[1]] + theta if j.face is None else self.angle[j.links[0]] + j.face
                yield cos(turned) * (px - ox) + sin(turned) * (py - oy) - profile
                if j.face is None:
                    yield cos(turned) * (py - oy) - sin(turned) * (px - ox)
                else:
                    yield theta + self.angle[j.links[1]] - turned
            elif j.kind == "gear":
                c = self.angle[j.carrier]
                yield angles[0] - c - j.ratio * (angles[1] - c) - j.phase
            if j.kind == "revolute" and j.drive:
                yield angles[0] - angles[1] - eval(j.drive, {}, self.scene.names | {"t": Jet(self.t, 1.0)})

    def environment(self, moved=None, displacement=None):
        """Names in formulae. With a link and a displacement of it, rates are those of the displacement."""
        names = dict(self.scene.names) | {"t": Jet(self.t, 0.0 if moved else 1.0)}
        places = {}
        for l in self.scene.links:
            (x, y), a = self.origin[l], self.angle[l]
            if moved:
                dx, dy, da = displacement if l == moved else (0.0, 0.0, 0.0)
                x, y, a = Jet(x.v, dx - da * y.v), Jet(y.v, dy + da * x.v), Jet(a.v, da)
            places[l] = ((x, y), a)
            names[self.scene.links[l].coordinate] = a
            names[self.scene.links[l].coordinate + "_dot"] = Jet(a.d)
        for p, (l, at) in self.scene.owners.items():
            names[p] = Point(*self.place(l, at, *places[l]))
        return names


def wrench(point, force):
    """Force and its moment about the origin of the plane."""
    (x, y), (fx, fy) = point, force
    return np.array([fx + 0 * x, fy + 0 * x, x * fy - y * fx])


def axes_of_teeth(rows, j):
    """The axes of two gears on their carrier; None if they are not apart, or a belt joins them."""
    scene = rows.scene
    if "belt" in j.keys or j.ratio == 1:
        return None
    pins = [p for p in scene.joints.values() if p.kind == "revolute"]
    place = lambda p, l: np.array([value(c) for c in rows.place(l, p.at[l])])
    is_same = lambda p, q: np.max(np.abs(p - q)) < 1e-9

    def rigid(link):
        """A link and those that are welded to it."""
        links = {link}
        for _ in scene.links:
            for w in scene.joints.values():
                if w.kind == "weld" and links & set(w.links):
                    links |= set(w.links)
        return links

    def axis(link):
        own, carrier = rigid(link), rigid(j.carrier)
        ends = lambda p, links: [l for l in p.links if l in links]
        for p in pins:
            if ends(p, own) and ends(p, carrier):
                return place(p, ends(p, own)[0])
        for p in pins:
            for q in pins:
                if ends(p, own) and ends(q, carrier) and set(p.links) & set(q.links):
                    at = place(p, ends(p, own)[0])
                    if is_same(at, place(q, ends(q, carrier)[0])):
                        return at
        return None

    axes = [axis(l) for l in j.links]
    return None if any(a is None for a in axes) or is_same(*axes) else axes


def columns_of_joints(rows):
    """The unknowns: what each of them does to which link."""
    scene, one, zero = rows.scene, np.ones(rows.count), np.zeros(rows.count)
    moment = np.array([zero, zero, one])
    for j in scene.joints.values():
        a, b = j.links[:2]
        ends = [] if j.kind == "gear" else [tuple(value(c) for c in e) for e in rows.ends(j)]

        def pair(kind, force):
            w = wrench(ends[0], force)
            return j.name, kind, {a: w, b: -w}

        if j.kind in ("revolute", "weld"):
            last = "ground" if "ground" in j.links else j.links[-1]
            for l in j.links:
                if l != last:
                    for force in ((one, zero), (zero, one)):
                        w = wrench(ends[0], force)
                        yield j.name, "force", {l: w, last: -w}
        if j.kind in ("prismatic", "pin_in_slot", "rack"):
            u, n = (tuple(map(value, e)) for e in rows.line(j))
            if j.kind != "rack":
                yield pair("force", n)
                if j.drive:
                    yield pair("drive", u)
            else:
                contact = tuple(e - j.radius * m for e, m in zip(ends[0], n))
                w = wrench(contact, u)
                yield j.name, "force", {a: w, b: -w}
        if j.kind in ("prismatic", "weld"):
            yield j.name, "moment", {a: moment, b: -moment}
        if j.kind == "revolute" and j.drive:
            yield j.name, "drive", {a: moment, b: -moment}
        if j.kind == "cam":
            theta, profile, slope = rows.contact(j)
            (a_angle, b_angle), h = (rows.angle[l].v for l in j.links), value(profile)
            if j.face is None:
                e = (np.cos(b_angle + theta.v), np.sin(b_angle + theta.v))
                size = np.hypot(h, slope)
                yield pair("force", ((h * e[0] + slope * e[1]) / size, (h * e[1] - slope * e[0]) / size))
            else:
                n = (np.cos(a_angle + j.face), np.sin(a_angle + j.face))
                touched = (ends[1][0] + h * n[0] - slope * n[1], ends[1][1] + h * n[1] + slope * n[0])
                w = wrench(touched, n)
                yield j.name, "force", {a: w, b: -w}
        if j.kind == "rod":
            d = [p - q for p, q in zip(*ends)]
            size = np.hypot(*d)
            yield pair("force", (d[0] / size, d[1] / size))
        if j.kind == "gear" and (axes := axes_of_teeth(rows, j)):
            # The first gear is turned by one newton metre, by a force at the pitch point across the line of the axes.
            (ax, ay), (bx, by) = axes
            dx, dy = bx - ax, by - ay
            pitch = (ax + dx / (1 - j.ratio), ay + dy / (1 - j.ratio))
            size = (1 - j.ratio) / (dx * dx + dy * dy)
            w = wrench(pitch, (-dy * size, dx * size))
            yield j.name, "force", {a: w, b: -w}
        elif j.kind == "gear":
            effect = {l: 0 * moment for l in (a, b, j.carrier)}
            for l, factor in ((a, 1.0), (b, -j.ratio), (j.carrier, j.ratio - 1)):
                effect[l] = effect[l] + factor * moment
            yield j.name, "moment", effect


def loads(rows):
    """What the loads do to each link."""
    scene, names, zero = rows.scene, rows.environment(), np.zeros(rows.count)
    total = {l: np.zeros((3, rows.count)) for l in scene.links}
    scalar = lambda text, more={}: value(eval(compiled(text), {}, names | more))
    for load in scene.loads.values():
        if "gravity" in load:
            for l in scene.moving:
                link = scene.links[l]
                com = [value(c) for c in rows.place(l, link.com)]
                total[l] += wrench(com, [link.mass * scalar(g) for g in load["gravity"]])
        elif "torque" in load:
            total[load["on"]][2] += scalar(load["torque"])
        elif "at" in load or "on" in load:
            l, at = scene.owners[load["at"]] if "at" in load else (load["on"], scene.links[load["on"]].com)
            total[l] += wrench([value(c) for c in rows.place(l, at)], [scalar(f) + zero for f in load["force"]])
        else:
            if "between" in load:
                p, q = (name.replace(".", "_") for name in load["between"])
                length = compiled(f"hypot({p}.x - {q}.x, {p}.y - {q}.y)")
            else:
                length = compiled(load["along"])
            s = jet(eval(length, {}, names))
            law = {"s": Jet(s.v), "s_dot": Jet(s.d)}
            f = zero - scalar(load.get("spring", 0)) * (s.v - scalar(load.get("rest", 0)))
            f = f - scalar(load.get("damper", 0)) * s.d + scalar(load.get("force", 0), law)
            if "friction" in load:
                f = f - scalar(load["friction"], law) * np.tanh(s.d / scalar(load["slip"]))
            if "potential" in load:
                f = f - jet(eval(compiled(load["potential"]), {}, names | {"s": Jet(s.v, 1.0)})).d
            for l in scene.links:
                for i in range(3):
                    e = [float(i == k) for k in range(3)]
                    total[l][i] += f * jet(eval(length, {}, rows.environment(l, e))).d
    return total


def friction(rows, unknowns, solution):
    """What the friction of joints does to each link, by the forces in the joints; and of which joint it is."""
    scene, zero = rows.scene, np.zeros(rows.count)
    for j in scene.joints.values():
        if not j.friction:
            continue
        a, b = j.links
        normal = np.zeros((2, rows.count))
        for k, (of, what, effect) in enumerate(unknowns):
            if of == j.name and what == "force":
                normal = normal + effect[a][:2] * solution[:, k]
        size = j.friction["mu"] * np.hypot(*normal)
        if j.kind == "revolute":
            radius = j.friction["radius"]
            w = radius * (rows.angle[a] - rows.angle[b]).d
            effect = np.array([zero, zero, -radius * size * np.tanh(w / j.friction["slip"])])
        else:
            u = [value(e) for e in rows.line(j)[0]]
            force = -size * np.tanh(rows.along(j)[0].d / j.friction["slip"])
            effect = wrench([value(c) for c in rows.ends(j)[0]], [force * u[0], force * u[1]])
        yield j.name, {a: effect, b: -effect}


def check(scene, columns, wanted_rows):
    """Lists of (name, largest difference, scale, kind)."""
    count = len(columns["t"])
    index = np.unique(np.linspace(0, count - 1, min(wanted_rows, count)).astype(int))
    rows = Rows(scene, columns, index)
    largest = lambda x: float(np.max(np.abs(x), initial=0.0))
    results = []

    # The joints are closed.
    residuals = list(rows.place_equations()) + list(rows.other_equations())
    for order, what in (("v", "position"), ("d", "rate"), ("dd", "acceleration")):
        scale = max(1.0, max(largest(getattr(a, order)) for a in rows.angle.values()))
        results.append((f"joints, {what}", max((largest(getattr(r, order)) for r in residuals), default=0), scale, "force"))

    # The equations of Newton and Euler.
    unknowns = list(columns_of_joints(rows))
    applied = loads(rows)
    size = 3 * len(scene.moving)
    matrix, right = np.zeros((rows.count, size, len(unknowns))), np.zeros((rows.count, size))
    for i, l in enumerate(scene.moving):
        link = scene.links[l]
        com = rows.place(l, link.com)
        inertia = wrench([c.v for c in com], [link.mass * c.dd for c in com])
        inertia[2] += link.inertia * rows.angle[l].dd
        right[:, 3 * i : 3 * i + 3] = (inertia - applied[l]).T
        for k, (_, _, effect) in enumerate(unknowns):
            if l in effect:
                matrix[:, 3 * i : 3 * i + 3, k] = effect[l].T

    # What the outputs of joints are of the unknowns: rows of a matrix.
    asked, sliding = [], {}
    for name, o in scene.outputs.items():
        kind = next((k for k in ("joint", "moment", "drive") if isinstance(o, dict) and k in o), None)
        if not kind:
            continue
        j = scene.joints[o[kind]]
        on = o.get("on", j.links[0])
        picks = np.zeros((rows.count, 3, len(unknowns)))
        for k, (of, what, effect) in enumerate(unknowns):
            if of == j.name and on in effect and (kind != "drive" or what == "drive"):
                picks[:, :, k] = effect[on].T
        if kind == "joint":
            asked += [(f"{name}_x", name, picks[:, 0]), (f"{name}_y", name, picks[:, 1])]
            for axis in (0, 1) if j.kind in ("prismatic", "pin_in_slot") and j.friction else ():
                sliding[f"{name}_{'xy'[axis]}"] = (j.name, on, axis)
        elif kind == "moment" or j.kind == "revolute":
            x, y = [value(c) for c in rows.ends(j)[0]] if j.at else (0.0, 0.0)
            if j.kind == "gear" and (axes := axes_of_teeth(rows, j)):
                x, y = axes[j.links.index(on)]
            about = picks[:, 2] - (np.multiply(x, picks[:, 1].T) - np.multiply(y, picks[:, 0].T)).T
            asked.append((name, name, about))
            if kind == "moment" and j.kind == "revolute" and j.friction:
                sliding[name] = (j.name, on, 2)
        else:
            u = [value(c) for c in rows.line(j)[0]]
            asked.append((name, name, (u[0] * picks[:, 0].T + u[1] * picks[:, 1].T).T))

    if unknowns:
        rank = np.linalg.matrix_rank(matrix[rows.count // 2], tol=1e-10)
        inverse = np.linalg.pinv(matrix, rcond=1e-11)
        solution = np.einsum("rkm,rm->rk", inverse, right)
        without, rubbing = right, []
        # Friction depends on the forces: each pass takes those of the one before.
        for _ in range(200 if any(j.friction for j in scene.joints.values()) else 0):
            rubbing = list(friction(rows, unknowns, solution))
            right = without.copy()
            for _, effect in rubbing:
                for i, l in enumerate(scene.moving):
                    if l in effect:
                        right[:, 3 * i : 3 * i + 3] -= effect[l].T
            solution = np.einsum("rkm,rm->rk", inverse, right)
        rest = right - np.einsum("rmk,rk->rm", matrix, solution)
        null = np.eye(len(unknowns)) - inverse @ matrix
    else:
        rank, rest, rubbing = 0, right, []
    scale = max(largest(right), 1e-300)
    results.append((f"equations of motion ({size - rank} beyond the joints)", largest(rest), scale, "force"))

    shared = []
    for column, name, pick in asked:
        have = columns[column][index]
        for of, effect in rubbing:
            if column in sliding and sliding[column][0] == of:
                have = have - effect[sliding[column][1]][sliding[column][2]]
        size_of = max(largest(columns[c][index]) for c, n, _ in asked if n == name)
        size_of = max(size_of, 1e-9 * scale)
        if largest(np.einsum("rk,rkl->rl", pick, null)) > 1e-8:
            shared.append((column, pick, have))
        else:
            results.append((column, largest(np.einsum("rk,rk->r", pick, solution) - have), size_of, "force"))
    if shared:
        # Forces that are not unique: taken as they are, they must be in equilibrium with the rest.
        more = np.concatenate([matrix] + [p[:, None, :] for _, p, _ in shared], axis=1)
        wanted = np.concatenate([right] + [h[:, None] for _, _, h in shared], axis=1)
        fit = np.einsum("rkm,rm->rk", np.linalg.pinv(more, rcond=1e-11), wanted)
        rest = wanted - np.einsum("rmk,rk->rm", more, fit)
        results.append((f"not unique, in balance: {' '.join(c for c, _, _ in shared)}", largest(rest), scale, "force"))

    # Outputs that are formulae.
    names = rows.environment()
    for name, o in scene.outputs.items():
        o = o if isinstance(o, dict) else {"value": o}
        for kind, order in (("value", "v"), ("rate", "d"), ("second_rate", "dd")):
            if kind in o:
                have = columns[name][index]
                want = getattr(jet(eval(compiled(o[kind]), {}, names)), order)
                results.append((name, largest(want - have), max(1.0, largest(have)), "force"))

    # Rates are the derivatives of positions.
    t = columns["t"]
    for name in columns:
        for a, b in ((name, name + "_dot"), (name + "_dot", name + "_ddot")):
            if name + "_ddot" in columns and len(t) > 6:
                integral = make_interp_spline(t, columns[b], k=5).antiderivative()
                want = columns[a][0] + integral(t) - integral(t[0])
                scale = max(1.0, largest(columns[a]))
                results.append((f"{a} by integral", largest(want - columns[a]), scale, "motion"))
    return results


def read_columns(path):
    with open(path) as file:
        head, *rows = csv.reader(file)
    return dict(zip(head, np.array(rows, float).T))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("trajectory")
    parser.add_argument("--rows", type=int, default=400, help="how many rows to check, spread over the run")
    parser.add_argument("--tolerance", type=float, default=1e-9, help="of forces and closed joints, relative")
    parser.add_argument("--motion-tolerance", type=float, default=1e-6, help="of integrated rates, relative")
    options = parser.parse_args()
    scene = Scene(options.scene)
    worst = {"force": 0.0, "motion": 0.0}
    bad = 0
    print(f"{scene.keys['name']}\n{'':52}{'difference':>12}{'scale':>12}{'relative':>12}")
    for name, difference, scale, kind in check(scene, read_columns(options.trajectory), options.rows):
        relative = difference / scale
        limit = options.tolerance if kind == "force" else options.motion_tolerance
        wrong = not relative <= limit
        bad += wrong
        worst[kind] = max(worst[kind], relative)
        print(f"  {name:50}{difference:12.2e}{scale:12.3g}{relative:12.1e}{'  MISSED' if wrong else ''}")
    print(f"  largest: {worst['force']:.1e} of forces and joints, {worst['motion']:.1e} of integrated rates")
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
