"""A machined part as a dense triangle mesh: a gear of 16 teeth with a hole. docs/your-own-mesh.md shows
what `plait remesh` makes of it.

    python3 gear.py gear.ply
"""
import math
import sys

TEETH, PIECES, ROWS, RINGS = 16, 6, 12, 12
HOLE, HEIGHT = 0.7, 0.8
# Of one tooth: where, in parts of the tooth, and how far from the axis.
OUTLINE = [(0.0, 1.6), (0.3, 1.6), (0.42, 2.0), (0.78, 2.0), (0.9, 1.6), (1.0, 1.6)]


def outline():
    for tooth in range(TEETH):
        for (part, radius), (next_part, next_radius) in zip(OUTLINE, OUTLINE[1:]):
            for piece in range(PIECES):
                share = piece / PIECES
                angle = 2 * math.pi / TEETH * (tooth + part + (next_part - part) * share)
                at = radius + (next_radius - radius) * share
                yield at * math.cos(angle), at * math.sin(angle)


def main(path):
    around = list(outline())
    count = len(around)
    hole = [(HOLE * math.cos(2 * math.pi * i / count), HOLE * math.sin(2 * math.pi * i / count))
            for i in range(count)]
    points, numbers, faces = [], {}, []

    def vertex(i, ring, row):
        """On the outline (ring 0), at the hole (the last ring), or between them, at a height."""
        key = (i % count, ring, row)
        if key not in numbers:
            (x, y), (u, v), share = around[key[0]], hole[key[0]], ring / RINGS
            numbers[key] = len(points)
            points.append((x + (u - x) * share, y + (v - y) * share, HEIGHT * row / ROWS))
        return numbers[key]

    def square(a, b, c, d):
        faces.extend([(a, b, c), (a, c, d)])

    for i in range(count):
        for row in range(ROWS):
            square(vertex(i, 0, row), vertex(i + 1, 0, row), vertex(i + 1, 0, row + 1), vertex(i, 0, row + 1))
            square(vertex(i + 1, RINGS, row), vertex(i, RINGS, row), vertex(i, RINGS, row + 1),
                   vertex(i + 1, RINGS, row + 1))
        for ring in range(RINGS):
            square(vertex(i + 1, ring, 0), vertex(i, ring, 0), vertex(i, ring + 1, 0), vertex(i + 1, ring + 1, 0))
            square(vertex(i, ring, ROWS), vertex(i + 1, ring, ROWS), vertex(i + 1, ring + 1, ROWS),
                   vertex(i, ring + 1, ROWS))
    with open(path, "w") as file:
        file.write(f"ply\nformat ascii 1.0\nelement vertex {len(points)}\nproperty double x\nproperty double y\n"
                   f"property double z\nelement face {len(faces)}\nproperty list uchar int vertex_indices\n"
                   "end_header\n")
        file.writelines(f"{x!r} {y!r} {z!r}\n" for x, y, z in points)
        file.writelines(f"3 {a} {b} {c}\n" for a, b, c in faces)


main(sys.argv[1])
