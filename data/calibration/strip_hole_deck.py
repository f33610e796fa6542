#!/usr/bin/env python3
"""Makes strip_hole_exact.csv and strip_hole_noisy.csv: the displacements of a strip with a hole under
tension, plane stress, as CalculiX has them (ccx, elements CPS8), not Darboux.

    python3 strip_hole_deck.py [FOLDER]       (scratch folder for ccx; a temporary one without)

Python 3 standard library and ccx. Writes next to this file.

The strip is that of strip_hole.yaml: 80 x 20.05 mm, hole of radius 4 mm at (40, 10), 106.2629 N/mm^2
along x on both ends, E = 210000 N/mm^2, nu = 0.3. Quadrilaterals of eight nodes with their middle nodes
on the circle, 24 across the strip; three degrees of freedom are held in its lower corners, which is a
rigid motion and no force.

Thickness: ccx makes solid elements of CPS8, whose thickness changes where they contract, so that shear
across the thickness resists gradients of the stress. With 3.05 mm the hole's widening comes out 0.5 %
and the strip's lengthening 0.05 % smaller than with 0.02 mm, which is used here and is plane stress;
stresses are the same multiple of the loads. (A real strip has some of this stiffness.)

Points: POINTS nodes, drawn at random (SEED) from all those that a camera would see, 0.3 mm and more from
every edge. The noisy file has a rigid motion, MOTION, and normal errors of NOISE in both components.
"""
import math
import os
import random
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "solids"))
import ccx_job  # noqa: E402

LENGTH, WIDTH, RADIUS, CENTRE, THICKNESS = 80.0, 20.05, 4.0, (40.0, 10.0), 0.02
MODULUS, POISSON, TRACTION = 210000.0, 0.3, 106.2629
ACROSS, LAYERS, HALF = 24, 20, 10.0  # elements; half width of the part around the hole
NOISE, POINTS, SEED = 0.0005, 1600, 20241
MOTION = (0.02, 0.004, 2e-4)  # translation in mm, rotation about the origin in rad


class Mesh:
    """Quadrilaterals of eight nodes; nodes with the same name are one."""

    def __init__(self):
        self.nodes, self.index, self.elements = [], {}, []

    def node(self, x, y):
        key = (round(x, 7), round(y, 7))
        if key not in self.index:
            self.nodes.append((x, y))
            self.index[key] = len(self.nodes)
        return self.index[key]

    def block(self, n, m, position):
        """position(i / n, j / m); i, j may be half numbers."""
        for i in range(n):
            for j in range(m):
                at = lambda a, b: self.node(*position((i + a) / n, (j + b) / m))
                self.elements.append([at(0, 0), at(1, 0), at(1, 1), at(0, 1),
                                      at(.5, 0), at(1, .5), at(.5, 1), at(0, .5)])


def make_mesh():
    mesh = Mesh()
    left, right = CENTRE[0] - HALF, CENTRE[0] + HALF
    corners = [(left, 0.0), (right, 0.0), (right, WIDTH), (left, WIDTH)]
    for k in range(4):
        a, b = corners[k], corners[(k + 1) % 4]

        def position(t, r, a=a, b=b, k=k):
            # r = 0 on the circle; layers are thin there. t against the clock would turn them over.
            angle = 0.5 * math.pi * (k + 1 - t - 1.5)
            c = [CENTRE[0] + RADIUS * math.cos(angle), CENTRE[1] + RADIUS * math.sin(angle)]
            o = [b[i] + t * (a[i] - b[i]) for i in range(2)]
            r = (math.exp(1.6 * r) - 1) / (math.exp(1.6) - 1)
            return tuple(c[i] + r * (o[i] - c[i]) for i in range(2))

        mesh.block(ACROSS, LAYERS, position)
    along = 30
    mesh.block(along, ACROSS, lambda s, t: (left * s, WIDTH * t))
    mesh.block(along, ACROSS, lambda s, t: (right + (LENGTH - right) * s, WIDTH * t))
    return mesh


