"""Colors of hair from the nodes that compute them, at every point of its strands, as Cycles evaluates them.

An absorption is stored as the color for which `principled` has it, its multiple scattering albedo (Chiang and others
2016, 4.2); above about 3.7 per radius, where hair is black, it is 3.7.
"""

import numpy as np

from . import nodes


class Unknown(ValueError):
    """A node without a counterpart, by its label."""


class Missing(ValueError):
    """What the strands do not have: texture coordinates or an attribute, by name."""


class Strands:
    """What nodes may ask of strands.

    lengths: points of each strand. points: (n, 3), in the units of the object. uv(name): (strands, 2), of that name or,
    for "", the usual ones; None if there are none. attribute(name): (n, k), likewise.
    """

    def __init__(self, lengths, points, uv, attribute):
        self.of = np.repeat(np.arange(len(lengths)), lengths)
        self.along, self.length = along(points, lengths)
        self.uv, self.attribute = uv, attribute


def along(points, lengths):
    """Of each point the share of its strand's length before it; the length of each strand."""
    steps = np.zeros(len(points))
    steps[1:] = np.linalg.norm(np.diff(points.astype(float), axis=0), axis=1)
    ends = np.cumsum(lengths)
    starts = ends - lengths
    steps[starts] = 0
    reached = np.cumsum(steps)
    reached -= np.repeat(reached[starts], lengths)
    return reached / np.maximum(np.repeat(reached[ends - 1], lengths), 1e-30), reached[ends - 1]


def colors(socket, strands):
    """(points, 3), linear, within 0 to 1: the value of an input, by the nodes behind it. Raises Unknown or Missing."""
    found = np.clip(_value(socket, strands), 0, 1).astype(np.float32)
    return np.ascontiguousarray(np.broadcast_to(found, (len(strands.of), 3)))


EUMELANIN, PHEOMELANIN = np.array((0.506, 0.841, 1.653)), np.array((0.343, 0.733, 1.924))


def hair_colors(node, strands, azimuthal, unknown):
    """The same of Principled Hair, whichever its parametrization; None if nothing behind its inputs has a counterpart.
    azimuthal: the roughness by which `principled` takes colors. unknown(input, label): is called for each input behind
    which there is a node without counterpart; its own value is used. Raises Missing."""
    known = []

    def ask(name, how=_value):
        socket = node.inputs[name]
        try:
            found = how(socket, strands)
            known.extend([name] if socket.is_linked else [])
            return found
        except Unknown as label:
            unknown(name, label)
            return np.atleast_2d(nodes.plain(socket.default_value))

    if node.parametrization == "COLOR":
        found = np.clip(ask("Color"), 0, 1)
    else:
        if node.parametrization == "ABSORPTION":
            sigma_a = np.maximum(ask("Absorption Coefficient"), 0)
        else:
            number = lambda name: np.clip(ask(name, _number), 0, 1)
            is_given = "Random" in node.inputs and node.inputs["Random"].is_linked
            random = number("Random") if is_given else _hash(strands.of[-1] + 1)[strands.of, None]
            melanin = number("Melanin") * (1 + 2 * (random - 0.5) * number("Random Color"))
            redness = number("Melanin Redness")
            sigma_a = -np.log(np.maximum(1 - melanin, 1e-4)) * ((1 - redness) * EUMELANIN + redness * PHEOMELANIN)
            sigma_a = sigma_a + (np.log(np.clip(ask("Tint"), 1e-5, 1)) / _albedo_slope(azimuthal)) ** 2
        found = np.exp(-_albedo_slope(azimuthal) * np.sqrt(sigma_a))
    return np.ascontiguousarray(np.broadcast_to(found.astype(np.float32), (len(strands.of), 3))) if known else None


def _albedo_slope(azimuthal):
    return np.polynomial.polynomial.polyval(azimuthal, (5.969, -0.215, 2.532, -10.73, 5.574, 0.245))


def _value(socket, strands):
    """(points or 1, 3 or 1)."""
    node, output = nodes.behind(socket)
    if node is None:
        return np.atleast_2d(nodes.plain(socket.default_value))
    if node.bl_idname not in KNOWN:
        raise Unknown(node.bl_label)
    return KNOWN[node.bl_idname](node, output, strands)


def _number(socket, strands):
    x = _value(socket, strands)
    return x if x.shape[1] == 1 else x @ nodes.LUMINANCE[:, None]


def _own(node, output, strands):
    return np.atleast_2d(nodes.plain(node.outputs[0].default_value))


def _hair_info(node, output, strands):
    if output == "Intercept":
        return strands.along[:, None]
    if output == "Length":
        return strands.length[strands.of, None]
    if output == "Random":
        return _hash(strands.of[-1] + 1)[strands.of, None]
    raise Unknown(f"{output} of {node.bl_label}")


def _hash(count):
    """Cycles' random number of each strand: hash_uint2(strand, 0), by Jenkins' lookup3."""
    y = np.full(count, 0xdeadbeef + 8 + 13, np.uint32)
    x, z = y, y + np.arange(count, dtype=np.uint32)
    for k in (14, 11, 25, 16, 4, 14, 24):
        x, y, z = z, (x ^ y) - (y << np.uint32(k) | y >> np.uint32(32 - k)), y
    return y / 0xffffffff


