"""What materials and worlds of Blender say, read from their nodes; by the names that 3.4 and 4.3 give to sockets."""

import math
import os

import numpy as np

from . import files, scene_keys


def surface_node(tree, warnings, who, kinds=None):
    """The node at the Surface of the active output. Behind mixes the first of `kinds` that is found, with a warning."""
    output = tree.get_output_node("ALL") or tree.get_output_node("CYCLES") or tree.get_output_node("EEVEE")
    node = _behind(output.inputs["Surface"]) if output else None
    if node is None or kinds is None or node.bl_idname in kinds:
        return node
    found = _first_of(node, kinds, set())
    if found:
        warnings(f"{who}: only its {found.bl_label} is used, not what it is mixed with")
    return found or node


def behind(socket):
    """The node that a socket is linked to, past reroutes, and the name of its output."""
    while socket.is_linked and socket.links:
        link = socket.links[0]
        if link.from_node.bl_idname != "NodeReroute":
            return link.from_node, link.from_socket.name
        socket = link.from_node.inputs[0]
    return None, None


def _behind(socket):
    return behind(socket)[0]


def _first_of(node, kinds, seen):
    if node is None or node.name in seen:
        return None
    seen.add(node.name)
    if node.bl_idname in kinds:
        return node
    for socket in node.inputs:
        found = _first_of(_behind(socket), kinds, seen)
        if found:
            return found
    return None


PLAIN_NODES = ("ShaderNodeValue", "ShaderNodeRGB")


def value(node, names, usual, warnings, who):
    """Of the first input of those names that there is: its own, or that of a value or color node it is linked to."""
    socket = next((node.inputs[name] for name in names if name in node.inputs), None)
    if socket is None:
        return usual
    linked = _behind(socket)
    if linked is not None and linked.bl_idname in PLAIN_NODES:
        return plain(linked.outputs[0].default_value)
    if linked is not None:
        warnings(not_taken(who, socket.name, linked.bl_label))
    return plain(socket.default_value)


def not_taken(who, socket_name, label):
    return f"{who}: {socket_name} is linked to {label}, which is not handed over: the value of the socket is used"


LUMINANCE = np.array((0.2126, 0.7152, 0.0722))


def plain(x):
    return float(x) if isinstance(x, (int, float)) else [float(v) for v in x][:3]


def along_strand(node, socket_name, as_value):
    """The source (scenes/README.md) of an input that is linked to a Color Ramp behind the Intercept of a Hair Info, or
    behind its Random where the ramp has two linear stops at its ends; None if it is not. as_value: of a color."""
    ramp = _behind(node.inputs[socket_name]) if socket_name in node.inputs else None
    if ramp is None or ramp.bl_idname != "ShaderNodeValToRGB":
        return None
    info, place = behind(ramp.inputs["Fac"])
    stops = [[min(max(float(stop.position), 0.0), 1.0), as_value(clamp3(stop.color))] for stop in ramp.color_ramp.elements]
    way = ramp.color_ramp.interpolation
    if info is None or info.bl_idname != "ShaderNodeHairInfo" or way not in ("LINEAR", "EASE", "CONSTANT"):
        return None
    if place == "Random" and way == "LINEAR" and [stop[0] for stop in stops] == [0.0, 1.0]:
        return {"random": [value for _, value in stops]}
    if place != "Intercept":
        return None
    if way == "CONSTANT":  # each stop's value holds up to the next one
        ends = [[next_place - 1e-4, value] for (_, value), (next_place, _) in zip(stops, stops[1:])]
        stops = [stop for pair in zip(stops, ends) for stop in pair] + stops[-1:]
    rising = [stop for stop, before in zip(stops, [[-1.0]] + stops) if stop[0] > before[0]]
    return {"ramp": rising, "along": "share", "interpolation": "smooth" if way == "EASE" else "linear"}


def azimuthal_roughness(principled):
    """The roughness by which `principled` takes colors."""
    return principled["roughness"] if "aspect_ratio" in principled else principled["radial_roughness"]


def _is_computed(node, socket_name):
    """Whether an input is linked to more than a value or a color."""
    linked = _behind(node.inputs[socket_name]) if socket_name in node.inputs else None
    return linked is not None and linked.bl_idname not in PLAIN_NODES


