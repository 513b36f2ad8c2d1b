"""Scenes for the tests, made by script within Blender: hair curves and particle hair, lights, a camera."""

import math

import bpy
import numpy as np
from mathutils import Vector


def empty_scene(width=48, height=64):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = width, height
    scene.render.resolution_percentage = 100
    scene.view_settings.view_transform = "Standard"
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    return scene


def link(scene, name, data):
    ob = bpy.data.objects.new(name, data)
    scene.collection.objects.link(ob)
    return ob


def add_camera(scene, eye=(0, -1.0, 0.05), target=(0, 0, 0), lens=50.0):
    data = bpy.data.cameras.new("camera")
    data.lens = lens
    camera = link(scene, "camera", data)
    camera.location = eye
    camera.rotation_euler = (Vector(target) - Vector(eye)).to_track_quat("-Z", "Y").to_euler()
    scene.camera = camera
    return camera


def add_light(scene, kind, location, energy, target=(0, 0, 0), **settings):
    data = bpy.data.lights.new(kind.lower(), kind)
    data.energy = energy
    for name, value in settings.items():
        setattr(data, name, value)
    light = link(scene, kind.lower(), data)
    light.location = location
    light.rotation_euler = (Vector(target) - Vector(location)).to_track_quat("-Z", "Y").to_euler()
    return light


def hair_material(name="hair", **inputs):
    """Principled Hair with these inputs, by names with _ for blanks; parametrization and model are its enums."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    node = tree.nodes.new("ShaderNodeBsdfHairPrincipled")
    if hasattr(node, "model"):
        node.model = inputs.pop("model", "CHIANG")
    node.parametrization = inputs.pop("parametrization", "MELANIN")
    for key, value in inputs.items():
        socket = node.inputs[key.replace("_", " ")]
        socket.default_value = (*value, 1.0) if socket.type == "RGBA" and len(value) == 3 else value
    tree.links.new(node.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return material


def strands(count=300, points=9, length=0.3, seed=5):
    """(count, points, 3): a wavy lock that hangs from a disk of 6 cm."""
    random = np.random.default_rng(seed)
    angle, away = random.uniform(0, 2 * math.pi, count), 0.06 * np.sqrt(random.uniform(0, 1, count))
    t = np.linspace(0, 1, points)[None, :]
    phase, wave = random.uniform(0, 2 * math.pi, (count, 1)), 0.008
    x = (away * np.cos(angle))[:, None] * (1 - 0.4 * t) + wave * t * np.sin(9 * t + phase)
    y = (away * np.sin(angle))[:, None] * (1 - 0.4 * t) + wave * t * np.cos(9 * t + phase)
    return np.stack([x, y, length * (0.5 - t) + 0 * x], 2).astype(np.float32)


def add_hair_curves(scene, points, material, radius=0.0006, tip=0.3, name="lock"):
    """Hair curves of those points, by geometry nodes, which 3.4 needs for more than an empty object."""
    count, per_strand, _ = points.shape
    curves = bpy.data.hair_curves.new(name)
    if hasattr(curves, "add_curves"):  # from 4.0 on
        curves.add_curves([per_strand] * count)
        curves.points.foreach_set("position", points.reshape(-1))
        radii = np.tile(np.linspace(1, tip, per_strand), count).astype(np.float32) * radius
        (curves.attributes.get("radius") or curves.attributes.new("radius", "FLOAT", "POINT")).data.foreach_set("value", radii)
        hair = link(scene, name, curves)
    else:
        hair = link(scene, name, curves)
        hair.modifiers.new("strands", "NODES").node_group = _strand_nodes(scene, points, radius, tip, material)
    curves.materials.append(material)
    return hair


def _strand_nodes(scene, points, radius, tip, material):
    count, per_strand, _ = points.shape
    mesh = bpy.data.meshes.new("strands")
    mesh.vertices.add(count * per_strand)
    mesh.vertices.foreach_set("co", points.reshape(-1))
    index = np.arange(count * per_strand).reshape(count, per_strand)
    edges = np.stack([index[:, :-1], index[:, 1:]], 2).reshape(-1, 2).astype(np.int32)
    mesh.edges.add(len(edges))
    mesh.edges.foreach_set("vertices", edges.reshape(-1))
    thickness = mesh.attributes.new("thickness", "FLOAT", "POINT")
    thickness.data.foreach_set("value", np.tile(np.linspace(1, tip, per_strand), count).astype(np.float32) * radius)
    mesh.update()
    source = link(scene, "strands", mesh)
    source.hide_render = True
    group = bpy.data.node_groups.new("strands", "GeometryNodeTree")
    group.inputs.new("NodeSocketGeometry", "Geometry")
    group.outputs.new("NodeSocketGeometry", "Geometry")
    make = group.nodes.new
    make("NodeGroupInput")
    info, to_curve, set_radius = make("GeometryNodeObjectInfo"), make("GeometryNodeMeshToCurve"), make("GeometryNodeSetCurveRadius")
    info.inputs["Object"].default_value = source
    attribute = make("GeometryNodeInputNamedAttribute")
    attribute.data_type = "FLOAT"
    attribute.inputs["Name"].default_value = "thickness"
    paint = make("GeometryNodeSetMaterial")
    paint.inputs["Material"].default_value = material
    result = make("NodeGroupOutput")
    for a, b in ((info.outputs["Geometry"], to_curve.inputs[0]), (to_curve.outputs[0], set_radius.inputs[0]),
                 (next(o for o in attribute.outputs if o.enabled), set_radius.inputs["Radius"]),
                 (set_radius.outputs[0], paint.inputs[0]), (paint.outputs[0], result.inputs[0])):
        group.links.new(a, b)
    return group


def add_particle_hair(scene, material, skin, count=200, length=0.02):
    """Fur on a ball: a mesh with a hair system and simple children."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=16, ring_count=8, radius=0.05)
    ball = bpy.context.object
    ball.data.materials.append(skin)
    ball.data.materials.append(material)
    ball.modifiers.new("fur", "PARTICLE_SYSTEM")
    settings = ball.particle_systems[0].settings
    settings.type = "HAIR"
    settings.count, settings.hair_length, settings.hair_step = count, length, 4
    settings.render_step, settings.material = 3, 2
    settings.root_radius, settings.tip_radius, settings.radius_scale = 1.0, 0.2, 0.001
    settings.child_type, settings.rendered_child_count = "SIMPLE", 5
    return ball
