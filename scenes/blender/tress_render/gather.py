"""From the evaluated scene of Blender to the files of a tress scene."""

import json
import os

import bpy
import numpy as np

from . import bake, files, nodes, scene_keys

USUAL_RADIUS = 0.005  # units: of hair curves without radii, as Cycles has it
MESHES = {"MESH", "CURVE", "SURFACE", "META", "FONT"}
SILENT = {"EMPTY", "CAMERA", "ARMATURE", "LATTICE", "SPEAKER", "LIGHT_PROBE"}


class Export:
    """Writes one frame into `folder`; afterwards `keys` is the scene, and `warnings.said` what was left out."""

    def __init__(self, depsgraph, folder, cm, size, samples):
        self.depsgraph, self.folder, self.cm = depsgraph, folder, cm
        self.width, self.height = size
        self.warnings = scene_keys.Warnings()
        self.keys = {"image": {"width": self.width, "height": self.height, "samples": samples},
                     "lights": [], "meshes": [], "materials": [], "grooms": []}
        self._materials = {}  # by name: its keys, the socket of its color where that varies
        self._names = {}  # of grooms and meshes: the object that each is of
        self._links = []  # keys of a light, and its links where Blender has them

    def run(self, camera=None, shift_x=None):
        scene = self.depsgraph.scene_eval
        if scene.render.film_transparent:
            self.keys["image"]["transparent"] = True
        self._camera(camera or scene.camera, shift_x)
        self.keys["environment"] = nodes.environment(scene.world, self.folder, self.warnings)
        for instance in self.depsgraph.object_instances:
            self._object(instance)
        for keys, linking in self._links:
            for key, collection in (("light_link", linking.receiver_collection), ("shadow_link", linking.blocker_collection)):
                found = scene_keys.link(collection, self._names_of) if collection is not None else None
                keys.update({key: found} if found else {})
        if not self.keys["grooms"]:
            raise ValueError("no hair in this scene: tress renders hair curves and particle hair")
        path = os.path.join(self.folder, "scene.json")
        with open(path, "w", encoding="utf-8") as file:
            json.dump({key: value for key, value in self.keys.items() if value != []}, file, indent=1)
        return path

    def has_only_nodes_own_lobes(self):
        """Whether all hair is Principled Hair of round fibers, which the program draws by that node's own model."""
        used = {groom["material"] for groom in self.keys["grooms"]}
        return all("principled" in keys and "aspect_ratio" not in keys["principled"]
                   for keys in self.keys["materials"] if keys["name"] in used)

    # The camera and the lights.

    def _camera(self, camera, shift_x):
        if camera is None:
            raise ValueError("this scene has no camera")
        camera = camera.evaluated_get(self.depsgraph)
        data, render = camera.data, self.depsgraph.scene_eval.render
        matrix = np.array(camera.matrix_world)
        dof = None
        if data.dof.use_dof:
            distance = data.dof.focus_distance
            if data.dof.focus_object is not None:
                there = np.array(data.dof.focus_object.evaluated_get(self.depsgraph).matrix_world)[:3, 3]
                distance = abs(float((there - matrix[:3, 3]) @ scene_keys.axes(matrix)[0][2]))
            dof = {"fstop": data.dof.aperture_fstop, "distance": distance, "blades": data.dof.aperture_blades,
                   "rotation": data.dof.aperture_rotation, "ratio": data.dof.aperture_ratio}
        self.keys["camera"] = scene_keys.camera(
            matrix, self.cm, self.width, self.height, data.type, data.lens, data.ortho_scale, data.sensor_width,
            data.sensor_height, data.sensor_fit, data.shift_x if shift_x is None else shift_x, data.shift_y,
            render.pixel_aspect_x / render.pixel_aspect_y, dof, self.warnings)
        if render.use_motion_blur:
            self.warnings("motion blur is not handed over")

    def _light(self, name, light, matrix):
        who = f"light {name}"
        color, watts = np.array(light.color[:]), light.energy
        if light.use_nodes and light.node_tree is not None and self._has_nodes(light.node_tree):
            self.warnings(f"{who}: its nodes are not handed over, its color and power are")
        if light.type == "SUN":
            keys = scene_keys.sun(matrix, color, watts, light.angle)
        elif light.type == "AREA":
            keys = scene_keys.area(matrix, self.cm, color, watts, light.shape, light.size, light.size_y, light.spread,
                                   self.warnings, are_true_watts=bpy.app.version >= (4, 0))
        elif light.type == "SPOT":
            keys = scene_keys.spot(matrix, self.cm, color, watts, light.shadow_soft_size, light.spot_size, light.spot_blend)
        else:
            keys = scene_keys.point(matrix, self.cm, color, watts, light.shadow_soft_size)
        self.keys["lights"].append(keys)

    @staticmethod
    def _has_nodes(tree):
        emission = [node for node in tree.nodes if node.bl_idname == "ShaderNodeEmission"]
        plain = len(emission) == 1 and not any(socket.is_linked for socket in emission[0].inputs)
        return not (plain and emission[0].inputs["Strength"].default_value == 1)

    # What is to be seen.

    def _object(self, instance):
        ob = instance.object
        matrix = np.array(instance.matrix_world)
        if instance.show_self:
            if ob.type == "LIGHT":
                self._light(ob.name, ob.data, matrix)
                if hasattr(ob, "light_linking"):  # from 4.0 on
                    self._links.append((self.keys["lights"][-1], ob.original.light_linking))
            elif ob.type == "CURVES":
                self._curves(ob, matrix)
            elif ob.type in MESHES:
                self._mesh(ob, matrix)
            elif ob.type not in SILENT:
                self.warnings(f"{ob.name}: objects of type {ob.type.lower()} are not handed over")
        if instance.show_particles:
            for modifier in ob.modifiers:
                if modifier.type == "PARTICLE_SYSTEM" and modifier.show_render:
                    self._particles(ob, matrix, modifier)

    def _names_of(self, ob):
        return [name for name, of in self._names.items() if of == ob]

    def _free_name(self, ob, name):
        free, number = name, 1
        while free in self._names:
            number += 1
            free = f"{name} {number}"
        self._names[free] = ob.original
        return free

    def _file(self, name, ending):
        safe = "".join(c if c.isalnum() else "_" for c in name)
        return os.path.join(self.folder, f"{len(self.keys['grooms']) + len(self.keys['meshes'])}_{safe}.{ending}")

    def _hair_material(self, material):
        key = material.name if material else ""
        if key not in self._materials:
            keys, varied = nodes.hair_material(material, key or "hair", self.warnings)
            self.keys["materials"].append(keys)
            self._materials[key] = (keys, varied)
        return self._materials[key]

    def _colors(self, name, keys, varied, strands):
        """Of the points of strands, for a color that varies; None for one that does not."""
        if varied is None:
            return None
        try:
            colors = bake.hair_colors(
                varied, strands, nodes.azimuthal_roughness(keys["principled"]),
                lambda name, label: self.warnings(nodes.not_taken(f"material {keys['name']}", name, label)))
        except bake.Missing as what:
            self.warnings(f"{name}: no {what}, its hair is grey")
            colors = np.full((len(strands.of), 3), 0.5, np.float32)
        if colors is None:
            return None
        for key in ("melanin", "redness", "tint", "random_color", "sigma_a"):
            keys["principled"].pop(key, None)
        keys["principled"]["color"] = "file"
        return colors

    def _groom(self, ob, name, material, lengths, points, radii, colors):
        """points in world units."""
        long = lengths >= 2
        if not long.all():
            self.warnings(f"{name}: {int((~long).sum())} strands of one point are left out")
            keep = np.repeat(long, lengths)
            lengths, points, radii = lengths[long], points[keep], radii[keep]
            colors = None if colors is None else colors[keep]
        if len(lengths) == 0:
            return
        widths = 2 * radii * self.cm
        if not (widths.max() > 0):
            self.warnings(f"{name}: strands without any thickness, 0.08 mm are used")
            widths = np.full_like(widths, 0.008)
        path = self._file(name, "hair")
        files.write_hair(path, lengths, points * self.cm, widths, colors)
        keys = {"name": self._free_name(ob, name), "file": os.path.basename(path), "material": material, "up": "z",
                "cm_per_unit": 1.0, "basis": "clamped_catmull_rom"}  # as the viewport and Cycles draw it
        self.keys["grooms"].append(keys | hidden_from(ob))

    def _curves(self, ob, matrix):
        data = ob.data
        count = len(data.points)
        if count == 0:
            return
        points = np.empty(3 * count, np.float32)
        data.points.foreach_get("position", points)
        lengths = np.empty(len(data.curves), np.int32)
        data.curves.foreach_get("points_length", lengths)
        radii = np.full(count, USUAL_RADIUS, np.float32)
        if "radius" in data.attributes:
            data.attributes["radius"].data.foreach_get("value", radii)
        points = points.reshape(-1, 3)
        keys, varied = self._hair_material(ob.material_slots[0].material if ob.material_slots else None)
        colors = self._colors(ob.name, keys, varied, bake.Strands(
            lengths, points, lambda name: curve_uv(data, name), lambda name: curve_attribute(data, name, lengths)))
        self._groom(ob, ob.name, keys["name"], lengths, transformed(points, matrix), radii * mean_scale(matrix), colors)

    def _particles(self, ob, matrix, modifier):
        system = modifier.particle_system
        settings = system.settings
        if settings.type != "HAIR":
            self.warnings(f"{ob.name}: its emitted particles are not handed over, unless they are instances of objects")
            return
        if settings.render_type != "PATH":
            return
        parents, children = len(system.particles), len(system.child_particles)
        has_children = settings.child_type != "NONE" and children > 0
        numbers = range(parents, parents + children) if has_children else range(parents)
        steps = (1 << settings.render_step) + 1 + (settings.kink_extra_steps if settings.kink == "SPIRAL" else 0)
        points = np.array([system.co_hair(ob, particle_no=number, step=step) for number in numbers for step in range(steps)],
                          np.float32).reshape(-1, steps, 3)
        if len(points) == 0:
            return
        points, lengths, kept = without_repeats(points)
        if len(lengths) == 0:
            return
        radii = particle_radii(points, lengths, settings.root_radius, settings.tip_radius, settings.radius_scale,
                               settings.shape, settings.use_close_tip) * mean_scale(matrix)
        slots = ob.material_slots
        slot = min(settings.material, len(slots)) - 1
        keys, varied = self._hair_material(slots[slot].material if slots else None)

        def on_emitter(layers, ask, which, name):
            """(strands, 2 or 3) of the mesh beneath, or None."""
            layer = layers.find(name) if name else next((i for i, one in enumerate(layers) if one.active_render), -1)
            return None if layer < 0 else np.array([
                ask(modifier, particle=system.particles[min(numbers[i], parents - 1)], particle_no=numbers[i], **{which: layer})
                for i in kept])

        def paint(name):
            found = on_emitter(ob.data.vertex_colors, system.mcol_on_emitter, "vcol_no", name)
            return None if found is None else np.repeat(nodes.linear(found), lengths, axis=0)

        colors = self._colors(ob.name, keys, varied, bake.Strands(
            lengths, transformed(points, np.linalg.inv(matrix)),
            lambda name: on_emitter(ob.data.uv_layers, system.uv_on_emitter, "uv_no", name), paint))
        self._groom(ob, f"{ob.name}.{system.name}", keys["name"], lengths, points, radii, colors)

    def _mesh(self, ob, matrix):
        try:
            mesh = ob.to_mesh()
        except RuntimeError:
            return
        if mesh is None or len(mesh.polygons) == 0:
            ob.to_mesh_clear()
            return
        mesh.calc_loop_triangles()
        count = len(mesh.loop_triangles)
        positions = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get("co", positions)
        triangles, loops, slots = (np.empty(n, np.int32) for n in (3 * count, 3 * count, count))
        mesh.loop_triangles.foreach_get("vertices", triangles)
        mesh.loop_triangles.foreach_get("loops", loops)
        mesh.loop_triangles.foreach_get("material_index", slots)
        normals = corner_normals(mesh, matrix)[loops].reshape(count, 9)
        uvs = None
        if mesh.uv_layers.active is not None:
            uvs = np.empty(2 * len(mesh.loops), np.float32)
            mesh.uv_layers.active.data.foreach_get("uv", uvs)
            uvs = uvs.reshape(-1, 2)[loops].reshape(count, 6)
        positions = transformed(positions.reshape(-1, 3), matrix) * self.cm
        triangles = triangles.reshape(-1, 3)
        for slot in np.unique(slots):
            here = slots == slot
            material = ob.material_slots[min(slot, len(ob.material_slots) - 1)].material if ob.material_slots else None
            used, index = np.unique(triangles[here], return_inverse=True)
            path = self._file(ob.name, "obj")
            files.write_obj(path, positions[used], index.reshape(-1, 3), normals[here].reshape(-1, 3),
                            None if uvs is None else uvs[here].reshape(-1, 2))
            keys = {"name": self._free_name(ob, ob.name), "file": os.path.basename(path)}
            keys.update(nodes.surface_material(material, self.folder, self.warnings))
            if "albedo_file" in keys and uvs is None:
                self.warnings(f"{ob.name}: no texture coordinates, grey in place of its picture")
                keys["albedo"] = [0.18] * 3
                del keys["albedo_file"]
            keys.update(hidden_from(ob))
            if getattr(ob, "is_holdout", False) and "visible" not in keys:
                keys["holdout"] = True
            self.keys["meshes"].append(keys)
        ob.to_mesh_clear()


