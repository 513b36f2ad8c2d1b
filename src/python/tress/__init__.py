"""Renders hair and fur; learns circular densities; answers what a fiber scatters. Start at src/python/README.md.

Angles of scenes are degrees where a key says so, all others radians. Lengths are centimetres. Mistakes are `tress.Error`, which is a
ValueError, IndexError, RuntimeError, FileNotFoundError or OSError as well.
Everything that takes long runs without the GIL, and Ctrl-C ends it.
"""

from ._tress import Error, FileFailed, FileMissing, InvalidCall, InvalidIndex, InvalidValue, __version__, models
from .arrays import Strands, Triangles, read_groom
from .fibers import LOBES, Bcsdf, Drawn, fit
from .objects import Camera, Environment, Groom, Image, Integrator, Light, Material, Mesh, Scene
from .pictures import Picture, compare, read_exr
from .rendering import Progress, render
from .services import STATES, Answer, PassReport, SampledTarget, Service, Slice, Target

__all__ = [
    "Answer",
    "Bcsdf",
    "Camera",
    "Drawn",
    "Environment",
    "Error",
    "FileFailed",
    "FileMissing",
    "Groom",
    "Image",
    "Integrator",
    "InvalidCall",
    "InvalidIndex",
    "InvalidValue",
    "LOBES",
    "Light",
    "Material",
    "Mesh",
    "PassReport",
    "Picture",
    "Progress",
    "STATES",
    "SampledTarget",
    "Scene",
    "Service",
    "Slice",
    "Strands",
    "Target",
    "Triangles",
    "__version__",
    "compare",
    "fit",
    "models",
    "read_exr",
    "read_groom",
    "render",
]
