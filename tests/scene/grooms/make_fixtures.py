#!/usr/bin/env python3
"""Makes the grooms that tests read: python3 tests/scene/grooms/make_fixtures.py writes them beside this file.

same.*: the same nine strands in every format, of numbers that a float has exactly. bases/: every basis, wrap and
interpolation of USD with points on the curves as textbooks evaluate them (expected.txt). malformed/: files that must be
refused, and in malformed/expected.txt what the message must name. crates/: texts of USD here and in ../faults as .usdc
and .usdz. The corpora of the fuzz targets are copies.
"""
import io
import math
import pathlib
import shutil
import struct
import zipfile

import crate_writer
import ogawa_writer as ogawa

HERE = pathlib.Path(__file__).parent
CORPUS = HERE.parent.parent / "fuzz" / "corpus"
SEGMENTS = 8


def strands():
    """Nine strands of nine points that hang from z = 0, in sixteenths of a centimetre, and their widths."""
    out = []
    for s in range(9):
        x, y = s % 3 - 1, s // 3 - 1
        out.append([(x + round(4 * math.sin(0.7 * i + s)) / 16, y + round(3 * math.cos(0.5 * i + s)) / 16, -i)
                    for i in range(SEGMENTS + 1)])
    return out


WIDTHS = [0.0625 - i / 256 for i in range(SEGMENTS + 1)]


def with_phantoms(values):
    def reflected(a, b):
        return tuple(2 * p - q for p, q in zip(a, b)) if isinstance(a, tuple) else 2 * a - b
    return [reflected(values[0], values[1])] + list(values) + [reflected(values[-1], values[-2])]


def hair_bytes(all_strands, widths):
    points = [p for s in all_strands for p in s]
    header = struct.pack("<4sIIIIfffff", b"HAIR", len(all_strands), len(points), 1 | 2 | 4, 0, 0, 0, 0, 0, 0)
    out = header.ljust(128, b"\0") + b"".join(struct.pack("<H", len(s) - 1) for s in all_strands)
    return out + b"".join(struct.pack("<fff", *p) for p in points) + struct.pack("<%df" % len(points),
                                                                                *(widths * len(all_strands)))


def number(x):
    return repr(float(x)) if not float(x).is_integer() else str(int(x))


def triples(values):
    return "[" + ", ".join("(%s)" % ", ".join(number(x) for x in v) for v in values) + "]"


def numbers(values):
    return "[" + ", ".join(number(x) for x in values) + "]"


def basis_curves(name, basis, wrap, counts, points, widths, interpolation, more="", indent="    "):
    kind = "linear" if basis == "linear" else "cubic"
    lines = ['def BasisCurves "%s"' % name, "{", '    uniform token type = "%s"' % kind]
    if basis != "linear":
        lines.append('    uniform token basis = "%s"' % basis)
    lines += ['    uniform token wrap = "%s"' % wrap, "    int[] curveVertexCounts = " + numbers(counts),
              "    point3f[] points = " + triples(points),
              '    float[] widths = %s ( interpolation = "%s" )' % (numbers(widths), interpolation)]
    if more:
        lines.append("    " + more)
    return "\n".join(indent + line for line in lines + ["}"])


def stage(body, head="    metersPerUnit = 0.01\n    upAxis = \"Z\"\n"):
    return "#usda 1.0\n(\n%s)\n\ndef Xform \"Groom\"\n{\n%s\n}\n" % (head, body)


def write(name, content):
    path = HERE / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content.encode() if isinstance(content, str) else content)


