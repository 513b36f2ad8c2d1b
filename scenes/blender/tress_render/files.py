"""Files that tress reads and writes, from and to plain numpy arrays. Knows nothing of Blender."""

import struct
import zlib

import numpy as np

MOST_SEGMENTS = 65535  # of a strand of a .hair file


def write_hair(path, lengths, points, widths, colors=None):
    """Strands as a .hair file.

    lengths: points of each strand, 2..65536. points: (n, 3), root first. widths: (n,), diameters in the unit of the
    points. colors: (n, 3), linear RGB, or None. ValueError where they do not fit each other.
    """
    lengths = np.asarray(lengths, np.int64)
    points = np.asarray(points, np.float32).reshape(-1, 3)
    widths = np.asarray(widths, np.float32).reshape(-1)
    if len(lengths) == 0 or lengths.min() < 2 or lengths.max() > MOST_SEGMENTS + 1:
        raise ValueError("strands of 2 to 65536 points are needed")
    if lengths.sum() != len(points) or len(widths) != len(points) or (colors is not None and len(colors) != len(points)):
        raise ValueError("points, widths and colors must be as many as the strands need")
    bits = 1 | 2 | 4 | (16 if colors is not None else 0)
    header = struct.pack("<4sIIIIfffff88s", b"HAIR", len(lengths), len(points), bits, 0, 0.0, 0.0, 0.0, 0.0, 0.0,
                         b"written by the tress add-on for Blender")
    with open(path, "wb") as file:
        file.write(header)
        file.write((lengths - 1).astype("<u2").tobytes())
        file.write(points.astype("<f4").tobytes())
        file.write(widths.astype("<f4").tobytes())
        if colors is not None:
            file.write(np.asarray(colors, "<f4").reshape(-1, 3).tobytes())


def write_obj(path, positions, triangles, normals=None, uvs=None):
    """Triangles as an OBJ file.

    positions: (n, 3). triangles: (t, 3), indices from 0. normals, uvs: (3 t, 3) and (3 t, 2), one a corner, or None.
    """
    positions = np.asarray(positions, float).reshape(-1, 3)
    corners = np.asarray(triangles, np.int64).reshape(-1) + 1
    names = [corners]
    with open(path, "w", encoding="ascii") as file:
        file.write(_rows("v %.9g %.9g %.9g\n", positions))
        shape = "%d"
        if uvs is not None:
            values, index = np.unique(np.asarray(uvs, np.float32).reshape(-1, 2), axis=0, return_inverse=True)
            file.write(_rows("vt %.9g %.9g\n", values))
            names.append(index.reshape(-1) + 1)
            shape += "/%d"
        if normals is not None:
            values, index = np.unique(np.asarray(normals, np.float32).reshape(-1, 3), axis=0, return_inverse=True)
            file.write(_rows("vn %.9g %.9g %.9g\n", values))
            names.append(index.reshape(-1) + 1)
            shape += "/%d" if uvs is not None else "//%d"
        line = "f " + " ".join([shape] * 3) + "\n"
        file.write(_rows(line, np.stack(names, 1).reshape(-1, 3 * len(names))))


def _rows(line, values):
    return (line * len(values)) % tuple(values.reshape(-1).tolist())


def write_exr(path, pixels):
    """Linear RGB of floats, (height, width, 3), top row first, as an uncompressed EXR of one part."""
    pixels = np.ascontiguousarray(pixels, "<f4")
    height, width, _ = pixels.shape
    box = struct.pack("<4i", 0, 0, width - 1, height - 1)
    channels = b"".join(name + b"\0" + struct.pack("<iB3xii", 2, 0, 1, 1) for name in (b"B", b"G", b"R")) + b"\0"
    header = struct.pack("<ii", 20000630, 2)
    for name, kind, value in ((b"channels", b"chlist", channels), (b"compression", b"compression", b"\0"),
                              (b"dataWindow", b"box2i", box), (b"displayWindow", b"box2i", box),
                              (b"lineOrder", b"lineOrder", b"\0"), (b"pixelAspectRatio", b"float", struct.pack("<f", 1)),
                              (b"screenWindowCenter", b"v2f", struct.pack("<ff", 0, 0)),
                              (b"screenWindowWidth", b"float", struct.pack("<f", 1))):
        header += name + b"\0" + kind + b"\0" + struct.pack("<i", len(value)) + value
    header += b"\0"
    row_bytes = 8 + 12 * width
    first = len(header) + 8 * height
    with open(path, "wb") as file:
        file.write(header)
        file.write((first + row_bytes * np.arange(height, dtype="<u8")).tobytes())
        for y in range(height):
            file.write(struct.pack("<ii", y, 12 * width))
            file.write(pixels[y, :, ::-1].T.tobytes())


