#!/usr/bin/env python3
"""Writes sphere.obj (radius 1), head.obj (cm; a stand-in head and neck under the generated hair) and skin.png, its
color, beside itself."""
import math
import pathlib
import random
import struct
import zlib


def revolve(name, comment, profile, around, scale=(1.0, 1.0)):
    """A surface around z: rings of `around` vertices at (radius, z) of the profile, poles closed. Texture coordinates
    go around once (u, from +x by +y) and from the lowest ring to the highest (v)."""
    vertices, faces, corners_uv = [], [], []
    for r, z in profile:
        vertices += [(r * scale[0] * math.cos(2 * math.pi * k / around),
                      r * scale[1] * math.sin(2 * math.pi * k / around), z) for k in range(around)]
    vertices += [(0, 0, profile[0][1]), (0, 0, profile[-1][1])]
    low, high = len(vertices) - 1, len(vertices)
    lowest, highest = profile[0][1], profile[-1][1]
    uvs = [(k / around, (z - lowest) / (highest - lowest)) for _, z in profile for k in range(around + 1)]
    uv_at = lambda ring, k: ring * (around + 1) + k + 1
    for ring in range(len(profile) - 1):
        for k in range(around):
            a, b = ring * around + k + 1, ring * around + (k + 1) % around + 1
            faces.append((a, b, b + around, a + around))
            corners_uv.append((uv_at(ring, k), uv_at(ring, k + 1), uv_at(ring + 1, k + 1), uv_at(ring + 1, k)))
    for k in range(around):
        a, b = k + 1, (k + 1) % around + 1
        top = (len(profile) - 1) * around
        faces += [(low, b, a), (high, top + a, top + b)]
        last = len(profile) - 1  # the poles have the coordinates of a corner beside them
        corners_uv += [(uv_at(0, k), uv_at(0, k + 1), uv_at(0, k)), (uv_at(last, k), uv_at(last, k), uv_at(last, k + 1))]
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
    lines += ["vt %.4g %.4g" % uv for uv in uvs]
    lines += ["vn %.4g %.4g %.4g" % n for n in normals]
    lines += ["f " + " ".join(f"{i}/{t}/{i}" for i, t in zip(f, uv)) for f, uv in zip(faces, corners_uv)]
    (pathlib.Path(__file__).parent / name).write_text("\n".join(lines) + "\n")


rings = [math.pi * (k + 0.5) / 16 for k in range(16)]
revolve("sphere.obj", "unit sphere, z up", [(math.sin(t), -math.cos(t)) for t in rings], 28)

# The ellipsoid of the generators' scalp, a little smaller, on a neck.
head = [(math.sin(t), -8.8 * math.cos(t)) for t in rings if math.cos(t) < 0.72]
revolve("head.obj", "head and neck, cm, face towards +y, z up", [(0.62, -17.0), (0.6, -9.0)] + head, 28, (7.2, 9.0))


def png(name, width, height, color):
    """8 bit RGB, top row first, of color(x, y) in sRGB, 0 to 1."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b"".join(b"\0" + bytes(min(255, max(0, round(255 * c))) for x in range(width) for c in color(x, y))
                    for y in range(height))
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    (pathlib.Path(__file__).parent / name).write_bytes(
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


# Skin with freckles and redder cheeks; the face looks towards +y, a quarter around.
random.seed(1)
width, height = 256, 192
freckles = [(random.gauss(0.25, 0.09) * width, random.gauss(0.55, 0.1) * height, random.uniform(0.5, 1.6)) for _ in range(260)]


def skin(x, y):
    red = sum(math.exp(-((x / width - u) ** 2 / 0.0012 + (1 - y / height - 0.48) ** 2 / 0.006)) for u in (0.19, 0.31))
    dark = max((math.exp(-((x - a) ** 2 + (y - b) ** 2) / r ** 2) for a, b, r in freckles), default=0.0)
    return (0.84 - 0.13 * dark, 0.65 - 0.07 * red - 0.17 * dark, 0.55 - 0.06 * red - 0.16 * dark)


png("skin.png", width, height, skin)
