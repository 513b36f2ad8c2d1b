"""A scene as plain objects: the keys of a scene file (scenes/KEYS.md) by their names.

What is None is not said, and the scene file's default holds. Keys with keys of their own take a dict: `taper={"tip":
0.2}`. Values are checked when the scene is rendered, by the reader of scene files, with its words.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Optional, Union

import numpy as np

from .arrays import Strands, Triangles
from .keyed import Keyed, Keys, plain
from .scene_keys import (
    CameraKeys,
    EnvironmentKeys,
    GroomKeys,
    ImageKeys,
    IntegratorKeys,
    LightKeys,
    MaterialKeys,
    MeshKeys,
)


@dataclass(kw_only=True, slots=True)
class Camera(CameraKeys):
    """Without `eye` it is placed so that it sees all hair."""


@dataclass(kw_only=True, slots=True)
class Image(ImageKeys):
    """The size of the picture, samples a pixel, and what its preview looks like."""


@dataclass(kw_only=True, slots=True)
class Integrator(IntegratorKeys):
    """How light is followed."""


@dataclass(kw_only=True, slots=True)
class Environment(EnvironmentKeys):
    """One of studio, constant, sky, file and pixels: a latitude-longitude map, (height, width, 3), linear, top row up."""

    pixels: Optional[np.ndarray] = None


@dataclass(kw_only=True, slots=True)
class Light(LightKeys):
    """One of distant, sphere, rectangle and spot, a dict of the keys of its kind."""


@dataclass(kw_only=True, slots=True)
class Mesh(MeshKeys):
    """A mesh of a file, or of arrays."""

    triangles: Optional[Triangles] = None


@dataclass(kw_only=True, slots=True)
class Material(MaterialKeys):
    """A fiber and how strands of it differ. At most one of color, hair, melanin and sigma_a, or principled,
    chiang_hair_bsdf or marschner alone in place of them. Of colors, roughness, eccentricity, tilt, medulla, cortex,
    wetness, gains, presence and thickness a dict says how they vary along a strand and from strand to strand ("Sources" in
    scenes/README.md): `color={"root": [0.1, 0.05, 0.02], "tip": [0.7, 0.5, 0.3]}`."""


@dataclass(kw_only=True, slots=True)
class Groom(GroomKeys):
    """Strands of a file, of arrays (`strands=tress.Strands(...)`), or of a recipe (`generate`, with `strands` their
    number)."""

    strands: Union[Strands, int, None] = None  # type: ignore[assignment]


@dataclass(kw_only=True, slots=True)
class Scene(Keyed):
    """What is rendered. `grooms` may hold Strands as they are. File names are relative to `folder`."""

    camera: Optional[Camera] = None
    image: Optional[Image] = None
    integrator: Optional[Integrator] = None
    environment: Optional[Environment] = None
    environment_visible: Optional[bool] = None
    lights: list[Light] = field(default_factory=list)
    meshes: list[Mesh] = field(default_factory=list)
    materials: list[Material] = field(default_factory=list)
    grooms: list[Union[Groom, Strands]] = field(default_factory=list)
    expected: Optional[Keys] = None
    folder: str = ""

    @classmethod
    def load(cls, file: Union[str, os.PathLike[str]]) -> Scene:
        """A scene file as objects that may be changed. What is wrong in it is reported when it is rendered."""
        with open(file, "rb") as stream:
            scene = cls.from_keys(json.load(stream))
        scene.folder = os.path.dirname(os.fspath(file))
        return scene

    @classmethod
    def from_keys(cls, keys: Keys) -> Scene:
        scene = super(Scene, cls).from_keys(keys)
        kinds = {"camera": Camera, "image": Image, "integrator": Integrator, "environment": Environment}
        for name, kind in kinds.items():
            if isinstance(getattr(scene, name), Mapping):
                setattr(scene, name, kind.from_keys(getattr(scene, name)))
        lists = {"lights": Light, "meshes": Mesh, "materials": Material, "grooms": Groom}
        for name, kind in lists.items():
            setattr(scene, name, [kind.from_keys(item) for item in getattr(scene, name)])
        return scene

    def keys(self) -> dict[str, Any]:
        return self._native()[0]

    def _native(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """The keys of the scene file, and the arrays by the names that stand for files in it."""
        arrays: dict[str, Any] = {}

        def named(kind: str, values: dict[str, Any]) -> str:
            name = f"{kind} {len(arrays) + 1}"
            arrays[name] = (kind, values)
            return name

        keys: dict[str, Any] = {}
        for item in ("camera", "image", "integrator", "environment_visible", "expected"):
            value = getattr(self, item)
            if value is not None:
                keys[item] = value.keys() if isinstance(value, Keyed) else plain(value)
        if self.environment is not None:
            keys["environment"] = fields = self.environment.keys()
            if fields.pop("pixels", None) is not None:
                pixels = np.ascontiguousarray(self.environment.pixels, dtype=np.float32)
                fields["file"] = named("environment", {"pixels": pixels})
        for item in ("lights", "materials"):
            if getattr(self, item):
                keys[item] = [one.keys() for one in getattr(self, item)]
        for mesh in self.meshes:
            fields = mesh.keys()
            if mesh.triangles is not None:
                fields["file"] = named("mesh", mesh.triangles._native())
            keys.setdefault("meshes", []).append(fields)
        for one in self.grooms:
            groom = Groom(strands=one) if isinstance(one, Strands) else one
            fields = groom.keys()
            if isinstance(groom.strands, Strands):
                fields["file"] = named("strands", groom.strands._native())
            keys.setdefault("grooms", []).append(fields)
        return keys | self._other, arrays
