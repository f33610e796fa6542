#!/usr/bin/env python3
"""A ball between two rigid spheres, from CalculiX: solid elements, neo-Hookean, axisymmetric.

Units mm, N, MPa. See README.md here for what comes out. Python 3 standard library and ccx only.

  ball_deck.py --work=DIR [--out=DIR] [--mesh=0|1|2] [--case=ball|gas|all] [--element=CAX8R|CAX8]
               [--travels=1,4,8] [--stiffness=5000]

The half z >= 0 is modelled; ccx's axisymmetric elements have r along x and the axis along y, which
is z in the results. The ball's wall are CAX8R elements (expanded by ccx to a wedge of two degrees
of C3D20R). The finger is a layer of the same elements whose nodes all have the same prescribed
displacement, and so is rigid; its force is the sum of the reactions there.
"""
import argparse
import json
import math
import os
import sys

sys.dont_write_bytecode = True
import ccx_job

RADIUS = 31.25    # of the middle surface
THICKNESS = 2.5
YOUNG = 14.2
POISSON = 0.49
FINGER = 2.0      # radius of the finger
AMBIENT = 0.101325
GAUGE = 0.06      # at the volume that the inner face encloses at rest
TRAVELS = [1, 2, 3, 4, 5, 6, 8]
GAS_TRAVELS = [2, 4, 6]
GAS_GUESSES = {2: 0.053635, 4: 0.054155, 6: 0.05498}  # of the gauge pressure there: saves runs
OUTER = RADIUS + THICKNESS / 2
INNER = RADIUS - THICKNESS / 2

# Cells along the meridian of the half, cells through the wall, cells of the finger's quarter circle.
MESHES = [(60, 3, 20), (120, 6, 40), (240, 12, 80)]


class Ball:
    """The mesh: nodes[k] = (r, z), elements of 8 nodes, ids from 1."""

    def __init__(self, mesh, finger_pole):
        self.along, self.through, arc = MESHES[mesh]
        self.nodes, self.wall, self.finger = [], [], []
        # Equal steps of q, angle = 90 degrees (a q + (1 - a) q^2): cells at the pole are a tenth of
        # those of an even mesh.
        a = 0.1
        self.shell_ids = self.grid(self.along, self.through, self.wall,
                                   lambda q: math.pi / 2 * (a * q + (1 - a) * q * q),
                                   lambda s: INNER + s * THICKNESS, 0.0, 1.0)
        # The finger's lower half circle, from its tip outwards.
        centre = finger_pole + FINGER
        self.finger_ids = self.grid(arc, 1, self.finger, lambda q: math.pi / 2 * q,
                                    lambda s: FINGER * (1 - 0.25 * s), centre, -1.0)

    def grid(self, m, n, elements, angle, radius, centre, side):
        """Cells (i, j), i along the meridian, j with the radius function; side -1 is below."""
        ids = {}
        for i in range(2 * m + 1):
            for j in range(2 * n + 1):
                if i % 2 and j % 2:
                    continue
                t, r = angle(i / (2.0 * m)), radius(j / (2.0 * n))
                x = 0.0 if i == 0 else r * math.sin(t)
                y = 0.0 if i == 2 * m and centre == 0.0 else centre + side * r * math.cos(t)
                self.nodes.append((x, y))
                ids[i, j] = len(self.nodes)
        for i in range(0, 2 * m, 2):
            for j in range(0, 2 * n, 2):
                # Counterclockwise in the plane of r and z. (The finger's radius falls with j.)
                corners = [(i, j), (i + 2, j), (i + 2, j + 2), (i, j + 2)]
                sides = [(i + 1, j), (i + 2, j + 1), (i + 1, j + 2), (i, j + 1)]
                elements.append((j, [ids[k] for k in corners + sides]))
        return ids

    def face(self, j):
        """Ids along the meridian of the inner (j = 0) or outer (j = 2 through) face."""
        return [self.shell_ids[i, j] for i in range(2 * self.along + 1)]


