"""tress as a render engine: F12 exports the frame, starts the program, and shows what it saves on the way."""

import os
import shutil
import tempfile
import time

import bpy
import numpy as np

from . import files, gather, job, scene_keys

LOBES = ("R", "TT", "TRT", "TRRT", "residual", "surface", "background")
FAR = 1e10  # depth where nothing was met, as Cycles has it


def passes_of(scene, view_layer):
    """Beside Combined: name, components, type, and whether Blender has the pass itself."""
    settings = scene.tress
    passes = [("Noisy Image", "RGBA", "COLOR", False)] if settings.denoise else []
    if view_layer.use_pass_z:
        passes.append(("Depth", "Z", "VALUE", True))
    if view_layer.use_pass_normal:
        passes.append(("Normal", "XYZ", "VECTOR", True))
    if settings.pass_albedo:
        passes.append(("Albedo", "RGB", "COLOR", False))
    if settings.pass_coverage:
        passes.append(("Coverage", "X", "VALUE", False))
    if settings.pass_lobes:
        passes += [(lobe[0].upper() + lobe[1:], "RGB", "COLOR", False) for lobe in LOBES]
    return passes


class TressRenderEngine(bpy.types.RenderEngine):
    bl_idname = "TRESS"
    bl_label = "tress"
    bl_use_preview = False
    bl_use_shading_nodes_custom = False
    bl_use_eevee_viewport = True  # the viewport shows materials as Eevee does

    def update_render_passes(self, scene=None, renderlayer=None):
        self.register_pass(scene, renderlayer, "Combined", 4, "RGBA", "COLOR")
        for name, components, kind, _ in passes_of(scene, renderlayer):
            self.register_pass(scene, renderlayer, name, len(components), components, kind)

    def render(self, depsgraph):
        scene = depsgraph.scene
        folder, is_kept = export_folder(scene)
        try:
            self._render(depsgraph, scene, folder)
        except (OSError, ValueError) as error:
            self.error_set(f"tress: {error}")
            self.report({"ERROR"}, f"tress: {error}")
        finally:
            if not is_kept:
                shutil.rmtree(folder, ignore_errors=True)

    def _render(self, depsgraph, scene, folder):
        program = job.find_program(preferences().program)
        self.update_stats("", "tress: exporting the scene")
        size = size_of(scene)
        export = gather.Export(depsgraph, folder, cm_per_unit(scene), size, scene.tress.samples)
        export.run(self.camera_override, self.camera_shift_x(scene.camera) if scene.camera else None)
        for sentence in export.warnings.said:
            self.report({"WARNING"}, "tress: " + sentence)
        window = (0, 0) + size
        if scene.render.use_border:
            border = scene.render
            window = scene_keys.crop((border.border_min_x, border.border_min_y, border.border_max_x, border.border_max_y),
                                     *size)
        options = options_of(scene, window if scene.render.use_border else None, self.is_animation, export.has_only_nodes_own_lobes())
        settings = scene.tress
        pixels = (window[2] - window[0]) * (window[3] - window[1])
        by_noise = settings.stop == "NOISE"
        child = job.Job(program, folder, options, pixels, None if by_noise else settings.samples,
                        settings.noise if by_noise else None)
        try:
            self._follow(child, depsgraph, scene, window, export)
        finally:
            child.end()

    def _follow(self, child, depsgraph, scene, window, export):
        width, height = window[2] - window[0], window[3] - window[1]
        view_layer = depsgraph.view_layer
        passes = passes_of(scene, view_layer)
        for name, components, _, is_known in passes:
            if not is_known:
                self.add_pass(name, len(components), components, layer=view_layer.name)
        result = self.begin_result(0, 0, width, height, layer=view_layer.name)
        layer = result.layers[0]
        cancelled = False
        while child.running():
            if self.test_break():
                self.update_stats("", "tress: saving what was learned")
                child.end()
                cancelled = True
                break
            status = child.status()
            if status:
                self.update_progress(status.share)
                self.update_stats("", "tress: " + status.text)
            if child.new_picture():
                show(layer, passes, child.picture, export)
                self.update_result(result)
            time.sleep(0.05)
        failed = child.close() != 0 and not cancelled
        if not failed and os.path.exists(child.picture):
            show(layer, passes, child.picture, export)
        self.end_result(result, cancel=cancelled or failed)
        for line in child.warnings():
            self.report({"WARNING"}, line)
        if failed:
            raise ValueError(child.error())