def the_same_in_every_format():
    all_strands = strands()
    points = [p for s in all_strands for p in s]
    counts = [SEGMENTS + 1] * len(all_strands)
    write("same.hair", hair_bytes(all_strands, WIDTHS))
    write("same.usda", stage(basis_curves("Hair", "bspline", "pinned", counts, points, WIDTHS * len(all_strands), "vertex")))
    # As XGen writes it: points beyond both ends, and a transform above that a matrix undoes.
    phantoms = [tuple(x / 2 for x in p) for s in all_strands for p in with_phantoms(s)]
    widths = [w / 2 for w in with_phantoms(WIDTHS)] * len(all_strands)

    def build(archive):
        hair = ogawa.curves(archive, [SEGMENTS + 3] * len(all_strands), phantoms, width=widths, params=[
            archive.array("groom_id", "i32", list(range(len(all_strands))), 1, ogawa.scope("uni", "int32_t")),
            archive.array("groom_root_uv", "f32", [x for s in range(9) for x in (s / 16, 0.5)], 2,
                          ogawa.scope("uni", "float32_t", 2)),
            archive.array("groom_closest_guides", "i32", [0] * 9, 1, ogawa.scope("uni", "int32_t"))])
        guides = ogawa.curves(archive, [4], [(0, 0, -z) for z in range(4)],
                              params=[archive.array("groom_guide", "i16", [1], 1, ogawa.scope("con", "int16_t"))])
        turned = ogawa.xform(archive, [(1, [3, 0, 0]), (6, [90]), (3, [0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 3, 0, 1]),
                                       (0, [2, 2, 2])],
                             [("hair", hair, ogawa.CURVE), ("guides", guides, ogawa.CURVE)])
        return [("turned", turned, ogawa.XFORM)]

    write("same.abc", ogawa.archive_of(build))
    lines = ["# nine strands of a script", "LookAt 0 -9 0 0 0 0 0 0 1", 'Camera "perspective" "float fov" 30', "WorldBegin",
             'Material "hair" "rgb sigma_a" [ 0.1 0.2 0.4 ] "float beta_m" .25', "AttributeBegin",
             "Translate 0 0 -1", "Scale .5 .5 .5", "Transform [ 1 0 0 0  0 1 0 0  0 0 1 0  0 0 0 1 ]"]
    for strand in all_strands:
        flat = " ".join(number(x) for p in with_phantoms(strand) for x in p)
        lines.append('Shape "curve" "string type" "cylinder" "string basis" [ "bspline" ] "integer degree" 3 '
                     '"float width0" %s "float width1" [ %s ] "point3 P" [ %s ]' % (WIDTHS[0], WIDTHS[-1], flat))
    write("same.pbrt", "\n".join(lines + ["AttributeEnd", 'Shape "sphere" "float radius" 2', ""]))
    data = struct.pack("<i", len(all_strands))
    for strand in all_strands:
        data += struct.pack("<i", len(strand)) + b"".join(struct.pack("<fff", *p) for p in strand)
    write("same.data", data)
    head = "ply\nformat %s 1.0\ncomment a script of tress\nelement vertex %d\n" % ("%s", len(points))
    head += "".join("property float %s\n" % n for n in ("x", "y", "z", "width")) + "property int strand_id\nend_header\n"
    rows = [(*p, WIDTHS[i], s) for s, strand in enumerate(all_strands) for i, p in enumerate(strand)]
    write("same.ply", head % "ascii" + "".join(" ".join(number(x) for x in row) + "\n" for row in rows))
    for order, mark in (("little", "<"), ("big", ">")):
        write("same_%s.ply" % order, (head % ("binary_%s_endian" % order)).encode() +
              b"".join(struct.pack(mark + "4fi", *row) for row in rows))


def the_same_with_colors():
    """The same strands again, each of a color, in the formats that have colors."""
    all_strands = strands()
    points = [p for s in all_strands for p in s]
    color = [(0.75, 0.5, 0.25), (0.25, 0.125, 0.0625), (0.5, 0.5, 0.5)]
    colors = [color[s % 3] for s in range(len(all_strands))]
    of_points = [c for s, c in zip(all_strands, colors) for _ in s]
    hair = bytearray(hair_bytes(all_strands, WIDTHS))
    hair[12] |= 16
    write("colored.hair", bytes(hair) + b"".join(struct.pack("<fff", *c) for c in of_points))
    counts = [SEGMENTS + 1] * len(all_strands)
    write("colored.usda", stage(basis_curves(
        "Hair", "bspline", "pinned", counts, points, WIDTHS * len(all_strands), "vertex",
        'color3f[] primvars:displayColor = %s ( interpolation = "uniform" )' % triples(colors))))

    def build(archive):
        return [("hair", ogawa.curves(
            archive, [SEGMENTS + 3] * len(all_strands), [p for s in all_strands for p in with_phantoms(s)],
            width=with_phantoms(WIDTHS) * len(all_strands),
            params=[archive.array("groom_color", "f32", [x for c in colors for x in c], 3, ogawa.scope("uni", extent=3))]),
            ogawa.CURVE)]

    write("colored.abc", ogawa.archive_of(build))
    head = "ply\nformat ascii 1.0\nelement vertex %d\n" % len(points) + "".join(
        "property float %s\n" % n for n in ("x", "y", "z", "width", "red", "green", "blue"))
    rows = [(*p, WIDTHS[i], *colors[s], s) for s, strand in enumerate(all_strands) for i, p in enumerate(strand)]
    write("colored.ply", head + "property int strand_id\nend_header\n" +
          "".join(" ".join(number(x) for x in row) + "\n" for row in rows))


