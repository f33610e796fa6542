#!/usr/bin/env python3
"""The bath duck of ../duck.yaml between two rigid spheres, from CalculiX: solid elements, neo-Hookean.

The deck is in mm, N, MPa, results in m and N. See README.md here for what comes out. Python 3
standard library and ccx only.

  duck_deck.py --work=DIR [--out=DIR] [--control=../duck_2562.obj] [--global=0] [--local=1]
               [--layers=1] [--stiffness=400]

Control points are those of a Loop surface. Every node's place in the surface is a vertex of the
control mesh subdivided a few times, so that its limit position and normal follow from the masks
of Loop's scheme; C3D15 wedges reach half the thickness to both sides of it. The duck and the grasp
are symmetric about y = 0: the half y >= 0 is modelled, and triangles that cross y = 0 are cut there.
"""
import argparse
import json
import math
import os
import sys

sys.dont_write_bytecode = True
import ccx_job

HERE = os.path.dirname(os.path.abspath(__file__))
THICKNESS = 1.5
YOUNG = 2.0
POISSON = 0.45
FINGER = 8.0                  # radius
AXIS = (-2.65, 25.95)         # x, z of the line on which the fingers close
TRAVELS = [2, 4, 6, 8.5]


def add(*terms):
    """Sum of (weight, vector)."""
    return tuple(sum(w * v[k] for w, v in terms) for k in range(3))


def unit(v):
    length = math.sqrt(sum(x * x for x in v))
    return tuple(x / length for x in v)


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def read_obj(path):
    points, faces = [], []
    for line in open(path):
        words = line.split()
        if words and words[0] == "v":
            points.append(tuple(1000 * float(w) for w in words[1:4]))
        elif words and words[0] == "f":
            faces.append(tuple(int(w.split("/")[0]) - 1 for w in words[1:4]))
    return points, faces


class LoopSurface:
    """The control mesh subdivided `levels` times. Vertices keep their numbers from level to level, so that
    an edge (a, b) belongs to one level only and middle(a, b) is the vertex that halves it."""

    def __init__(self, points, faces, levels):
        self.level_faces = [faces]
        self.halves = {}
        self.limits = {}
        for _ in range(levels):
            points, faces = self.subdivide(points, faces)
            self.level_faces.append(faces)
        self.points = points
        self.ring_of = None

    @staticmethod
    def key(a, b):
        return (a, b) if a < b else (b, a)

    def middle(self, a, b):
        return self.halves[self.key(a, b)]

    def subdivide(self, points, faces):
        opposite, neighbours = {}, [[] for _ in points]
        for a, b, c in faces:
            for p, q, r in ((a, b, c), (b, c, a), (c, a, b)):
                opposite.setdefault(self.key(p, q), []).append(r)
                neighbours[p].append(q)          # once from each triangle: closed mesh
        fine = []
        for k, ring in enumerate(neighbours):
            n = len(ring)
            beta = (0.625 - (0.375 + 0.25 * math.cos(2 * math.pi / n)) ** 2) / n
            fine.append(add((1 - n * beta, points[k]), *((beta, points[j]) for j in ring)))
        for (p, q), ends in opposite.items():
            self.halves[p, q] = len(fine)
            fine.append(add((0.375, points[p]), (0.375, points[q]), *((0.125, points[r]) for r in ends)))
        small = []
        for a, b, c in faces:
            ab, bc, ca = self.middle(a, b), self.middle(b, c), self.middle(c, a)
            small += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        return fine, small

    def limit(self, k):
        """Limit position and unit normal at vertex k of the finest level."""
        if self.ring_of is None:
            self.ring_of = [[] for _ in self.points]
            for a, b, c in self.level_faces[-1]:
                self.ring_of[a].append((b, c))
                self.ring_of[b].append((c, a))
                self.ring_of[c].append((a, b))
        if k not in self.limits:
            follow = dict(self.ring_of[k])
            ring = [self.ring_of[k][0][0]]
            while len(ring) < len(follow):
                ring.append(follow[ring[-1]])
            n = len(ring)
            beta = (0.625 - (0.375 + 0.25 * math.cos(2 * math.pi / n)) ** 2) / n
            w = 1 / (n + 3 / (8 * beta))
            q = [self.points[j] for j in ring]
            position = add((1 - n * w, self.points[k]), *((w, p) for p in q))
            s = add(*((math.cos(2 * math.pi * i / n), p) for i, p in enumerate(q)))
            t = add(*((math.sin(2 * math.pi * i / n), p) for i, p in enumerate(q)))
            self.limits[k] = (position, unit(cross(s, t)))
        return self.limits[k]


