"""tress, a renderer of hair and fur, as a render engine of Blender (README.md beside this folder)."""

bl_info = {
    "name": "tress",
    "author": "the authors of tress",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "category": "Render",
    "location": "Render Properties, Render Engine",
    "description": "Renders hair and fur with elliptical fibers by the program tress",
}


def register():
    import bpy

    from . import engine, panels, settings

    settings.register()
    bpy.utils.register_class(engine.TressRenderEngine)
    panels.register()


def unregister():
    import bpy

    from . import engine, panels, settings

    panels.unregister()
    bpy.utils.unregister_class(engine.TressRenderEngine)
    settings.unregister()