def moving():
    """Two straight strands at frames 10, 11 and 12, below a transform that moves too, and one with velocities alone."""
    def points(x, bend):
        return [(x, 0, 0), (x, 0, 1), (x + 4, bend, 0), (x + 4, bend, 1)]

    def build(archive):
        archive.first_second = 10 / 24
        flat = [[v for p in points(x, bend) for v in p] for x, bend in ((0, 0), (8, 0), (8, 2))]
        geometry = [archive.samples("P", "f32", flat, 3), archive.array("nVertices", "i32", [2, 2]),
                    archive.scalar("curveBasisAndType", "u8", (1, 0, 0, 0))]
        hair = archive.object([archive.nested(".geom", geometry, "schema=AbcGeom_Curve_v2")], [])
        up = archive.object([archive.nested(".xform", [
            archive.scalar(".inherits", "bool", [1]), archive.array(".ops", "u8", [1 << 4]),
            archive.samples(".vals", "f64", [[0, 0, 0], [0, 0, 0], [0, 0, 16]])], "schema=AbcGeom_Xform_v3")],
            [("hair", hair, ogawa.CURVE)])
        thrown = [archive.samples("P", "f32", [[0, 9, 0, 0, 9, 1]], 3), archive.array("nVertices", "i32", [2]),
                  archive.samples(".velocities", "f32", [[24, 0, 0, 48, 0, 0]], 3),
                  archive.scalar("curveBasisAndType", "u8", (1, 0, 0, 0))]
        return [("up", up, ogawa.XFORM),
                ("thrown", archive.object([archive.nested(".geom", thrown, "schema=AbcGeom_Curve_v2")], []), ogawa.CURVE)]

    write("moving.abc", ogawa.archive_of(build))

    def instances(archive):  # of an object that is drawn too, below transforms; one is stretched, and one leads nowhere
        hair = ogawa.curves(archive, [2, 3], [(0, 0, 0), (0, 0, 5), (1, 0, 0), (1, 0, 2), (1, 1, 5)], (1, 0, 0, 0),
                            width=[0.0625], width_scope="con", params=[
                                archive.array("groom_id", "i32", [7, 8], 1, ogawa.scope("uni", "int32_t"))])
        def instance_of(path):
            source = archive.scalar(".instanceSource", "text", list(path.encode()))
            return archive.object([source], [])
        def at(ops, path="/a"):
            return ogawa.xform(archive, ops, [("a", instance_of(path), "isInstance=1")])
        up = archive.nested(".xform", [
            archive.scalar(".inherits", "bool", [1]), archive.array(".ops", "u8", [1 << 4]),
            archive.samples(".vals", "f64", [[4, 0, 0], [4, 0, 2]])], "schema=AbcGeom_Xform_v3")
        moving = archive.object([up], [("a", instance_of("/a"), "isInstance=1")])
        archive.first_second = 0
        return [("a", ogawa.xform(archive, [(1, (0, 0, 1))], [("hair", hair, ogawa.CURVE)]), ogawa.XFORM),
                ("moving", moving, ogawa.XFORM),
                ("turned", at([(1, (8, 0, 0)), (6, (90,)), (0, (2, 2, 2))]), ogawa.XFORM),
                ("stretched", at([(1, (0, 8, 0)), (0, (1, 1, 3))]), ogawa.XFORM),
                ("nowhere", at([], "/b"), ogawa.XFORM)]

    write("instances.abc", ogawa.archive_of(instances))

    def placeholders(archive):  # names of every length, in whose places a test puts others
        params = [archive.array("_" * size, "i32", [0], 1, ogawa.scope("con", "int32_t")) for size in range(1, 24)]
        return [("hair", ogawa.curves(archive, [2], [(0, 0, 0), (0, 0, 1)], (1, 0, 0, 0), params=params), ogawa.CURVE)]

    write("placeholders.abc", ogawa.archive_of(placeholders))

    def said(archive):
        geometry = [archive.array("P", "f32", [0, 0, 0, 0, 0, 1], 3), archive.array("nVertices", "i32", [2]),
                    archive.scalar("curveBasisAndType", "u8", (1, 0, 0, 0)), archive.array("width", "f32", [0.1]),
                    archive.array("N", "f32", [1, 0, 0, 1], 2),
                    archive.nested(".arbGeomParams", [archive.array("Cd", "f32", [1, 0, 0], 3),
                                                      archive.array("color", "f32", [0, 1, 0], 3),
                                                      archive.array("width", "f32", [0.2]),
                                                      archive.array("groom_width", "f32", [0.3])])]
        hair = archive.object([archive.nested(".geom", geometry, "schema=AbcGeom_Curve_v2"),
                               archive.array("densityMask", "u32", [0]), archive.array("guid", "u32", [0]),
                               archive.scalar(".material.assign", "u8", [0])], [])
        return [("hair", hair, ogawa.CURVE), ("red", archive.object([], []), "schema=AbcMaterial_Material_v1")]

    write("../faults/said.abc", ogawa.archive_of(said))

    def growing(archive):
        geometry = [archive.samples("P", "f32", [[0, 0, 0, 0, 0, 1], [0, 0, 0, 0, 0, 1, 0, 0, 2]], 3),
                    archive.samples("nVertices", "i32", [[2], [3]]),
                    archive.scalar("curveBasisAndType", "u8", (1, 0, 0, 0))]
        archive.first_second = 0
        return [("hair", archive.object([archive.nested(".geom", geometry, "schema=AbcGeom_Curve_v2")], []), ogawa.CURVE)]

    write("growing.abc", ogawa.archive_of(growing))


NORMALS = [[(1, 0, 0), (0.5, math.sqrt(3) / 2, 0), (-0.5, math.sqrt(3) / 2, 0), (-1, 0, 0)],
           [(0, 0, 1), (0, 0, -2), (0, 1, 0), (0, 0, 0)]]
"""Of two strands of four points: turned by 60 degrees from point to point; and one with its opposite, one along the
strand and none."""