def halve(surface, faces):
    """Triangles of the half y >= 0; what crosses y = 0 is cut from its vertex there to the opposite edge."""
    small = 1e-9 * max(abs(p[1]) for p in surface.points)
    side = lambda k: 0 if abs(surface.points[k][1]) < small else (1 if surface.points[k][1] > 0 else -1)
    kept = []
    for face in faces:
        sides = [side(k) for k in face]
        if min(sides) >= 0:
            kept.append(face)
        elif max(sides) > 0:
            i = sides.index(0)
            a, b, c = face[i], face[(i + 1) % 3], face[(i + 2) % 3]
            m = surface.middle(b, c)
            if side(m):
                raise RuntimeError("the mesh is not symmetric about y = 0")
            surface.halves[surface.key(a, m)] = surface.middle(surface.middle(a, b), surface.middle(a, c))
            kept.append((a, b, m) if side(b) > 0 else (a, m, c))
    return kept


def refine(surface, faces, radius):
    """Halves the edges within the radius of the finger's line; triangles beside it are bisected."""
    def near(face):
        p = [surface.points[k] for k in face]
        return any(q[1] > 0 and math.hypot(q[0] - AXIS[0], q[2] - AXIS[1]) < radius for q in p)

    red = set(k for k, face in enumerate(faces) if near(face))
    edges = lambda f: [surface.key(f[i], f[(i + 1) % 3]) for i in range(3)]
    while True:
        split = set(e for k in red for e in edges(faces[k]))
        more = [k for k, f in enumerate(faces) if k not in red and sum(e in split for e in edges(f)) > 1]
        if not more:
            break
        red.update(more)
    result = []
    for k, face in enumerate(faces):
        a, b, c = face
        if k in red:
            ab, bc, ca = surface.middle(a, b), surface.middle(b, c), surface.middle(c, a)
            result += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
            continue
        cut = [i for i, e in enumerate(edges(face)) if e in split]
        if not cut:
            result.append(face)
            continue
        b, c, a = face[cut[0]], face[(cut[0] + 1) % 3], face[(cut[0] + 2) % 3]
        m = surface.middle(b, c)
        surface.halves[surface.key(a, m)] = surface.middle(surface.middle(a, b), surface.middle(a, c))
        result += [(a, b, m), (a, m, c)]
    return result


class Model:
    def __init__(self, surface, faces, layers):
        self.layers = layers
        self.nodes, self.ids = [], {}
        self.surface = surface
        self.elements = []
        for face in faces:
            a, b, c = face
            corners = [a, b, c]
            sides = [surface.middle(a, b), surface.middle(b, c), surface.middle(c, a)]
            for layer in range(layers):
                low, mid, high = 2 * layer, 2 * layer + 1, 2 * layer + 2
                self.elements.append((layer == layers - 1,
                                      [self.node(k, low) for k in corners] + [self.node(k, high) for k in corners] +
                                      [self.node(k, low) for k in sides] + [self.node(k, high) for k in sides] +
                                      [self.node(k, mid) for k in corners]))
        self.faces = faces

    def node(self, vertex, station):
        """Node at the limit of a vertex, station 0 .. 2 layers from the inner to the outer face."""
        if (vertex, station) not in self.ids:
            p, n = self.surface.limit(vertex)
            offset = THICKNESS * (station / (2.0 * self.layers) - 0.5)
            q = add((1, p), (offset, n))
            self.nodes.append(q)
            self.ids[vertex, station] = len(self.nodes)
        return self.ids[vertex, station]

    def first_touch(self):
        """y of the finger's centre when it meets the outer face, quadratic triangles sampled at 60 x 60 / 2
        points each: to 1e-3 of a thousandth of its radius."""
        best = -1e9
        top = 2 * self.layers
        for face in self.faces:
            p = [self.nodes[self.node(k, top) - 1] for k in face]
            if p[0][1] < 0 or all(math.hypot(q[0] - AXIS[0], q[2] - AXIS[1]) > 0.75 * FINGER for q in p):
                continue
            p += [self.nodes[self.node(self.surface.middle(face[i], face[(i + 1) % 3]), top) - 1] for i in range(3)]
            n = 60
            for i in range(n + 1):
                for j in range(n + 1 - i):
                    s, t = i / float(n), j / float(n)
                    r = 1 - s - t
                    q = add(*zip((r * (2 * r - 1), s * (2 * s - 1), t * (2 * t - 1), 4 * r * s, 4 * s * t, 4 * t * r), p))
                    d2 = (q[0] - AXIS[0]) ** 2 + (q[2] - AXIS[1]) ** 2
                    if d2 < FINGER ** 2:
                        best = max(best, q[1] + math.sqrt(FINGER ** 2 - d2))
        return best