def curve_uv(data, name):
    """(strands, 2) of hair curves: as Cycles has it the first pair of numbers by strand, unless it is named."""
    pairs = [layer for layer in data.attributes if layer.data_type == "FLOAT2" and layer.domain == "CURVE"]
    found = data.attributes.get(name) if name else data.attributes.get("surface_uv_coordinate") or next(iter(pairs), None)
    return values_of(found, "vector", 2) if found in pairs else None


def curve_attribute(data, name, lengths):
    """(points, 3 or 1) of hair curves."""
    found = data.attributes.get(name) if name else data.color_attributes.active_color
    sizes = {"FLOAT_COLOR": ("color", 4), "BYTE_COLOR": ("color", 4), "FLOAT_VECTOR": ("vector", 3), "FLOAT": ("value", 1)}
    if found is None or found.data_type not in sizes:
        return None
    values = values_of(found, *sizes[found.data_type])[:, :3]
    return np.repeat(values, lengths, axis=0) if found.domain == "CURVE" else values


def values_of(attribute, key, size):
    values = np.empty(size * len(attribute.data), np.float32)
    attribute.data.foreach_get(key, values)
    return values.reshape(-1, size)


def hidden_from(ob):
    """Keys for the rays that do not meet an object."""
    switches = {"visible": "visible_camera", "casts_shadow": "visible_shadow"}
    return {key: False for key, switch in switches.items() if not getattr(ob, switch, True)}


