"""What an artist sets: of the scene, and once of the add-on."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

MODELS = (("default", "Default", "By the materials alone: hair that is all Principled Hair by that node's own model; else Rough"),
          ("rough", "Rough", "Rough elliptical fibers, learned from traced paths: nearest to the truth"),
          ("elliptical", "Elliptical", "Lobes of one width each, learned tables: learns faster, less near to the truth"),
          ("chiang2016", "Chiang 2016", "Circular fibers, the model of Cycles' Principled Hair"),
          ("fiber3d", "Traced", "Every fiber traced in three dimensions: slow, the truth"))


class TressSettings(bpy.types.PropertyGroup):
    model: EnumProperty(name="Model", items=MODELS, default="default")
    estimator: EnumProperty(name="Estimator", default="fitted", items=(
        ("fitted", "Fitted", "Learned rows answer"),
        ("corrected", "Corrected", "They do, and one vertex in 16 is traced to mend their bias. Of the model Elliptical"),
        ("exact", "Exact", "Traced at every vertex, six to eight times slower")))
    own_epsilon: BoolProperty(name="Epsilon", default=False, description="Set how well rows are learned, of models that have rows: Rough and Elliptical")
    epsilon: FloatProperty(name="Epsilon", default=0.01, min=1e-6, max=1, precision=4,
                           description="Error under which a row is learned: of Rough chi-square, of Elliptical the relative squared error")
    stop: EnumProperty(name="Until", default="SAMPLES", items=(
        ("SAMPLES", "Samples", "So many samples a pixel"), ("NOISE", "Noise", "Until the picture has so little noise")))
    samples: IntProperty(name="Samples", default=64, min=1, max=1000000)
    noise: FloatProperty(name="Noise", default=0.05, min=0.0001, max=1, precision=3,
                         description="Relative to the brightness of what is covered")
    denoise: BoolProperty(name="Denoise", default=False,
                          description="Filter the picture along its hair at the end; as it was rendered it is in the pass Noisy Image")
    max_depth: IntProperty(name="Bounces", default=256, min=1, max=4096, description="Hits of a path")
    seed: IntProperty(name="Seed", default=0, min=0)
    seed_by_frame: BoolProperty(name="By Frame", default=True, description="Frames have different grain")
    warm_cache: StringProperty(name="Warm Cache", subtype="FILE_PATH",
                               description="What was learned, for the next frame and the next shot. default: the cache folder of the user")
    cache_mode: EnumProperty(name="Cache Mode", default="append", items=(
        ("append", "Append", "Load, learn, save"), ("frozen", "Frozen", "Use it as it is, never save"),
        ("scratch", "Scratch", "Begin anew and replace it"), ("require", "Require", "Append; an error where it is missing")))
    carry: BoolProperty(name="Carry Learning", default=True,
                        description="Frames of an animation without a warm cache begin with what those before have learned")
    own_scale: BoolProperty(name="Own Scale", default=False,
                            description="Say how long a unit is, in place of the unit settings of the scene")
    cm_per_unit: FloatProperty(name="Centimetres a Unit", default=100.0, min=0.0001, max=100000)
    pass_albedo: BoolProperty(name="Albedo", default=False)
    pass_coverage: BoolProperty(name="Coverage", default=False)
    pass_lobes: BoolProperty(name="Lobes", default=False, description="R, TT, TRT, TRRT, Residual, Surface, Background")
    keep_folder: StringProperty(name="Keep Files", subtype="DIR_PATH",
                                description="Folder in which the exported scene, the picture and the telemetry stay")


class TressPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__
    program: StringProperty(name="Program", subtype="FILE_PATH", description="tress; empty: the one in PATH")

    def draw(self, _context):
        self.layout.prop(self, "program")


CLASSES = (TressSettings, TressPreferences)


def register():
    for kind in CLASSES:
        bpy.utils.register_class(kind)
    bpy.types.Scene.tress = PointerProperty(type=TressSettings)


def unregister():
    del bpy.types.Scene.tress
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