def _ramp(node, output, strands):
    table = np.array([node.color_ramp.evaluate(i / 255) for i in range(256)])  # as fine as Cycles' own
    at = np.clip(_number(node.inputs["Fac"], strands)[:, 0], 0, 1) * 255
    below = at.astype(int)
    share = (at - below)[:, None] * (node.color_ramp.interpolation != "CONSTANT")
    found = (1 - share) * table[below] + share * table[np.minimum(below + 1, 255)]
    return found[:, 3:] if output == "Alpha" else found[:, :3]


def _map_range(node, output, strands):
    if node.data_type != "FLOAT" or node.interpolation_type != "LINEAR":
        raise Unknown(f"{node.bl_label} that is not linear")
    x, from_min, from_max, to_min, to_max = (
        _number(node.inputs[name], strands) for name in ("Value", "From Min", "From Max", "To Min", "To Max"))
    span = from_max - from_min
    found = to_min + (to_max - to_min) * np.where(span != 0, (x - from_min) / np.where(span != 0, span, 1), 0)
    return np.clip(found, np.minimum(to_min, to_max), np.maximum(to_min, to_max)) if node.clamp else found


BLENDS = {"MIX": lambda a, b: b, "ADD": lambda a, b: a + b, "SUBTRACT": lambda a, b: a - b,
          "MULTIPLY": lambda a, b: a * b, "SCREEN": lambda a, b: 1 - (1 - a) * (1 - b),
          "DARKEN": np.minimum, "LIGHTEN": np.maximum, "DIFFERENCE": lambda a, b: np.abs(a - b)}


def _mix(node, output, strands):
    is_old = node.bl_idname == "ShaderNodeMixRGB"
    kind = "RGBA" if is_old else node.data_type
    way = node.blend_type if kind == "RGBA" else "MIX"
    if kind not in ("RGBA", "FLOAT") or way not in BLENDS:
        raise Unknown(f"{node.bl_label} ({kind.lower()}, {way.lower()})")
    first = 1 if is_old else {"FLOAT": 2, "RGBA": 6}[kind]  # sockets of one name for each kind of data
    share = _number(node.inputs[0], strands)
    if is_old or node.clamp_factor:
        share = np.clip(share, 0, 1)
    a, b = (_value(node.inputs[i], strands) for i in (first, first + 1))
    found = (1 - share) * a + share * BLENDS[way](a, b)
    return np.clip(found, 0, 1) if (node.use_clamp if is_old else node.clamp_result) else found


def _image(node, output, strands):
    place, which = nodes.behind(node.inputs["Vector"])
    is_uv_map = place is not None and place.bl_idname == "ShaderNodeUVMap"
    if not (place is None or is_uv_map or (place.bl_idname == "ShaderNodeTexCoord" and which == "UV")):
        raise Unknown(f"{place.bl_label} before a picture")
    if node.image is None or node.image.source == "TILED" or node.projection != "FLAT" or output != "Color":
        raise Unknown(f"{node.bl_label} without a plain picture")
    uv = strands.uv(place.uv_map if is_uv_map else "")
    if uv is None:
        raise Missing("texture coordinates")
    return looked_up(nodes.image_pixels(node.image), uv, node.extension, node.interpolation == "Closest")[strands.of]


def looked_up(pixels, uv, extension="REPEAT", nearest=False):
    """Bilinear, or of the nearest pixel: (n, 3) at uv, (n, 2); pixels: (height, width, 3), top row first."""
    height, width, _ = pixels.shape
    at = np.asarray(uv, float) * (width, height) - (0 if nearest else 0.5)
    low = np.floor(at).astype(int)
    share = (at - low) * (not nearest)
    fit = np.mod if extension == "REPEAT" else lambda i, n: np.clip(i, 0, n - 1)
    found = 0
    for dx in (0, 1):
        for dy in (0, 1):
            weight = np.abs(1 - dx - share[:, 0]) * np.abs(1 - dy - share[:, 1])
            found = found + weight[:, None] * pixels[height - 1 - fit(low[:, 1] + dy, height), fit(low[:, 0] + dx, width)]
    outside = ((uv < 0) | (uv > 1)).any(1) & (extension == "CLIP")
    return np.where(outside[:, None], 0, found)


def _attribute(node, output, strands):
    name = node.attribute_name if node.bl_idname == "ShaderNodeAttribute" else node.layer_name
    if getattr(node, "attribute_type", "GEOMETRY") != "GEOMETRY" or output == "Alpha":
        raise Unknown(f"{output} of {node.bl_label}")
    found = strands.attribute(name)
    if found is None:
        raise Missing(f"color attribute {name!r}")
    return found.mean(1, keepdims=True) if output == "Fac" else found


KNOWN = {"ShaderNodeHairInfo": _hair_info, "ShaderNodeValToRGB": _ramp, "ShaderNodeMapRange": _map_range,
         "ShaderNodeMixRGB": _mix, "ShaderNodeMix": _mix, "ShaderNodeTexImage": _image, "ShaderNodeRGB": _own,
         "ShaderNodeValue": _own, "ShaderNodeAttribute": _attribute, "ShaderNodeVertexColor": _attribute}