def show(layer, passes, path, export):
    """Puts the layers of a picture of tress into the passes."""
    picture = files.read_exr(path)
    fill(layer.passes["Combined"], picture, [picture.channels.get("denoised." + c, picture.channels[c]) for c in "RGBA"])
    for name, components, _, _ in passes:
        if name in layer.passes:
            fill(layer.passes[name], picture, pass_channels(name, components, picture, export))


def pass_channels(name, components, picture, export):
    if name == "Depth":
        met = picture.channels["coverage"] > 0
        planar = picture.channels["Z"] * view_cosines(picture, export) / export.cm
        return [np.where(met, planar, FAR)]
    if name == "Noisy Image":
        return [picture.channels[c] for c in components]
    if name == "Coverage":
        return [picture.channels["coverage"]]
    prefix = {"Normal": "N", "Albedo": "albedo", "Residual": "residual", "Surface": "surface",
              "Background": "background"}.get(name, name)
    black = np.zeros((picture.height, picture.width), np.float32)
    return [picture.channels.get(f"{prefix}.{c}", black) for c in components]


def view_cosines(picture, export):
    """Between the ray of each pixel and the view: depth is counted along the view."""
    camera = export.keys["camera"]
    if "orthographic_height_cm" in camera:
        return 1.0
    whole = picture.whole_width if camera["sensor_fit"] == "width" else picture.whole_height
    pixel = camera["sensor_mm"] / camera["focal_length_mm"] / whole
    x = (picture.left + np.arange(picture.width) + 0.5 - picture.whole_width / 2) + camera.get("shift_x", 0) * picture.whole_width
    y = (picture.top + np.arange(picture.height) + 0.5 - picture.whole_height / 2) - camera.get("shift_y", 0) * picture.whole_height
    return 1 / np.sqrt(1 + (pixel * x[None, :]) ** 2 + (pixel * y[:, None]) ** 2)


def fill(render_pass, picture, channels):
    pixels = np.stack(channels, 2).astype(np.float32)[::-1]
    flat = np.ascontiguousarray(pixels).reshape(-1, len(channels))
    try:
        render_pass.rect.foreach_set(flat.reshape(-1))
    except (AttributeError, TypeError):
        render_pass.rect = flat


def size_of(scene):
    render = scene.render
    return (render.resolution_x * render.resolution_percentage // 100,
            render.resolution_y * render.resolution_percentage // 100)


def cm_per_unit(scene):
    settings = scene.tress
    if settings.own_scale:
        return settings.cm_per_unit
    units = scene.unit_settings
    return 100.0 * (units.scale_length if units.system != "NONE" else 1.0)


def options_of(scene, window, is_animation=False, has_only_nodes_own_lobes=False):
    """Of the command line. The program chooses the model by the materials alone, as for everybody; that of hair that has
    only lobes of the node's own learns no rows, so that an animation has none to carry."""
    settings, render = scene.tress, scene.render
    options = ["--noise", repr(settings.noise)] if settings.stop == "NOISE" else ["--spp", str(settings.samples)]
    options = [*options, "--seed", str(settings.seed + (scene.frame_current if settings.seed_by_frame else 0)),
               "--set", f"integrator/max_depth={settings.max_depth}"]
    if settings.denoise:
        options.append("--denoise")
    if settings.model != "default":
        options += ["--model", settings.model]
    learns = settings.model in ("default", "elliptical", "rough")
    carries = learns and settings.estimator != "exact" and not (settings.model == "default" and has_only_nodes_own_lobes)
    if learns:
        if settings.estimator != "fitted":  # said without need, it would be refused for models without rows
            options += ["--estimator", settings.estimator]
        if settings.own_epsilon:
            options += ["--epsilon", f"{settings.epsilon:g}"]
    if render.threads_mode == "FIXED":
        options += ["--threads", str(render.threads)]
    if settings.warm_cache:
        options += ["--warm-cache", bpy.path.abspath(settings.warm_cache), "--cache-mode", settings.cache_mode]
    elif is_animation and settings.carry and bpy.app.tempdir and carries:
        options += ["--warm-cache", os.path.join(bpy.app.tempdir, "tress_animation.cache")]
    if window is not None:
        options += ["--crop", ",".join(str(x) for x in window)]
    return options


def export_folder(scene):
    """Where the files of a render go, and whether they stay."""
    kept = scene.tress.keep_folder
    if kept:
        folder = bpy.path.abspath(kept)
        os.makedirs(folder, exist_ok=True)
        return folder, True
    return tempfile.mkdtemp(prefix="tress_", dir=bpy.app.tempdir or None), False


def preferences():
    return bpy.context.preferences.addons[__package__].preferences