def deck(mesh):
    lines = ["*NODE, NSET=ALL"]
    lines += ["%d, %.12g, %.12g, 0" % (i + 1, x, y) for i, (x, y) in enumerate(mesh.nodes)]
    lines += ["*ELEMENT, TYPE=CPS8, ELSET=SHEET"]
    lines += ["%d, %s" % (e + 1, ", ".join(map(str, nodes))) for e, nodes in enumerate(mesh.elements)]
    lines += ["*MATERIAL, NAME=STEEL", "*ELASTIC", "%g, %g" % (MODULUS, POISSON),
              "*SOLID SECTION, ELSET=SHEET, MATERIAL=STEEL", "%g" % THICKNESS]
    first = mesh.node(0.0, 0.0)
    second = mesh.node(LENGTH, 0.0)
    lines += ["*BOUNDARY", "%d, 1, 2" % first, "%d, 2, 2" % second, "*STEP", "*STATIC", "*CLOAD"]
    forces = {}
    for nodes in mesh.elements:
        for side in range(4):
            edge = [nodes[side], nodes[4 + side], nodes[(side + 1) % 4]]
            for end, sign in ((0.0, -1.0), (LENGTH, 1.0)):
                if all(abs(mesh.nodes[k - 1][0] - end) < 1e-9 for k in edge):
                    whole = sign * TRACTION * THICKNESS * abs(
                        mesh.nodes[edge[0] - 1][1] - mesh.nodes[edge[2] - 1][1])
                    for k, part in zip(edge, (1 / 6.0, 4 / 6.0, 1 / 6.0)):
                        forces[k] = forces.get(k, 0.0) + part * whole
    lines += ["%d, 1, %.12g" % item for item in sorted(forces.items())]
    lines += ["*NODE PRINT, NSET=ALL", "U", "*END STEP", ""]
    return "\n".join(lines)


def write(name, comments, rows):
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)), name)
    with open(path, "w") as out:
        for line in comments:
            out.write("# %s\n" % line)
        out.write("x,y,ux,uy\n")
        for row in rows:
            out.write("%.5f,%.5f,%.8f,%.8f\n" % row)


def main():
    mesh = make_mesh()
    folder = sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp()
    with open(os.path.join(folder, "strip.inp"), "w") as out:
        out.write(deck(mesh))
    seconds = ccx_job.run("strip", folder)
    moved = [b for b in ccx_job.read_dat("strip", folder) if b[0] == "displacements"][-1][3]
    print("%d nodes, %d elements, %.1f s" % (len(mesh.nodes), len(mesh.elements), seconds))

    def seen(x, y):
        return (0.3 <= x <= LENGTH - 0.3 and 0.3 <= y <= WIDTH - 0.3 and
                math.hypot(x - CENTRE[0], y - CENTRE[1]) >= RADIUS + 0.3)

    chance = random.Random(SEED)
    # Weights by area, roughly: nodes are dense around the hole.
    candidates = [i for i, p in enumerate(mesh.nodes) if seen(*p)]
    # One node nearest to each random place.
    chosen, taken = [], set()
    while len(chosen) < POINTS:
        x, y = chance.uniform(0, LENGTH), chance.uniform(0, WIDTH)
        i = min(candidates, key=lambda k: (mesh.nodes[k][0] - x) ** 2 + (mesh.nodes[k][1] - y) ** 2)
        if i not in taken:
            taken.add(i)
            chosen.append(i)
    chosen.sort()
    exact, noisy = [], []
    for i in chosen:
        x, y = mesh.nodes[i]
        ux, uy = moved[i + 1][:2]
        exact.append((x, y, ux, uy))
        noisy.append((x, y, ux + MOTION[0] - MOTION[2] * y + chance.gauss(0.0, NOISE),
                      uy + MOTION[1] + MOTION[2] * x + chance.gauss(0.0, NOISE)))
    head = ["Strip with a hole under tension, plane stress, CalculiX CPS8; made by strip_hole_deck.py.",
            "mm; truth: E = 210000 N/mm^2, nu = 0.3."]
    write("strip_hole_exact.csv", head, exact)
    write("strip_hole_noisy.csv", head + [
        "Normal errors of %g mm (seed %d) and a rigid motion." % (NOISE, SEED)], noisy)


main()
