#!/usr/bin/env python3
"""Writes sphere.obj (radius 1) and head.obj (cm; a stand-in head and neck under the generated hair) beside itself."""
import math
import pathlib


def revolve(name, comment, profile, around, scale=(1.0, 1.0)):
    """A surface around z: rings of `around` vertices at (radius, z) of the profile, poles closed."""
    vertices, faces = [], []
    for r, z in profile:
        vertices += [(r * scale[0] * math.cos(2 * math.pi * k / around),
                      r * scale[1] * math.sin(2 * math.pi * k / around), z) for k in range(around)]
    vertices += [(0, 0, profile[0][1]), (0, 0, profile[-1][1])]
    low, high = len(vertices) - 1, len(vertices)
    for ring in range(len(profile) - 1):
        for k in range(around):
            a, b = ring * around + k + 1, ring * around + (k + 1) % around + 1
            faces.append((a, b, b + around, a + around))
    for k in range(around):
        a, b = k + 1, (k + 1) % around + 1
        top = (len(profile) - 1) * around
        faces += [(low, b, a), (high, top + a, top + b)]
    normals = [[0.0, 0.0, 0.0] for _ in vertices]  # of the faces around each vertex, by area
    for face in faces:
        corners = [vertices[i - 1] for i in face]
        (ax, ay, az), (bx, by, bz) = ([q - p for p, q in zip(corners[0], c)] for c in (corners[1], corners[2]))
        if len(face) == 4:
            ax, ay, az = (q - p for p, q in zip(corners[0], corners[2]))
            bx, by, bz = (q - p for p, q in zip(corners[1], corners[3]))
        area = (ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx)
        for i in face:
            normals[i - 1] = [n + a for n, a in zip(normals[i - 1], area)]
    normals = [tuple(c / math.hypot(*n) for c in n) for n in normals]
    lines = [f"# {comment}; written by make_meshes.py"]
    lines += ["v %.4g %.4g %.4g" % v for v in vertices]
    lines += ["vn %.4g %.4g %.4g" % n for n in normals]
    lines += ["f " + " ".join(f"{i}//{i}" for i in f) for f in faces]
    (pathlib.Path(__file__).parent / name).write_text("\n".join(lines) + "\n")


rings = [math.pi * (k + 0.5) / 16 for k in range(16)]
revolve("sphere.obj", "unit sphere, z up", [(math.sin(t), -math.cos(t)) for t in rings], 28)

# The ellipsoid of the generators' scalp, a little smaller, on a neck.
head = [(math.sin(t), -8.8 * math.cos(t)) for t in rings if math.cos(t) < 0.72]
revolve("head.obj", "head and neck, cm, face towards +y, z up", [(0.62, -17.0), (0.6, -9.0)] + head, 28, (7.2, 9.0))
