"""Writes Alembic archives (Ogawa) from Python, as far as curves need: groups, data, headers, as others' libraries do."""
import struct

DATA = 1 << 63
POD = {"bool": (0, "B"), "u8": (1, "B"), "i16": (4, "h"), "u32": (5, "I"), "i32": (6, "i"), "f16": (9, "e"),
       "f32": (10, "f"), "f64": (11, "d"), "text": (12, "B")}


class Archive:
    def __init__(self):
        self.bytes = bytearray(b"Ogawa\xff\x00\x01" + bytes(8))
        self.metadata = [""]
        self.first_second = None

    def data(self, content):
        if not content:
            return DATA
        at = len(self.bytes)
        self.bytes += struct.pack("<Q", len(content)) + content
        return at | DATA

    def group(self, children):
        if not children:
            return 0
        at = len(self.bytes)
        self.bytes += struct.pack("<Q", len(children)) + b"".join(struct.pack("<Q", c) for c in children)
        return at

    def index_of(self, metadata):
        if metadata not in self.metadata:
            self.metadata.append(metadata)
        return self.metadata.index(metadata)

    def sample(self, pod, values):
        return self.data(bytes(range(16)) + struct.pack("<%d%s" % (len(values), POD[pod][1]), *values))

    def compound(self, properties):
        """properties: (name, group, header without name, metadata)."""
        headers = b""
        for name, _, info, counts, metadata in properties:
            index = self.index_of(metadata)
            headers += struct.pack("<I", info | index << 20) + counts + struct.pack("<B", len(name)) + name.encode()
        return self.group([group for _, group, _, _, _ in properties] + [self.data(headers)])

    def array(self, name, pod, values, extent=1, metadata=""):
        """One constant sample."""
        group = self.group([self.sample(pod, values), DATA])
        return name, group, 2 | POD[pod][0] << 4 | 1 << 10 | 1 << 11 | extent << 12, b"\x01", metadata

    def samples(self, name, pod, samples, extent=1, metadata="", said=None, sampling=1):
        """Several, by the second time sampling. said: how many the header says, where not the truth."""
        group = self.group([x for values in samples for x in (self.sample(pod, values), DATA)])
        return (name, group, 2 | POD[pod][0] << 4 | 1 << 8 | 1 << 10 | extent << 12,
                struct.pack("<BB", said or len(samples), sampling), metadata)

    def scalar(self, name, pod, values, metadata=""):
        group = self.group([self.sample(pod, values)])
        return name, group, 1 | POD[pod][0] << 4 | 1 << 10 | 1 << 11 | len(values) << 12, b"\x01", metadata

    def nested(self, name, properties, metadata=""):
        return name, self.compound(properties), 0, b"", metadata

    def object(self, properties, children):
        """children: (name, group, metadata)."""
        headers = b""
        for name, _, metadata in children:
            headers += struct.pack("<I", len(name)) + name.encode() + struct.pack("<B", self.index_of(metadata))
        return self.group([self.compound(properties)] + [group for _, group, _ in children] +
                          [self.data(headers + bytes(32))])

    def finish(self, top):
        samplings = struct.pack("<IdId", 1, 1.0, 1, 0.0)
        if self.first_second is not None:  # and one of 24 frames a second
            samplings += struct.pack("<IdId", 1, 1 / 24, 1, self.first_second)
        indexed = b"".join(struct.pack("<B", len(m)) + m.encode() for m in self.metadata[1:])
        root = self.group([self.data(struct.pack("<i", 0)), self.data(struct.pack("<i", 10805)), top,
                           self.data(b"_ai_Application=a script of tress"), self.data(samplings), self.data(indexed)])
        self.bytes[8:16] = struct.pack("<Q", root)
        return bytes(self.bytes)


CURVE = "schema=AbcGeom_Curve_v2;schemaObjTitle=AbcGeom_Curve_v2:.geom"
XFORM = "schema=AbcGeom_Xform_v3;schemaObjTitle=AbcGeom_Xform_v3:.xform"


def scope(word, pod="float32_t", extent=1):
    return "isGeomParam=true;geoScope=%s;podName=%s;podExtent=%d" % (word, pod, extent)


def curves(archive, counts, points, kind=(0, 0, 2, 2), width=None, width_scope="vtx", more=(), params=()):
    """An object of curves. kind: type, wrap, basis, basis."""
    flat = [x for p in points for x in p]
    geometry = [archive.array("P", "f32", flat, 3), archive.array("nVertices", "i32", counts),
                archive.scalar("curveBasisAndType", "u8", kind)]
    if width:
        geometry.append(archive.array("width", "f32", width, 1, scope(width_scope)))
    geometry += list(more)
    if params:
        geometry.append(archive.nested(".arbGeomParams", list(params)))
    return archive.object([archive.nested(".geom", geometry, "schema=AbcGeom_Curve_v2")], [])


def xform(archive, ops, children, inherits=1):
    """ops: (type, values): 0 scale, 1 translate, 2 rotate axis angle, 3 matrix, 4 5 6 rotate x y z in degrees."""
    properties = [archive.scalar(".inherits", "bool", [inherits]),
                  archive.array(".ops", "u8", [t << 4 for t, _ in ops]),
                  archive.array(".vals", "f64", [x for _, v in ops for x in v])]
    return archive.object([archive.nested(".xform", properties, "schema=AbcGeom_Xform_v3")], children)


def archive_of(build):
    """build(archive) -> children of the top object."""
    archive = Archive()
    children = build(archive)
    return archive.finish(archive.object([], children))