class Picture:
    """A picture: `channels` maps names to (height, width) float32, top row first; the window is in the whole picture."""

    def __init__(self, width, height, left, top, whole_width, whole_height, channels):
        self.width, self.height, self.left, self.top = width, height, left, top
        self.whole_width, self.whole_height, self.channels = whole_width, whole_height, channels


def read_exr(path):
    """An EXR of scanlines, uncompressed or zipped, one part: those of tress and of Blender. ValueError for others."""
    with open(path, "rb") as file:
        data = file.read()
    if len(data) < 8 or struct.unpack_from("<I", data)[0] != 20000630:
        raise ValueError(f"{path}: not an EXR")
    if struct.unpack_from("<I", data, 4)[0] & 0x1a00:
        raise ValueError(f"{path}: an EXR of one part and scanlines is expected")
    attributes, at = _exr_header(data, 8)
    names, dtypes = _exr_channels(attributes["channels"])
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    dx0, dy0, dx1, dy1 = struct.unpack("<4i", attributes["displayWindow"])
    rows_of_block = {0: 1, 2: 1, 3: 16}.get(attributes["compression"][0])
    if rows_of_block is None:
        raise ValueError(f"{path}: an uncompressed or zipped EXR is expected")
    width, height = x1 - x0 + 1, y1 - y0 + 1
    channels = {name: np.empty((height, width), np.float32) for name in names}
    for offset in np.frombuffer(data, "<u8", -(-height // rows_of_block), at):
        y, size = struct.unpack_from("<ii", data, int(offset))
        rows = min(rows_of_block, y1 + 1 - y)
        raw = sum(d.itemsize for d in dtypes) * width * rows
        block = data[int(offset) + 8:int(offset) + 8 + size]
        _take_rows(block if size == raw else _unzip(block), y - y0, rows, width, names, dtypes, channels)
    return Picture(width, height, x0 - dx0, y0 - dy0, dx1 - dx0 + 1, dy1 - dy0 + 1, channels)


def _exr_header(data, at):
    attributes = {}
    while data[at] != 0:
        end = data.index(0, at)
        name = data[at:end].decode("latin-1")
        at = data.index(0, end + 1) + 1
        size, = struct.unpack_from("<i", data, at)
        attributes[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    return attributes, at + 1


def _exr_channels(text):
    names, dtypes, at = [], [], 0
    while text[at] != 0:
        end = text.index(0, at)
        names.append(text[at:end].decode("latin-1"))
        kind, = struct.unpack_from("<i", text, end + 1)
        dtypes.append(np.dtype(("<u4", "<f2", "<f4")[kind]))
        at = end + 17
    return names, dtypes


def _unzip(block):
    steps = np.frombuffer(zlib.decompress(block), np.uint8).astype(np.int64)
    steps[1:] -= 128
    halves = (np.cumsum(steps) & 255).astype(np.uint8)
    middle = (len(halves) + 1) // 2
    result = np.empty_like(halves)
    result[0::2], result[1::2] = halves[:middle], halves[middle:]
    return result.tobytes()


def _take_rows(block, first, rows, width, names, dtypes, channels):
    at = 0
    for row in range(first, first + rows):
        for name, dtype in zip(names, dtypes):
            channels[name][row] = np.frombuffer(block, dtype, width, at)
            at += dtype.itemsize * width