def write_deck(path, ball, steps, stiffness, element):
    """steps: list of (gauge pressure, travel of the finger)."""
    out = ["*HEADING", "ball, mm N MPa", "*NODE, NSET=NALL"]
    for k, (x, y) in enumerate(ball.nodes, 1):
        out.append("%d, %.12g, %.12g, 0" % (k, x, y))
    top = 2 * ball.through - 2
    inner_elements, outer_elements, tip_elements = [], [], []
    number = 0
    for name, elements in (("WALL", ball.wall), ("FINGER", ball.finger)):
        out.append("*ELEMENT, TYPE=%s, ELSET=%s" % (element, name))
        for j, corners in elements:
            number += 1
            out.append("%d, " % number + ", ".join(map(str, corners)))
            if name == "FINGER":
                tip_elements.append(number)
            else:
                if j == 0:
                    inner_elements.append(number)
                if j == top:
                    outer_elements.append(number)

    def node_set(name, ids):
        out.append("*NSET, NSET=" + name)
        out.extend("%d," % k for k in ids)

    node_set("AXIS", [k for (i, j), k in ball.shell_ids.items() if i == 0])
    node_set("EQUATOR", [k for (i, j), k in ball.shell_ids.items() if i == 2 * ball.along])
    node_set("RIGID", sorted(ball.finger_ids.values()))
    node_set("OUTER", ball.face(2 * ball.through))
    node_set("INNER", ball.face(0))
    # Lower finger arc: j = 0 is at its radius, face 1. Outer face of the wall: face 3.
    out.append("*SURFACE, NAME=SLAVE, TYPE=ELEMENT")
    out.extend("%d, S3" % e for e in outer_elements)
    out.append("*SURFACE, NAME=MASTER, TYPE=ELEMENT")
    out.extend("%d, S1" % e for e in tip_elements)
    out.append("*ELSET, ELSET=INSIDE")
    out.extend("%d," % e for e in inner_elements)
    out += ["*MATERIAL, NAME=RUBBER", "*HYPERELASTIC, NEO HOOKE",
            "%.12g, %.12g" % (YOUNG / (4 * (1 + POISSON)), 6 * (1 - 2 * POISSON) / YOUNG),
            "*MATERIAL, NAME=STIFF", "*ELASTIC", "%.12g, 0.3" % (1000 * YOUNG),
            "*SOLID SECTION, ELSET=WALL, MATERIAL=RUBBER",
            "*SOLID SECTION, ELSET=FINGER, MATERIAL=STIFF",
            "*SURFACE INTERACTION, NAME=TOUCH",
            "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR", "%.12g" % stiffness,
            "*CONTACT PAIR, INTERACTION=TOUCH, TYPE=SURFACE TO SURFACE", "SLAVE, MASTER",
            "*BOUNDARY", "AXIS, 1, 1", "EQUATOR, 2, 2", "RIGID, 1, 1"]
    # A step for each state: only at the end of a step has ccx closed what the surfaces are apart at its start.
    for pressure, travel in steps:
        out += ["*STEP, NLGEOM, INC=2000", "*STATIC", "0.05, 1., 1e-7, 0.125",
                "*BOUNDARY", "RIGID, 2, 2, %.12g" % -travel]
        if any(p for p, _ in steps):
            out += ["*DLOAD", "INSIDE, P1, %.12g" % pressure]
        for name, what in (("OUTER", "U"), ("INNER", "U"), ("RIGID", "RF"), ("EQUATOR", "RF")):
            out += ["*NODE PRINT, NSET=%s, FREQUENCY=2000" % name +
                    (", TOTALS=ONLY" if what == "RF" else ""), what]
        out.append("*END STEP")
    with open(path, "w") as f:
        f.write("\n".join(out) + "\n")


def run(arguments, job, finger_pole, steps):
    """Per step: displacements of both faces, force on the finger, the same from the equator."""
    work = arguments.work
    ball = Ball(arguments.mesh, finger_pole)
    write_deck(os.path.join(work, job + ".inp"), ball, steps, arguments.stiffness, arguments.element)
    seconds = ccx_job.run(job, work)
    blocks = ccx_job.read_dat(job, work)
    count = ccx_job.increments(job, work)
    print("%s: %d nodes, %.0f s, %d increments, %d iterations" %
          (job, len(ball.nodes), seconds, count[0], count[1]), flush=True)
    results = []
    for k, (pressure, travel) in enumerate(steps):
        found = {}
        for quantity, name, time, values, total in blocks:
            if abs(time - (k + 1)) < 1e-6:
                found[quantity, name] = total if quantity == "total force" else values
        faces = {}
        for name, j in (("OUTER", 2 * ball.through), ("INNER", 0)):
            u = found["displacements", name]
            faces[name] = [(ball.nodes[i - 1], u[i]) for i in ball.face(j)]
        # ccx gives the reactions of its wedge of two degrees.
        results.append({"pressure": pressure, "travel": travel, "faces": faces,
                        "force": -180 * found["total force", "RIGID"][1],
                        "equator": 180 * found["total force", "EQUATOR"][1],
                        "volume": volume(faces["INNER"]),
                        "tip": finger_pole - travel})
    return results