def transformed(points, matrix):
    return (points.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]).astype(np.float32)


def mean_scale(matrix):
    return float(abs(np.linalg.det(matrix[:3, :3])) ** (1 / 3))


def corner_normals(mesh, matrix):
    """(loops, 3), in the world."""
    normals = np.empty(3 * len(mesh.loops), np.float32)
    if hasattr(mesh, "corner_normals"):  # from 4.1 on
        mesh.corner_normals.foreach_get("vector", normals)
    else:
        mesh.calc_normals_split()
        mesh.loops.foreach_get("normal", normals)
    turned = normals.reshape(-1, 3) @ np.linalg.inv(matrix[:3, :3])
    return turned / np.maximum(np.linalg.norm(turned, axis=1, keepdims=True), 1e-20)


def without_repeats(points):
    """points: (strands, steps, 3). Points that equal the one before them go, and strands of one place; the numbers of
    those that are left are returned last."""
    moves = np.ones(points.shape[:2], bool)
    moves[:, 1:] = (points[:, 1:] != points[:, :-1]).any(2)
    moves[moves.sum(1) < 2] = False
    lengths = moves.sum(1)
    return points[moves], lengths[lengths > 0], np.flatnonzero(lengths)


def particle_radii(points, lengths, root, tip, scale, shape, close_tip):
    """Of the points of particle hair, as Cycles has them: by the share of the length of the strand."""
    share = 1 - bake.along(points, lengths)[0]
    share = np.clip(share, 0, 1) ** (1 + shape if shape < 0 else 1 / (1 - min(shape, 0.999)))
    radii = scale * 0.5 * (share * (root - tip) + tip)
    if close_tip:
        radii[np.cumsum(lengths) - 1] = 0
    return radii