def with_normals():
    """Two straight strands with the minor axes of their fibers, in three formats."""
    all_strands = [[(0, 0, -3 * i) for i in range(4)], [(2, 3 * i, 0) for i in range(4)]]
    points, normals = [p for s in all_strands for p in s], [n for s in NORMALS for n in s]
    write("normals.usda", stage(basis_curves(
        "Hair", "linear", "nonperiodic", [4, 4], points, [0.0625], "constant",
        'normal3f[] normals = %s ( interpolation = "vertex" )' % triples(normals))))

    def build(archive):  # turned back by a transform
        def back(v):
            return v[1], -v[0], v[2]

        flat = [x for n in normals for x in back(n)]
        hair = ogawa.curves(archive, [4, 4], [back(p) for p in points], kind=(1, 0, 0, 0), width=[0.0625],
                            width_scope="con", more=[archive.array("N", "f32", flat, 3, ogawa.scope("vtx", extent=3))])
        return [("turned", ogawa.xform(archive, [(6, [90])], [("hair", hair, ogawa.CURVE)]), ogawa.XFORM)]

    write("normals.abc", ogawa.archive_of(build))
    lines = ["WorldBegin", "Rotate 90 0 0 1"]
    for strand, own in zip(all_strands, NORMALS):
        for i in range(3):
            a, b = strand[i], strand[i + 1]
            p = [mix([1 - k / 3, k / 3], [a, b]) for k in range(4)]
            flat = " ".join(number(x) for v in p for x in (v[1], -v[0], v[2]))
            ends = " ".join(number(x) for v in own[i:i + 2] for x in (v[1], -v[0], v[2]))
            lines.append('Shape "curve" "string type" "ribbon" "float width" .0625 "point3 P" [ %s ] "normal N" [ %s ]' %
                         (flat, ends))
    write("normals.pbrt", "\n".join(lines + [""]))


# Curves as textbooks have them.

def mix(weights, values):
    return tuple(sum(w * v[c] for w, v in zip(weights, values)) for c in range(len(values[0])))


def weights_of(basis, t):
    s = 1 - t
    if basis == "linear":
        return [s, t]
    if basis == "bezier":
        return [s ** 3, 3 * s * s * t, 3 * s * t * t, t ** 3]
    if basis == "bspline":
        return [s ** 3 / 6, (3 * t ** 3 - 6 * t * t + 4) / 6, (-3 * t ** 3 + 3 * t * t + 3 * t + 1) / 6, t ** 3 / 6]
    return [(-t ** 3 + 2 * t * t - t) / 2, (3 * t ** 3 - 5 * t * t + 2) / 2, (-3 * t ** 3 + 4 * t * t + t) / 2,
            (t ** 3 - t * t) / 2]


def segments_of(basis, wrap, count):
    step = 3 if basis == "bezier" else 1
    if wrap == "periodic":
        return count // step
    if basis == "linear" or (wrap == "pinned" and basis != "bezier"):
        return count - 1
    return (count - 4) // step + 1


def on_curve(basis, wrap, values, segment, t):
    """values: tuples a vertex. The phantom points of a pinned curve mirror its second and last but one."""
    step = 3 if basis == "bezier" else 1
    pinned = wrap == "pinned" and basis in ("bspline", "catmullRom")
    vertices = with_phantoms(values) if pinned else list(values)
    order = 2 if basis == "linear" else 4
    chosen = [vertices[(segment * step + k) % len(vertices) if wrap == "periodic" else segment * step + k] for k in range(order)]
    return mix(weights_of(basis, t), chosen)


def vertices_of(curve, count):
    return [(i * 0.5 + 0.25 * math.sin(2.0 * i + curve), 0.5 * math.cos(1.3 * i) + curve, -0.75 * i + 0.125 * (i * i % 5))
            for i in range(count)]