def volume(face):
    """That both halves of the deformed face enclose: 2 pi int r^2 dz over quadratic cells."""
    points = [(p[0] + u[0], p[1] + u[1]) for p, u in face]
    total = 0.0
    for k in range(0, len(points) - 2, 2):
        a, b, c = points[k:k + 3]
        for s, w in ((-math.sqrt(0.6), 5 / 9.0), (0.0, 8 / 9.0), (math.sqrt(0.6), 5 / 9.0)):
            shape = (s * (s - 1) / 2, 1 - s * s, s * (s + 1) / 2)
            slope = (s - 0.5, -2 * s, s + 0.5)
            r = sum(n * q[0] for n, q in zip(shape, (a, b, c)))
            dz = sum(n * q[1] for n, q in zip(slope, (a, b, c)))
            total -= 2 * math.pi * w * r * r * dz
    return total


def rest_volume(mesh):
    return volume([(Ball(mesh, 2 * OUTER).nodes[k - 1], (0, 0)) for k in Ball(mesh, 2 * OUTER).face(0)])


def write_profile(path, result, face, truth, what):
    """Corner nodes from the upper pole over the equator to the lower one, in the plane y = 0. Without
    those within 0.1 mm of the axis: hardly an area holds them, and they stray by some 0.01 mm."""
    half = result["faces"][face][6::2]
    lines = ["# Ball between two rigid spheres of radius %g mm, CalculiX 2.20; mm, N, MPa." % FINGER,
             "# %s face. Truth: %s" % (face.capitalize(), truth), "# " + what, "x,y,z,ux,uy,uz"]
    for (x, z), u in half + [((x, -z), (u[0], -u[1])) for (x, z), u in reversed(half[:-1])]:
        values = (x, 0.0, z, u[0], 0.0, u[1])
        lines.append(",".join("%.7g" % (v + 0.0) for v in values))
    with open(path, "w") as f:
        f.write("\n".join(lines) + "\n")


def truth_text(gas):
    text = ("E %g, nu %g (neo-Hookean, initial moduli), thickness %g, middle radius %g" %
            (YOUNG, POISSON, THICKNESS, RADIUS))
    return text + (", gas with gauge pressure %g at rest, ambient %g" % (GAUGE, AMBIENT) if gas else "")


def write_json(path, results, gas, arguments):
    mesh = arguments.mesh
    cells = "%d x %d" % MESHES[mesh][:2]
    data = {"units": "mm, N, MPa", "solver": "CalculiX 2.20",
            "young_modulus": YOUNG, "poisson_ratio": POISSON, "thickness": THICKNESS,
            "radius": RADIUS, "finger_radius": FINGER, "mesh": "%s, %s cells of the half" % (arguments.element, cells),
            "contact_stiffness": arguments.stiffness}
    if gas:
        data.update({"ambient_pressure": AMBIENT, "gauge_pressure_at_rest": GAUGE,
                     "rest_volume": float("%.7g" % rest_volume(mesh))})
    rows = []
    for r in results:
        # Largest depth of a corner node in the finger, and how much thinner the wall is, beside the pole.
        depth = max(FINGER - math.hypot(p[0] + u[0], p[1] + u[1] - r["tip"] - FINGER)
                    for p, u in r["faces"]["OUTER"][6::2])
        thinning = r["faces"]["INNER"][6][1][1] - r["faces"]["OUTER"][6][1][1]
        row = {"travel": r["travel"], "force": float("%.6g" % r["force"]),
               "penetration": float("%.2g" % (depth if r["travel"] else 0.0)),
               "thinning_at_pole": float("%.4g" % thinning)}
        if gas:
            row.update({"gauge_pressure": float("%.7g" % r["pressure"]),
                        "volume_ratio": float("%.7g" % (r["volume"] / rest_volume(mesh)))})
        rows.append(row)
    data["results"] = rows
    with open(path, "w") as f:
        # A line for each result.
        text = json.dumps({k: v for k, v in data.items() if k != "results"}, indent=1)[:-2]
        f.write(text + ',\n "results": [\n  ' + ",\n  ".join(json.dumps(r) for r in rows) + "\n ]\n}\n")


