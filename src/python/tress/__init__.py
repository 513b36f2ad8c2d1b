"""Renders hair and fur; learns circular densities; answers what a fiber scatters. Start at src/python/README.md.

Angles of scenes are degrees where a key says so, all others radians. Lengths are centimetres. Mistakes are `tress.Error`.
Everything that takes long runs without the GIL, and Ctrl-C ends it.
"""

from ._tress import Error, __version__, models
from .arrays import Strands, Triangles, read_groom
from .objects import Camera, Environment, Groom, Image, Light, Material, Mesh, Scene
from .pictures import Picture, compare, read_exr
from .rendering import Progress, render

__all__ = [
    "Camera",
    "Environment",
    "Error",
    "Groom",
    "Image",
    "Light",
    "Material",
    "Mesh",
    "Picture",
    "Progress",
    "Scene",
    "Strands",
    "Triangles",
    "__version__",
    "compare",
    "models",
    "read_exr",
    "read_groom",
    "render",
]