def hair_material(material, name, warnings):
    """Keys of a tress material, and its node if its strands are to take their color from it (bake.py), or None."""
    who = f"material {material.name}" if material else "hair without a material"
    keys = {"name": name}
    if material is None or not material.use_nodes:
        warnings(f"{who}: no nodes, brown hair is used")
        return keys, None
    node = surface_node(material.node_tree, warnings, who, ("ShaderNodeBsdfHairPrincipled",))
    if node is None:
        warnings(f"{who}: nothing at its surface, brown hair is used")
        return keys, None
    if node.bl_idname != "ShaderNodeBsdfHairPrincipled":
        keys["principled"] = _hair_from_surface(node, who, warnings)
        return keys, None
    said = lambda names, usual: value(node, names if isinstance(names, tuple) else (names,), usual, warnings, who)
    principled, varied = {}, None
    way = node.parametrization
    own = lambda name, usual: plain(node.inputs[name].default_value) if name in node.inputs else usual
    if way == "ABSORPTION":
        varied = node if _is_computed(node, "Absorption Coefficient") else None
        principled["sigma_a"] = (own if varied else said)("Absorption Coefficient", [0.245, 0.52, 1.365])
    elif way == "MELANIN":
        # A color stands for a value by its luminance.
        gray = lambda color: float(np.dot(color, LUMINANCE))
        along = along_strand(node, "Melanin", gray)
        computed = [name for name in ("Melanin", "Melanin Redness", "Tint", "Random Color") if _is_computed(node, name)]
        if _is_computed(node, "Random") and (computed or own("Random Color", 0.0) > 0):
            computed.append("Random")
        if computed and not (along and computed == ["Melanin"]):
            varied = node
        said_or_own = own if varied else said
        principled["melanin"] = along or said_or_own("Melanin", 0.8)
        principled["redness"] = said_or_own("Melanin Redness", 1.0)
        principled["random_color"] = said_or_own("Random Color", 0.0)
        tint = said_or_own("Tint", [1.0, 1.0, 1.0])
        if tint != [1.0, 1.0, 1.0]:
            principled["tint"] = tint
    else:
        along = along_strand(node, "Color", list)
        if along is None and _is_computed(node, "Color"):
            varied = node
            principled["color"] = own("Color", None)
        else:
            principled["color"] = along or said("Color", [0.018, 0.006, 0.002])
    principled["roughness"] = said("Roughness", 0.3)
    principled["eta"] = said("IOR", 1.55)
    principled["offset_deg"] = math.degrees(said("Offset", math.radians(2)))
    if getattr(node, "model", "CHIANG") == "HUANG":
        principled["aspect_ratio"] = said("Aspect Ratio", 0.85)
        gains = {lobe: said(socket, 1.0) for lobe, socket in
                 (("R", "Reflection"), ("TT", "Transmission"), ("TRT", "Secondary Reflection"))}
        if any(gain != 1 for gain in gains.values()):
            keys["gain"] = gains
    else:
        principled["radial_roughness"] = said("Radial Roughness", 0.3)
        principled["coat"] = said("Coat", 0.0)
    principled["random_roughness"] = said("Random Roughness", 0.0)
    keys["principled"] = principled
    return keys, varied


def _hair_from_surface(node, who, warnings):
    warnings(f"{who}: its {node.bl_label} is taken for Principled Hair of the same color")
    color = value(node, ("Base Color", "Color"), [0.18, 0.1, 0.06], warnings, who)
    return {"color": [min(max(c, 0.001), 0.999) for c in color] if isinstance(color, list) else [0.2] * 3}


def surface_material(material, folder, warnings):
    """Keys of a mesh of that material: albedo or albedo_file, coat."""
    who = f"material {material.name}" if material else "a mesh without a material"
    if material is None:
        return {"albedo": [0.8, 0.8, 0.8]}
    if not material.use_nodes:
        return {"albedo": clamp3(material.diffuse_color)}
    node = surface_node(material.node_tree, warnings, who, ("ShaderNodeBsdfPrincipled", "ShaderNodeBsdfDiffuse"))
    if node is None:
        warnings(f"{who}: nothing at its surface, black is used")
        return {"albedo": [0.0, 0.0, 0.0]}
    if node.bl_idname not in ("ShaderNodeBsdfPrincipled", "ShaderNodeBsdfDiffuse"):
        warnings(f"{who}: {node.bl_label} has no counterpart, grey is used")
        return {"albedo": [0.18, 0.18, 0.18]}
    is_diffuse = node.bl_idname == "ShaderNodeBsdfDiffuse"
    keys = _albedo(node.inputs["Color" if is_diffuse else "Base Color"], folder, who, warnings)
    if is_diffuse:
        return keys
    said = lambda names, usual: value(node, names, usual, warnings, who)
    level = said(("Specular IOR Level", "Specular"), 0.5)
    if level > 0.01:
        root = math.sqrt(min(0.08 * level, 0.18))
        keys["coat"] = {"roughness": min(max(said(("Roughness",), 0.5), 0.03), 1.0),
                        "eta": min(max((1 + root) / (1 - root), 1.01), 2.5)}
    emission = said(("Emission Color", "Emission"), [0.0] * 3)
    if max(emission) > 0 and said(("Emission Strength",), 1.0) > 0:
        warnings(f"{who}: meshes do not shine, its emission is left out")
    for names, what in ((("Metallic",), "metals"), (("Transmission Weight", "Transmission"), "glass"),
                        (("Subsurface Weight", "Subsurface"), "light beneath the surface"),
                        (("Coat Weight", "Clearcoat"), "a second coat")):
        if said(names, 0.0) > 0:
            warnings(f"{who}: no {what}; its surface is diffuse under one coat")
    if said(("Alpha",), 1.0) < 1:
        warnings(f"{who}: it is opaque here")
    return keys


