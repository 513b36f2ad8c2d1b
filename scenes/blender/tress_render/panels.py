"""The panels of the render and view layer properties."""

import bpy


class Panel:
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    COMPAT_ENGINES = {"TRESS"}

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES


class TRESS_RENDER_PT_sampling(Panel, bpy.types.Panel):
    bl_label = "Sampling"

    def draw(self, context):
        layout, settings = self.layout, context.scene.tress
        layout.use_property_split = True
        layout.prop(settings, "stop")
        layout.prop(settings, "noise" if settings.stop == "NOISE" else "samples")
        layout.prop(settings, "denoise")
        layout.prop(settings, "max_depth")
        layout.prop(settings, "seed")
        layout.prop(settings, "seed_by_frame")


class TRESS_RENDER_PT_fibers(Panel, bpy.types.Panel):
    bl_label = "Fibers"

    def draw(self, context):
        layout, settings = self.layout, context.scene.tress
        layout.use_property_split = True
        layout.prop(settings, "model")
        layout.prop(settings, "estimator")
        layout.prop(settings, "own_epsilon", text="Set Epsilon")
        if settings.own_epsilon:
            layout.prop(settings, "epsilon")
        layout.prop(settings, "warm_cache")
        if settings.warm_cache:
            layout.prop(settings, "cache_mode")
        else:
            layout.prop(settings, "carry")


class TRESS_RENDER_PT_scene(Panel, bpy.types.Panel):
    bl_label = "Scale and Files"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, settings = self.layout, context.scene.tress
        layout.use_property_split = True
        layout.prop(settings, "own_scale")
        if settings.own_scale:
            layout.prop(settings, "cm_per_unit")
        layout.prop(settings, "keep_folder")


class TRESS_RENDER_PT_passes(Panel, bpy.types.Panel):
    bl_label = "tress Passes"
    bl_context = "view_layer"

    def draw(self, context):
        layout, settings, view_layer = self.layout, context.scene.tress, context.view_layer
        layout.use_property_split = True
        layout.prop(view_layer, "use_pass_z", text="Depth")
        layout.prop(view_layer, "use_pass_normal", text="Normal")
        for name in ("pass_albedo", "pass_coverage", "pass_lobes"):
            layout.prop(settings, name)


CLASSES = (TRESS_RENDER_PT_sampling, TRESS_RENDER_PT_fibers, TRESS_RENDER_PT_scene, TRESS_RENDER_PT_passes)
# Panels that are only right for engines with settings that tress has not.
OTHERS = ("VIEWLAYER_PT_filter", "VIEWLAYER_PT_layer_passes", "RENDER_PT_simplify", "RENDER_PT_gpencil",
          "RENDER_PT_freestyle", "MATERIAL_PT_preview", "WORLD_PT_mist")


def shared_panels():
    """Panels of Blender that serve any engine."""
    for panel in bpy.types.Panel.__subclasses__():
        engines = getattr(panel, "COMPAT_ENGINES", None)
        if not engines or panel.__name__ in OTHERS or panel.__name__.startswith(("TRESS_", "CYCLES_")):
            continue
        if "BLENDER_RENDER" in engines or {"BLENDER_EEVEE", "BLENDER_EEVEE_NEXT"} & engines and \
                panel.__name__.startswith(("DATA_PT_", "EEVEE_MATERIAL_PT_surface", "EEVEE_WORLD_PT_surface")):
            yield panel


def register():
    for kind in CLASSES:
        bpy.utils.register_class(kind)
    for panel in shared_panels():
        panel.COMPAT_ENGINES.add("TRESS")


def unregister():
    for panel in shared_panels():
        panel.COMPAT_ENGINES.discard("TRESS")
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