def every_basis():
    expected = ["# file prim curve segment t x y z width, as textbooks evaluate the curves; see make_fixtures.py"]
    for basis in ("linear", "bezier", "bspline", "catmullRom"):
        for wrap in ("nonperiodic", "periodic", "pinned"):
            if basis == "bezier":
                counts = [6, 9, 3] if wrap == "periodic" else [4, 7, 10]
            elif basis == "linear":
                counts = [2, 3, 5]
            else:
                counts = [5, 4, 6, 7] if wrap != "pinned" else [2, 3, 6]
            curves = [vertices_of(c, n) for c, n in enumerate(counts)]
            prims = []
            for interpolation in ("constant", "uniform", "varying", "vertex"):
                widths, at = [], []
                for c, count in enumerate(counts):
                    segments = segments_of(basis, wrap, count)
                    size = {"constant": 1, "uniform": 1, "vertex": count,
                            "varying": segments + (0 if wrap == "periodic" else 1)}[interpolation]
                    # Even rises, where B-splines are held to them: what is linear along a segment is so exactly there.
                    own = [0.25 + 0.0625 * c + 0.03125 * i for i in range(size)]
                    if interpolation == "constant":
                        own = [0.25]
                    at.append(own)
                    widths += own if interpolation != "constant" or c == 0 else []
                # A color is linear in the width, so that one row gives both.
                colors = 'color3f[] primvars:displayColor = %s ( interpolation = "%s" )' % (
                    triples([(w, w / 2, 1 - w) for w in widths]), interpolation)
                prims.append(basis_curves(interpolation, basis, wrap, counts, [p for v in curves for p in v], widths,
                                          interpolation, colors))
                for c, points in enumerate(curves):
                    for segment in range(segments_of(basis, wrap, counts[c])):
                        for t in (0.25, 1.0) if segment else (0.0, 0.25, 1.0):
                            x = on_curve(basis, wrap, [tuple(struct.unpack("<3f", struct.pack("<3f", *p))) for p in points], segment, t)
                            if interpolation in ("constant", "uniform"):
                                width = at[c][0]
                            elif interpolation == "vertex":
                                width = on_curve(basis, wrap, [(w,) for w in at[c]], segment, t)[0]
                            elif wrap == "periodic" and basis in ("bspline", "linear"):
                                continue  # a jump at the seam, which B-splines round: see README.md
                            else:
                                ends = at[c] + at[c][:1]
                                width = (1 - t) * ends[segment] + t * ends[segment + 1]
                            expected.append("%s_%s.usda %s %d %d %g %.9g %.9g %.9g %.9g" %
                                            (basis, wrap, interpolation, c, segment, t, *x, width))
            write("bases/%s_%s.usda" % (basis, wrap), stage("\n".join(prims)))
    write("bases/expected.txt", "\n".join(expected) + "\n")