def check_balance(result):
    """Reaction at the equator = finger's force + pressure on the opening of the inner face."""
    inner = result["faces"]["INNER"][-1]
    opening = math.pi * (inner[0][0] + inner[1][0]) ** 2
    error = result["equator"] - (result["force"] - result["pressure"] * opening)
    print("travel %g: force %.5f, gauge %.6f, volume %.2f, left in equilibrium %.1e" %
          (result["travel"], result["force"], result["pressure"], result["volume"], error))


def ball(arguments):
    travels = [float(t) for t in arguments.travels.split(",")] if arguments.travels else TRAVELS
    results = run(arguments, "ball_%d" % arguments.mesh, OUTER, [(0.0, t) for t in travels])
    for r in results:
        check_balance(r)
    return results


def gas(arguments):
    """Each state is a run of its own: inflation, then one step of contact, which ccx does not always get
    through from state to state. Its pressure is iterated until p_abs V is what it was at rest."""
    mesh = arguments.mesh
    amount = (AMBIENT + GAUGE) * rest_volume(mesh)

    def iterate(job, pole, inflated, travel, pressure):
        # Secants of amount / V(p) - ambient - p; its slope is -1.13 to begin with.
        slope, before = -1.13, None
        for _ in range(8):
            first = [(inflated, 0.0)] if travel else []
            result = run(arguments, job, pole, first + [(pressure, travel)])[-1]
            miss = amount / result["volume"] - AMBIENT - pressure
            print("  gauge pressure off by %.1e" % (miss / pressure), flush=True)
            if abs(miss) < 1e-5 * pressure:
                check_balance(result)
                return result
            if before and abs(pressure - before[0]) > 1e-6:
                slope = (miss - before[1]) / (pressure - before[0])
            before = (pressure, miss)
            pressure -= miss / slope
        raise RuntimeError("the gas's pressure does not settle")

    results = [iterate("gas_%d_0" % mesh, OUTER + 10, 0.0, 0.0, GAUGE)]
    node, u = results[0]["faces"]["OUTER"][0]
    p = results[0]["pressure"]
    results[0]["force"] = 0.0
    for travel in GAS_TRAVELS:
        results.append(iterate("gas_%d_%g" % (mesh, travel), node[1] + u[1], p, travel,
                               GAS_GUESSES.get(travel, p)))
    return results


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--work", required=True, help="folder for ccx")
    parser.add_argument("--out", help="folder for the results; none: nothing is written")
    parser.add_argument("--mesh", type=int, default=1, choices=[0, 1, 2])
    parser.add_argument("--case", default="all", choices=["ball", "gas", "all"])
    parser.add_argument("--stiffness", type=float, default=5e3, help="of the contact, MPa/mm")
    parser.add_argument("--travels", help="of the ball without gas, such as 1,4,8")
    parser.add_argument("--finger_radius", type=float, default=FINGER)
    parser.add_argument("--element", default="CAX8R", choices=["CAX8R", "CAX8"])
    arguments = parser.parse_args()
    globals()["FINGER"] = arguments.finger_radius
    os.makedirs(arguments.work, exist_ok=True)
    # Files are named after the finger's radius where it is not the first one that was computed.
    ending = "" if FINGER == 2.0 else "_r%g" % FINGER
    for name, solve in (("ball" + ending, ball), ("ball%s_gas" % ending, gas)):
        if arguments.case not in ("all", "gas" if solve is gas else "ball"):
            continue
        results = solve(arguments)
        if not arguments.out:
            continue
        os.makedirs(arguments.out, exist_ok=True)
        is_gas = solve is gas
        for r in results:
            what = "Each finger has travelled %g mm from first touch; its force is %.6g N" % (r["travel"], r["force"])
            if is_gas:
                what += "; gauge pressure now %.7g" % r["pressure"]
            for face, end in (("OUTER", ""), ("INNER", "_inner")):
                write_profile(os.path.join(arguments.out, "%s_%gmm%s.csv" % (name, r["travel"], end)), r,
                              face, truth_text(is_gas), what + ".")
        write_json(os.path.join(arguments.out, name + ".json"), results, is_gas, arguments)


if __name__ == "__main__":
    main()
