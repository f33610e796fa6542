#!/usr/bin/env python3
"""Makes strip_hole.obj: a strip with a hole, whose vertices are points of the middle surface.

    python3 strip_hole_mesh.py > strip_hole.obj       (12 cells across; an argument makes others)

Python 3 standard library only. In mm; the strip lies in z = 0.

A lattice of 4 n x n cells; in a square around the hole, rays from the circle to its sides take the
place of the lattice, with layers that are thinnest at the hole. The mesh is its own mirror image at
x = 40, diagonals too, so that loads on the two ends are in balance to rounding. Vertices have six
neighbours and three triangles on a boundary, where the limit surface then ends on the straight
sides, all but those in the corners of the square and, on each long side and on the hole, those at
x = 40: near these the rim of the surface waves by up to a twentieth of a cell.
"""
import math
import sys

LENGTH, WIDTH, RADIUS, CENTRE = 80.0, 20.05, 4.0, (40.0, 10.0)


def main():
    n = int(sys.argv[1]) if len(sys.argv) > 1 else 12  # cells across the strip; even
    rim = max(1, n // 8)  # rows between the square and the long sides
    side = n - 2 * rim  # cells of a side of the square
    layers = (n + 1) // 2
    first = 2 * n - side // 2  # its first column
    vertices, index = [], {}

    def vertex(key, x, y):
        if key not in index:
            index[key] = len(vertices) + 1
            vertices.append((x, y))
        return index[key]

    def place(i, j):
        return LENGTH * i / (4 * n), WIDTH * j / n

    def lattice(i, j):
        return vertex(("lattice", i, j), *place(i, j))

    # Ray s in 0 .. 4 side, counterclockwise from the lower left corner of the square.
    def outer(s):
        which, t = divmod(s, side)
        return [(first + t, rim), (first + side, rim + t), (first + side - t, rim + side),
                (first, rim + side - t)][which]

    # Layers grow outwards by a constant factor, the last three times the first.
    growth = 3.0 ** (1.0 / (layers - 1))
    part = [(growth ** j - 1.0) / (growth ** layers - 1.0) for j in range(layers + 1)]

    def ray(s, j):
        s %= 4 * side
        if j == layers:
            return lattice(*outer(s))
        angle = 0.5 * math.pi * (s / side - 1.5)
        c = (CENTRE[0] + RADIUS * math.cos(angle), CENTRE[1] + RADIUS * math.sin(angle))
        b = place(*outer(s))
        return vertex(("ray", s, j), *(c[k] + part[j] * (b[k] - c[k]) for k in range(2)))

    triangles = []

    def quadrilateral(a, b, c, d, right):  # counterclockwise
        triangles.extend([(a, b, c), (a, c, d)] if right else [(a, b, d), (b, c, d)])

    for i in range(4 * n):
        for j in range(n):
            if not (first <= i < first + side and rim <= j < rim + side):
                quadrilateral(lattice(i, j), lattice(i + 1, j), lattice(i + 1, j + 1),
                              lattice(i, j + 1), i >= 2 * n)
    for s in range(4 * side):
        for j in range(layers):
            quadrilateral(ray(s, j), ray(s, j + 1), ray(s + 1, j + 1), ray(s + 1, j),
                          side <= 2 * s < 5 * side)
    print("# Strip 80 x 20.05 mm with a hole of radius 4 mm at (40, 10); made by strip_hole_mesh.py,")
    print("# %d cells across: %d vertices, %d triangles." % (n, len(vertices), len(triangles)))
    for x, y in vertices:
        print("v %.12g %.12g 0" % (x, y))
    for t in triangles:
        print("f %d %d %d" % t)


main()