def malformed():
    """Each with a word that the message must have besides the name."""
    good = (HERE / "same.abc").read_bytes()
    usda = (HERE / "same.usda").read_text()
    cases = {}

    def abc(name, word, change):
        data = bytearray(good)
        change(data)
        cases[name + ".abc"] = (bytes(data), word)

    root = struct.unpack("<Q", good[8:16])[0]

    def put(at, value):
        def change(data):
            data[at:at + 8] = struct.pack("<Q", value)
        return change

    def cut(size):
        def change(data):
            del data[size:]
        return change

    abc("not_closed", "byte 5", lambda d: d.__setitem__(5, 0))
    abc("version_2", "byte 6", lambda d: d.__setitem__(7, 2))
    abc("header_only", "end of the file", cut(16))
    abc("cut_in_half", "end of the file", cut(len(good) // 2))
    abc("root_outside", "end of the file", put(8, len(good) + 8))
    abc("root_is_data", "a group", put(8, root | ogawa.DATA))
    abc("root_of_five", "six children", put(root, 5))
    abc("root_of_2_to_61", "children", put(root, 1 << 61))
    abc("top_is_root", "a group", put(root + 8 + 16, root))
    abc("metadata_is_a_group", "data", put(root + 8 + 40, root))
    abc("metadata_outside", "bytes", put(root + 8 + 40, (len(good) - 4) | ogawa.DATA))
    abc("no_top", "curves", put(root + 8 + 16, 0))

    def made(name, word, build):
        cases[name + ".abc"] = (ogawa.archive_of(build), word)

    line = [(0, 0, -z) for z in range(4)]
    made("counts_too_many", "vertices", lambda a: [("c", ogawa.curves(a, [5], line), ogawa.CURVE)])
    made("counts_negative", "2^24", lambda a: [("c", ogawa.curves(a, [-4], line), ogawa.CURVE)])
    made("counts_huge", "2^24", lambda a: [("c", ogawa.curves(a, [2147483647], line), ogawa.CURVE)])
    made("point_not_finite", "finite", lambda a: [("c", ogawa.curves(a, [4], line[:3] + [(0, math.nan, 0)]), ogawa.CURVE)])
    made("basis_power", "power", lambda a: [("c", ogawa.curves(a, [4], line, kind=(0, 0, 5, 5)), ogawa.CURVE)])
    made("bezier_of_five", "3 n + 1", lambda a: [("c", ogawa.curves(a, [5], line + [(0, 0, -9)], kind=(0, 0, 1, 1)), ogawa.CURVE)])
    made("transform_short", "transform", lambda a: [("x", ogawa.xform(a, [(3, [1] * 9)], []), ogawa.XFORM)])
    made("no_curves", "curves", lambda a: [])

    def part(archive, *properties):
        return archive.object([archive.nested(".geom", list(properties), "schema=AbcGeom_Curve_v2")], [])

    def whole(archive, pod="f32", values=None, extent=3, counts=(4,), kind=(0, 0, 2, 2)):
        flat = [x for p in line for x in p] if values is None else values
        return [archive.array("P", pod, flat, extent), archive.array("nVertices", "i32", list(counts)),
                archive.scalar("curveBasisAndType", "u8", kind)]

    def of(name, word, *arguments, more=lambda a: [], **keywords):
        made(name, word, lambda a: [("c", part(a, *whole(a, *arguments, **keywords), *more(a)), ogawa.CURVE)])

    of("points_are_texts", "texts", pod="text", values=[65] * 12)
    of("points_are_pairs", "three numbers", extent=2)
    of("points_cut", "12 bytes", values=[0, 0, 0, 0])
    of("points_doubles_cut", "values of 3 numbers", pod="f64", values=[0, 0, 0, 0])
    of("counts_none", "curves", counts=())
    of("basis_nine", "basis 9", kind=(0, 0, 9, 9))
    of("type_of_seven", "type 7", kind=(7, 0, 2, 2))
    of("orders_differ", "orders for", kind=(2, 0, 2, 2), more=lambda a: [a.array(".orders", "i32", [4, 2])])
    of("order_of_nine", "order 9", kind=(2, 0, 2, 2), more=lambda a: [a.array(".orders", "i32", [9])])
    of("sampling_unknown", "time samplings", more=lambda a: [a.samples("width", "f32", [[1], [2]], sampling=200)])
    made("counts_missing", "curves", lambda a: [("c", part(a, whole(a)[0]), ogawa.CURVE)])

    def deep(archive):
        child = ("c", ogawa.curves(archive, [4], line), ogawa.CURVE)
        for _ in range(300):
            child = ("x", ogawa.xform(archive, [], [child]), ogawa.XFORM)
        return [child]

    def shared(archive):  # one large object, many times
        group = ogawa.curves(archive, [1000], [(0, 0, -z) for z in range(1000)])
        return [("c%d" % i, group, ogawa.CURVE) for i in range(40)]

    made("deep", "200 objects", deep)
    made("shared", "as the bytes allow", shared)

    def patched(name, word, build, patch):
        """patch(bytes, places): places is what build left there."""
        places = {}
        data = bytearray(ogawa.archive_of(lambda archive: build(archive, places)))
        patch(data, places)
        cases[name + ".abc"] = (bytes(data), word)

    def plain(archive, places):
        properties = whole(archive)
        places["points"] = properties[0][1]
        places["compound"] = len(archive.bytes)
        group = part(archive, *properties)
        places["object"] = group
        return [("c", group, ogawa.CURVE)]

    def number_at(data, at):
        return struct.unpack("<Q", data[at:at + 8])[0]

    def points_data(data, places):
        return number_at(data, places["points"] + 8) & ~ogawa.DATA

    patched("data_of_2_to_62", "bytes of data", plain, lambda d, at: put(points_data(d, at), 1 << 62)(d))
    patched("points_are_a_group", "data", plain, lambda d, at: put(at["points"] + 8, at["points"])(d))
    patched("points_outside", "end of the file", plain, lambda d, at: put(at["points"] + 8, (1 << 40) | ogawa.DATA)(d))
    patched("object_in_itself", "children", plain, lambda d, at: put(at["object"] + 8, at["object"])(d))

    def name_of_250(data, places):
        at = data.index(b"\x09nVertices")
        data[at] = 250

    def object_name_of_2_to_31(data, places):
        at = data.rindex(struct.pack("<I", 1) + b"c")
        data[at:at + 4] = struct.pack("<I", 1 << 31)

    def object_metadata_200(data, places):
        at = data.rindex(struct.pack("<I", 1) + b"c")
        data[at + 5] = 200

    patched("name_of_250", "headers of properties", plain, name_of_250)
    patched("object_name_of_2_to_31", "headers of objects", plain, object_name_of_2_to_31)
    patched("object_metadata_200", "metadata that the archive has", plain, object_metadata_200)

    def family(archive, places):
        child = ogawa.curves(archive, [4], line)
        places["parent"] = archive.object([], [("c", child, ogawa.CURVE)])
        return [("p", places["parent"], "")]

    patched("child_is_its_parent", "hold each other", family, lambda d, at: put(at["parent"] + 16, at["parent"])(d))

    def text(name, word, content):
        cases[name + ".usda"] = (content.encode(), word)

    text("referenced", "usdcat --flatten", usda.replace('def Xform "Groom"', 'def Xform "Groom" (\n    prepend references = @hair.usd@\n)'))
    text("variants", "usdcat --flatten", usda.replace("    def BasisCurves", '    variantSet "v" = { "a" { } }\n    def BasisCurves'))
    text("sublayers", "usdcat --flatten", usda.replace("    upAxis", "    subLayers = [ @a.usd@ ]\n    upAxis"))
    text("cut", "line", usda[:len(usda) // 2])
    text("counts_wrong", "vertices", usda.replace("curveVertexCounts = [9,", "curveVertexCounts = [8,"))
    text("counts_fraction", "whole", usda.replace("curveVertexCounts = [9,", "curveVertexCounts = [9.5,"))
    text("basis_unknown", "basis", usda.replace('"bspline"', '"nurbs"'))
    text("up_x", "upAxis", usda.replace('upAxis = "Z"', 'upAxis = "X"'))
    text("points_of_two", "three", usda.replace("[(", "[(1, ", 1))
    text("deep", "line", "#usda 1.0\n" + 'def "a" {' * 1000)
    text("brackets", "line", "#usda 1.0\n( a = " + "[" * 1000)
    text("no_prims", "curves", "#usda 1.0\n")
    pbrt = (HERE / "same.pbrt").read_bytes()
    cases["cut.pbrt"] = (pbrt[:pbrt.rindex(b"P\"") + 40], "line")
    cases["directive.pbrt"] = (b"WorldBegin\nShap \"curve\"\n", "line 2")
    cases["points.pbrt"] = (b'WorldBegin\nShape "curve" "point3 P" [ 0 0 0  0 0 1 ]\n', "bezier")
    cases["includes_itself.pbrt"] = (b'WorldBegin\nInclude "includes_itself.pbrt"\n', "includes")
    data = (HERE / "same.data").read_bytes()
    cases["cut.data"] = (data[:-5], "byte")
    cases["longer.data"] = (data + b"\0\0\0\0", "more")
    cases["strands.data"] = (struct.pack("<i", -9) + data[4:], "byte 0")
    cases["points.data"] = (data[:4] + struct.pack("<i", 2147483647) + data[8:], "points of strand 0")
    ply = (HERE / "same_little.ply").read_bytes()
    cases["cut.ply"] = (ply[:-5], "vertices")
    cases["many.ply"] = (ply.replace(b"vertex 81", b"vertex 99999999999"), "vertices")
    cases["mesh.ply"] = (ply.replace(b"end_header", b"element face 3\nproperty list uchar int i\nend_header"), "mesh")
    cases["no_z.ply"] = (ply.replace(b"float z", b"float q"), "property z")
    hair = (HERE / "same.hair").read_bytes()
    cases["cut.hair"] = (hair[:-5], "byte")
    cases["old.abc"] = (b"\x89HDF\r\n\x1a\n" + bytes(64), "HDF5")
    # Whole at first sight: what is wrong is in samples of a later frame.
    for name, said, samples in (("samples_of_255", 255, 2), ("later_sample_cut", 2, 1)):
        def later(archive, said=said, samples=samples):
            archive.first_second = 0
            points = [x for p in line for x in p]
            return [("c", part(archive, archive.samples("P", "f32", [points, points][:samples], 3, said=said),
                               archive.array("nVertices", "i32", [4]),
                               archive.scalar("curveBasisAndType", "u8", (0, 0, 2, 2))), ogawa.CURVE)]
        write("malformed/timed_%s.abc" % name, ogawa.archive_of(later))
    for name, (content, _) in cases.items():
        write("malformed/" + name, content)
    words = {name: word for name, (_, word) in cases.items()} | crates()
    write("malformed/expected.txt", "".join("%s\t%s\n" % item for item in sorted(words.items())))


# The texts that become crates too, each of another version of the format.
CRATES = {"instancer": 8, "same": 8, "colored": 7, "normals": 6, "types": 5, "bases/catmullRom_pinned": 8, "bases/bezier_periodic": 4,
          "bases/bspline_nonperiodic": 6, "bases/linear_pinned": 12, "../faults/animated_normals": 8, "../faults/defts": 4,
          "../faults/flatinst": 8, "../faults/idxid": 5, "../faults/idxw": 6, "../faults/inh": 8, "../faults/nan": 9,
          "../faults/one_thick": 8, "../faults/scaled": 10, "../faults/utf8id": 8, "../faults/vary": 7,
          "../faults/visafter": 11, "../faults/said": 9}


def crates():
    for source, minor in CRATES.items():
        write("crates/%s.usdc" % pathlib.Path(source).name, crate_writer.crate((HERE / (source + ".usda")).read_text(), minor))
    whole = (HERE / "crates/types.usdc").read_bytes()
    write("crates/types_8.usdc", crate_writer.crate((HERE / "types.usda").read_text()))
    write("crates/same.usdz", usdz([("groom/same.usdc", (HERE / "crates/same.usdc").read_bytes()), ("textures/a.png", b"none"),
                                    ("b.usda", b"#usda 1.0\n")]))
    hair = """#usda 1.0
(
    defaultPrim = "hair"
    metersPerUnit = 1
)

def Xform "hair"
{
    def BasisCurves "h"
    {
        uniform token type = "linear"
        int[] curveVertexCounts = [2]
        point3f[] points = [(0, 0, 0), (0, 0, 5)]
        float[] widths = [0.5, 0.25]
    }
}
"""
    package = {
        "root.usda": """#usda 1.0
(
    metersPerUnit = 0.01
    upAxis = "Z"
    subLayers = [ @./looks/red.usda@, @looks/none.usda@ ]
)

def "a" (
    references = @geo/hair.usdc@
)
{
}

def "b" (
    prepend payload = @./geo/middle.usda@</m>
)
{
    double3 xformOp:translate = (1, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}

def "c" (
    references = @geo/none.usda@</m>
)
{
}
""",
        "looks/red.usda": """#usda 1.0

over "a"
{
    over "h"
    {
        color3f[] primvars:displayColor = [(1, 0, 0)]
        float[] widths = [1, 2]
    }
}

over "b" (
    references = </spare>
)
{
}

class "spare"
{
    def BasisCurves "more"
    {
        uniform token type = "linear"
        int[] curveVertexCounts = [2]
        point3f[] points = [(9, 0, 0), (9, 0, 5)]
    }
}
""",
        "geo/hair.usdc": crate_writer.crate(hair),
        "geo/middle.usda": """#usda 1.0

def "m" (
    active = true
    references = [ @hair.usdc@</hair>, </n> ]
)
{
}

def "n"
{
    double3 xformOp:translate = (7, 7, 7)

    def "deep" (
        references = @geo/deep.usda@</d>
    )
    {
    }
}
""",
        "geo/deep.usda": """#usda 1.0

def BasisCurves "d"
{
    uniform token type = "linear"
    int[] curveVertexCounts = [2]
    point3f[] points = [(0, 8, 0), (0, 8, 5)]
}
""",
        "a.png": b"none", "spare.usda": "#usda 1.0\n"}
    write("crates/package.usdz", usdz([(name, text if isinstance(text, bytes) else text.encode()) for name, text in package.items()]))
    write("crates/same_text.usdz", usdz([("same.usda", (HERE / "same.usda").read_bytes())]))

    text = (HERE / "same.usda").read_text()
    write("unread.usdc", crate_writer.crate(text.replace("    def BasisCurves", "    asset primvars:displayColor = @a.png@\n    def BasisCurves")))

    class Looped(crate_writer.Crate):
        def tree(self, paths):
            rows = super().tree(paths)
            rows[2][0] = rows[1][0]
            return rows

    def patched(at, content):
        return whole[:at] + content + whole[at + len(content):]

    toc = struct.unpack_from("<q", whole, 16)[0]
    tokens = struct.unpack_from("<q", whole, toc + 8 + 16)[0]
    cases = {"binary.usdc": (b"PXR-USDC" + bytes(64), "88 bytes"),
             "half.usdc": (whole[:len(whole) // 2], "table of contents"),
             "old.usdc": (patched(9, b"\1"), "version 0.4 to 0.12"),
             "newer.usdc": (patched(9, b"\x0d"), "version 0.4 to 0.12"),
             "contents_outside.usdc": (patched(16, b"\xff" * 8), "table of contents"),
             "section_outside.usdc": (patched(toc + 8 + 24, b"\xff" * 4), "section within"),
             "no_tokens.usdc": (patched(toc + 8, b"X"), "section TOKENS"),
             "tokens_of_2_to_40.usdc": (patched(tokens, b"\0" * 5 + b"\1"), "tokens"),
             "unpacked_of_2_to_40.usdc": (patched(tokens + 8, b"\0" * 5 + b"\1"), "bytes unpacked"),
             "not_lz4.usdc": (patched(tokens + 25, b"\xf0" + b"\xff" * 60), "LZ4"),
             "paths_twice.usdc": (bytes(Looped(text).bytes), "once"),
             "far.usdc": (crate_writer.crate(text.replace('def Xform "Groom"', 'def Xform "Groom" (\n    prepend references = @hair.usd@\n)')),
                          "usdcat --flatten"),
             "down.usdc": (crate_writer.crate("#usda 1.0\n" + 'def "a" {' * 250 + "}" * 250), "200 prims"),
             "names_shared.usdc": (crate_writer.crate("#usda 1.0\ndef Xform \"a\" { token[] xformOpOrder = [%s] }" %
                                                      ", ".join(['"%s"' % ("x" * 300)] * 1500)), "bytes of names"),
             "paths_shared.usdc": (crate_writer.crate("#usda 1.0\n" + ('def "%s" { ' % ("n" * 60)) * 90 + "}" * 90 +
                                                      'def "r" ( inherits = [%s] ) { }' % ", ".join(["<" + ("/" + "n" * 60) * 90 + ">"] * 60)),
                                   "bytes of names"),
             "packed.usdz": (usdz([("a.usda", b"#usda 1.0\n" * 20)], zipfile.ZIP_DEFLATED), "stored"),
             "picture_first.usdz": (usdz([("a.png", b"none"), ("a.usda", b"#usda 1.0\n")]), "first entry"),
             "no_table.usdz": (usdz([("a.usda", b"#usda 1.0\n")])[:-22], "table of a zip archive"),
             "not_usd.usdz": (usdz([("a.usda", b"none")]), "marks of layers")}
    for name, (content, _) in cases.items():
        write("malformed/" + name, content)
    return {name: word for name, (_, word) in cases.items()}


def usdz(entries, method=zipfile.ZIP_STORED):
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", method) as archive:
        for name, content in entries:
            archive.writestr(zipfile.ZipInfo(name), content, method)
    return stream.getvalue()


def corpora():
    for target, ending in (("hair", ".hair"), ("alembic", ".abc"), ("usda", ".usda"), ("usdc", ".usdc"), ("usdc", ".usdz"), ("pbrt", ".pbrt"), ("usc", ".data"), ("ply", ".ply")):
        folder = CORPUS / target
        folder.mkdir(parents=True, exist_ok=True)
        for file in sorted(HERE.rglob("*" + ending)):
            if file.stat().st_size < 20000:
                shutil.copy(file, folder / (file.parent.name + "_" + file.name))


if __name__ == "__main__":
    the_same_in_every_format()
    the_same_with_colors()
    every_basis()
    with_normals()
    moving()
    malformed()
    corpora()