def finger(centre_y, cells, first_node):
    """A patch of a sphere, one layer of C3D20, its face 1 towards -y. Half angle 65 degrees along the axes."""
    nodes, ids, elements = [], {}, []
    limit = math.radians(65)

    def node(i, j, k):
        if (i, j, k) not in ids:
            s, t = (math.tan(limit * (v / float(cells) - 1)) for v in (i, j))
            d = unit((s, -1.0, t))
            r = FINGER * (1 - 0.1 * k)
            nodes.append((AXIS[0] + r * d[0], centre_y + r * d[1], AXIS[1] + r * d[2]))
            ids[i, j, k] = first_node + len(nodes) - 1
        return ids[i, j, k]

    for i in range(0, 2 * cells, 2):
        for j in range(0, 2 * cells, 2):
            # Right-handed about +y, from the contact face (k = 0) into the sphere.
            ring = [(i, j), (i, j + 2), (i + 2, j + 2), (i + 2, j)]
            sides = [(i, j + 1), (i + 1, j + 2), (i + 2, j + 1), (i + 1, j)]
            order = ([(p, 0) for p in ring] + [(p, 2) for p in ring] + [(p, 0) for p in sides] +
                     [(p, 2) for p in sides] + [(p, 1) for p in ring])
            elements.append([node(p[0], p[1], k) for p, k in order])
    return nodes, elements