def clamp3(color):
    return [min(max(float(c), 0.0), 1.0) for c in color][:3]


def _albedo(socket, folder, who, warnings):
    linked = _behind(socket)
    if linked is not None and linked.bl_idname == "ShaderNodeTexImage" and linked.image is not None:
        return {"albedo_file": image_file(linked.image, folder)}
    if linked is not None and linked.bl_idname == "ShaderNodeRGB":
        return {"albedo": clamp3(linked.outputs[0].default_value)}
    if linked is not None:
        warnings(f"{who}: its color is linked to {linked.bl_label}, which is not handed over: the socket's is used")
    return {"albedo": clamp3(socket.default_value)}


def image_file(image, folder):
    """The pixels of an image, linear, as an EXR in `folder`."""
    path = os.path.join(folder, f"image_{abs(hash(image.name_full)):x}.exr")
    if not os.path.exists(path):
        files.write_exr(path, image_pixels(image))
    return path


def image_pixels(image):
    """(height, width, 3), linear, top row first."""
    width, height = image.size
    if width == 0 or height == 0:
        raise ValueError(f"the image {image.name} cannot be read: {image.filepath}")
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    pixels = pixels.reshape(height, width, image.channels)[::-1]
    pixels = pixels[:, :, :3] if image.channels >= 3 else np.repeat(pixels[:, :, :1], 3, 2)
    if not image.is_float and image.colorspace_settings.name == "sRGB":
        pixels = linear(pixels)
    return np.maximum(pixels, 0)


def linear(encoded):
    """Of sRGB."""
    return np.where(encoded <= 0.04045, encoded / 12.92, ((np.maximum(encoded, 0) + 0.055) / 1.055) ** 2.4)


def environment(world, folder, warnings):
    """Keys of `environment`."""
    black = {"constant": [0.0, 0.0, 0.0]}
    if world is None:
        return black
    if not world.use_nodes:
        return {"constant": [float(c) for c in world.color]}
    node = surface_node(world.node_tree, warnings, f"world {world.name}", ("ShaderNodeBackground",))
    if node is None:
        return black
    who = f"world {world.name}"
    if node.bl_idname != "ShaderNodeBackground":
        warnings(f"{who}: {node.bl_label} has no counterpart, it is black")
        return black
    strength = value(node, ("Strength",), 1.0, warnings, who)
    picture = _behind(node.inputs["Color"])
    if picture is None or picture.bl_idname != "ShaderNodeTexEnvironment" or picture.image is None:
        color = value(node, ("Color",), [0.0] * 3, warnings, who)
        return {"constant": [float(c) * strength for c in color]}
    if picture.projection != "EQUIRECTANGULAR":
        warnings(f"{who}: mirror balls are taken for latitude and longitude")
    turn = _turn_of(_behind(picture.inputs["Vector"]), who, warnings)
    return scene_keys.environment_map(image_file(picture.image, folder), strength, turn)


def _turn_of(mapping, who, warnings):
    """Radians by which the picture is turned from above."""
    if mapping is None or mapping.bl_idname == "ShaderNodeTexCoord":
        return 0.0
    if mapping.bl_idname != "ShaderNodeMapping":
        warnings(f"{who}: {mapping.bl_label} before its picture is not handed over")
        return 0.0
    turn = [float(a) for a in mapping.inputs["Rotation"].default_value]
    if abs(turn[0]) > 1e-6 or abs(turn[1]) > 1e-6:
        warnings(f"{who}: its picture turns about the vertical only")
    return turn[2] if mapping.vector_type == "TEXTURE" else -turn[2]