def write_deck(path, model, centre_y, held, turn, arguments):
    out = ["*HEADING", "duck, mm N MPa", "*NODE, NSET=NALL"]
    for k, p in enumerate(model.nodes, 1):
        out.append("%d, %.12g, %.12g, %.12g" % ((k,) + p))
    tip_nodes, tip = finger(centre_y, arguments.finger_cells, len(model.nodes) + 1)
    out.append("*NODE, NSET=RIGID")
    for k, p in enumerate(tip_nodes, len(model.nodes) + 1):
        out.append("%d, %.12g, %.12g, %.12g" % ((k,) + p))
    number, slave, master = 0, [], []
    out.append("*ELEMENT, TYPE=C3D15, ELSET=WALL")
    for outer, e in model.elements:
        number += 1
        out.append("%d, " % number + ", ".join(map(str, e)))
        p = [model.nodes[k - 1] for k in e[3:6]]
        if outer and p[0][1] > 0 and any(math.hypot(q[0] - AXIS[0], q[2] - AXIS[1]) < 1.3 * FINGER for q in p):
            slave.append(number)
    out.append("*ELEMENT, TYPE=C3D20R, ELSET=FINGER")
    for e in tip:
        number += 1
        out.append("%d, " % number + ", ".join(map(str, e[:15])) + ",\n" + ", ".join(map(str, e[15:])))
        master.append(number)
    top = 2 * model.layers
    plane = [k for k, p in enumerate(model.nodes, 1) if abs(p[1]) < 1e-9]
    outer = sorted(model.ids[v, s] for v, s in model.ids if s == top)
    for name, ids in (("PLANE", plane), ("OUTER", outer)):
        out.append("*NSET, NSET=" + name)
        out.extend("%d," % k for k in ids)
    out.append("*SURFACE, NAME=SLAVE, TYPE=ELEMENT")
    out.extend("%d, S2" % e for e in slave)
    out.append("*SURFACE, NAME=MASTER, TYPE=ELEMENT")
    out.extend("%d, S1" % e for e in master)
    out += ["*MATERIAL, NAME=RUBBER", "*HYPERELASTIC, NEO HOOKE",
            "%.12g, %.12g" % (YOUNG / (4 * (1 + POISSON)), 6 * (1 - 2 * POISSON) / YOUNG),
            "*MATERIAL, NAME=STIFF", "*ELASTIC", "%.12g, 0.3" % (1000 * YOUNG),
            "*SOLID SECTION, ELSET=WALL, MATERIAL=RUBBER", "*SOLID SECTION, ELSET=FINGER, MATERIAL=STIFF",
            "*SURFACE INTERACTION, NAME=TOUCH", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR",
            "%.12g" % arguments.stiffness,
            "*CONTACT PAIR, INTERACTION=TOUCH, TYPE=SURFACE TO SURFACE", "SLAVE, MASTER",
            "*BOUNDARY", "PLANE, 2, 2", "RIGID, 1, 1", "RIGID, 3, 3",
            "%d, 1, 1" % held, "%d, 3, 3" % held, "%d, %d, %d" % (turn[0], turn[1], turn[1])]
    # A step for each state: only at the end of a step has ccx closed what the surfaces are apart at its start.
    for travel in TRAVELS:
        out += ["*STEP, NLGEOM, INC=2000", "*STATIC", "0.1, 1., 1e-6, 0.25",
                "*BOUNDARY", "RIGID, 2, 2, %.12g" % -travel]
        for name, what in (("OUTER", "U"), ("RIGID", "RF"), ("PLANE", "RF")):
            out += ["*NODE PRINT, NSET=%s, FREQUENCY=2000" % name + (", TOTALS=ONLY" if what == "RF" else ""), what]
        out.append("*END STEP")
    with open(path, "w") as f:
        f.write("\n".join(out) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--work", required=True, help="folder for ccx")
    parser.add_argument("--out", help="folder for the results; none: nothing is written")
    parser.add_argument("--control", default=os.path.join(HERE, "..", "duck_2562.obj"))
    parser.add_argument("--global", dest="refine_all", type=int, default=0, help="steps of refinement everywhere")
    parser.add_argument("--local", type=int, default=1, help="further ones near the finger")
    parser.add_argument("--layers", type=int, default=1)
    parser.add_argument("--finger-cells", dest="finger_cells", type=int, default=24)
    parser.add_argument("--stiffness", type=float, default=400.0, help="of the contact, MPa/mm")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--job", default="duck")
    arguments = parser.parse_args()
    os.makedirs(arguments.work, exist_ok=True)

    control, triangles = read_obj(arguments.control)
    surface = LoopSurface(control, triangles, arguments.refine_all + arguments.local + (1 if arguments.local else 2))
    faces = halve(surface, surface.level_faces[arguments.refine_all])
    for k in range(arguments.local):
        faces = refine(surface, faces, 12.0 / 2 ** k)
    model = Model(surface, faces, arguments.layers)
    # On y = 0 exactly: the masks leave rounding.
    model.nodes = [(p[0], 0.0 if abs(p[1]) < 1e-9 else p[1], p[2]) for p in model.nodes]
    middle = arguments.layers          # station of the middle surface
    used = set(v for face in faces for v in face)
    touched = min((v for v in used if model.nodes[model.ids[v, middle] - 1][1] > 0),
                  key=lambda v: math.hypot(model.nodes[model.ids[v, middle] - 1][0] - AXIS[0],
                                           model.nodes[model.ids[v, middle] - 1][2] - AXIS[1]))
    far = max(used, key=lambda v: abs(model.nodes[model.ids[v, middle] - 1][0] - AXIS[0]))
    centre = model.first_touch()
    print("%d elements, %d nodes; finger touches with its centre at y = %.6f mm; held: vertex %d, turn: %d" %
          (len(model.elements), len(model.nodes), centre, touched, far), flush=True)
    # The fingers press along one line, about which nothing else holds the duck: z of one more node.
    write_deck(os.path.join(arguments.work, arguments.job + ".inp"), model, centre, model.ids[touched, middle],
               (model.ids[far, middle], 3), arguments)
    seconds = ccx_job.run(arguments.job, arguments.work, arguments.threads)
    print("%.0f s, %d increments, %d iterations" % ((seconds,) + ccx_job.increments(arguments.job, arguments.work)))
    write_results(model, control, centre, ccx_job.read_dat(arguments.job, arguments.work), arguments)


def write_results(model, control, centre, blocks, arguments):
    top = 2 * model.layers
    mirror_of = {}
    place = {tuple(round(x, 6) + 0.0 for x in p): k for k, p in enumerate(control)}
    for k, p in enumerate(control):
        if p[1] < -1e-9:
            mirror_of[k] = place[round(p[0], 6) + 0.0, round(-p[1], 6) + 0.0, round(p[2], 6) + 0.0]
    rows = []
    for step, travel in enumerate(TRAVELS, 1):
        found = {(b[0], b[1]): b for b in blocks if abs(b[2] - step) < 1e-6}
        u = found["displacements", "OUTER"][3]
        force = -found["total force", "RIGID"][4][1]
        plane = found["total force", "PLANE"][4][1]
        rest, moved = [], []
        for k in range(len(control)):
            own = mirror_of.get(k, k)
            sign = -1 if k in mirror_of else 1
            node = model.ids[own, top]
            p, d = model.nodes[node - 1], u[node]
            rest.append((p[0], sign * p[1], p[2]))
            moved.append((p[0] + d[0], sign * (p[1] + d[1]), p[2] + d[2]))
        # The turn about the fingers' line is free: the one that brings the points nearest to rest.
        sine = cosine = 0.0
        for p, q in zip(rest, moved):
            a, b = (p[0] - AXIS[0], p[2] - AXIS[1]), (q[0] - AXIS[0], q[2] - AXIS[1])
            cosine += a[0] * b[0] + a[1] * b[1]
            sine += b[0] * a[1] - b[1] * a[0]
        angle = math.atan2(sine, cosine)
        c, s = math.cos(angle), math.sin(angle)
        turned = [(AXIS[0] + c * (q[0] - AXIS[0]) - s * (q[2] - AXIS[1]), q[1],
                   AXIS[1] + s * (q[0] - AXIS[0]) + c * (q[2] - AXIS[1])) for q in moved]
        # Of the nodes of the outer face into the finger.
        centre_now = (AXIS[0], centre - travel, AXIS[1])
        penetration = FINGER - min(math.dist(centre_now, add((1, model.nodes[k - 1]), (1, d))) for k, d in u.items())
        rows.append({"travel": travel / 1000.0, "force": float("%.6g" % force),
                     "penetration": float("%.3g" % (penetration / 1000.0))})
        print("travel %g mm: force %.6f N, on the plane y = 0 %.6f N, penetration %.2e mm, turned by %.2e" %
              (travel, force, plane, penetration, angle))
        if arguments.out:
            os.makedirs(arguments.out, exist_ok=True)
            with open(os.path.join(arguments.out, "duck_%gmm.csv" % travel), "w") as f:
                f.write("# Bath duck between two rigid spheres of radius 0.008 m, CalculiX 2.20, C3D15; m, N, Pa.\n"
                        "# Outer face at the vertices of %s, in their order. Truth: E 2e6, nu 0.45 "
                        "(neo-Hookean, initial moduli), thickness 0.0015\n"
                        "# Each finger has travelled %g from first touch; its force is %.6g N.\nx,y,z,ux,uy,uz\n" %
                        (os.path.basename(arguments.control), travel / 1000.0, force))
                for p, q in zip(rest, turned):
                    f.write(",".join("%.7g" % (x / 1000.0) for x in p) + "," +
                            ",".join("%.6g" % ((b - a) / 1000.0 + 0.0) for a, b in zip(p, q)) + "\n")
    if arguments.out:
        data = {"units": "m, N, Pa", "solver": "CalculiX 2.20", "young_modulus": 2.0e6, "poisson_ratio": 0.45,
                "thickness": 0.0015, "finger_radius": 0.008,
                "mesh": "C3D15, %d elements, %d nodes of the half y >= 0" % (len(model.elements), len(model.nodes)),
                "contact_stiffness": 1e9 * arguments.stiffness}
        with open(os.path.join(arguments.out, "duck.json"), "w") as f:
            text = json.dumps(data, indent=1)[:-2]
            f.write(text + ',\n "results": [\n  ' + ",\n  ".join(json.dumps(r) for r in rows) + "\n ]\n}\n")


if __name__ == "__main__":
    main()
