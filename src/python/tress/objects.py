"""A scene as plain objects: the keys of a scene file (scenes/README.md) by their names.

What is None is not said, and the scene file's default holds. Keys with keys of their own take a dict: `taper={"tip":
0.2}`. Values are checked when the scene is rendered, by the reader of scene files, with its words.
"""

from __future__ import annotations

import dataclasses
import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Optional, TypeVar, Union

import numpy as np

from .arrays import Strands, Triangles

Triple = Sequence[float]
Keys = Mapping[str, Any]
T = TypeVar("T", bound="_Object")


def _plain(value: Any) -> Any:
    """As JSON has it: numpy's numbers and arrays too."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    return value


@dataclass(kw_only=True, slots=True)
class _Object:
    """Keys that were read and are not known, for the reader of scene files to refuse."""

    _other: dict[str, Any] = field(default_factory=dict, repr=False)

    @classmethod
    def from_keys(cls: type[T], keys: Keys) -> T:
        """Of an object of a scene file."""
        names = {item.name for item in dataclasses.fields(cls)} - {"_other"}
        made = cls(**{key: value for key, value in keys.items() if key in names})
        made._other = {key: value for key, value in keys.items() if key not in names}
        return made

    def keys(self) -> dict[str, Any]:
        """What is said, by key, as a scene file has it. Arrays are left out."""
        fields = {}
        for item in dataclasses.fields(self):
            value = getattr(self, item.name)
            if item.name != "_other" and value is not None and not isinstance(value, (Strands, Triangles)):
                fields[item.name] = _plain(value)
        return fields | self._other


@dataclass(kw_only=True, slots=True)
class Camera(_Object):
    """Without `eye` it is placed so that it sees all hair."""

    frame: Optional[bool] = None
    turn_deg: Optional[float] = None
    eye: Optional[Triple] = None
    look_at: Optional[Triple] = None
    up: Optional[Triple] = None
    vertical_fov_deg: Optional[float] = None
    focal_length_mm: Optional[float] = None
    sensor_mm: Optional[float] = None
    sensor_fit: Optional[str] = None
    orthographic_height_cm: Optional[float] = None
    shift_x: Optional[float] = None
    shift_y: Optional[float] = None
    depth_of_field: Optional[Keys] = None
    frames: Optional[Sequence[Keys]] = None
    turntable: Optional[Keys] = None
    shutter: Optional[Keys] = None
    motion_samples: Optional[int] = None
    frames_per_second: Optional[float] = None


@dataclass(kw_only=True, slots=True)
class Image(_Object):
    """The size of the picture, samples a pixel, and what its preview looks like."""

    width: Optional[int] = None
    height: Optional[int] = None
    samples: Optional[int] = None
    least_width: Optional[float] = None
    curve_error: Optional[float] = None
    transparent: Optional[bool] = None
    exposure: Optional[float] = None
    view: Optional[str] = None


@dataclass(kw_only=True, slots=True)
class Environment(_Object):
    """One of studio, constant, sky, file and pixels: a latitude-longitude map, (height, width, 3), linear, top row up."""

    file: Optional[str] = None
    constant: Optional[Triple] = None
    studio: Optional[bool] = None
    rotate_deg: Optional[float] = None
    frames: Optional[Sequence[Keys]] = None
    scale: Optional[float] = None
    sky: Optional[Keys] = None
    group: Optional[str] = None
    light_link: Optional[Keys] = None
    shadow_link: Optional[Keys] = None
    pixels: Optional[np.ndarray] = None


@dataclass(kw_only=True, slots=True)
class Light(_Object):
    """One of distant, sphere, rectangle and spot, a dict of the keys of its kind."""

    distant: Optional[Keys] = None
    sphere: Optional[Keys] = None
    rectangle: Optional[Keys] = None
    spot: Optional[Keys] = None
    scale: Optional[float] = None
    rotate_deg: Optional[Triple] = None
    translate: Optional[Triple] = None
    frames: Optional[Sequence[Keys]] = None
    visible: Optional[bool] = None
    group: Optional[str] = None
    light_link: Optional[Keys] = None
    shadow_link: Optional[Keys] = None


@dataclass(kw_only=True, slots=True)
class Mesh(_Object):
    """A mesh of a file, or of arrays."""

    name: Optional[str] = None
    file: Optional[str] = None
    up: Optional[str] = None
    cm_per_unit: Optional[float] = None
    scale: Optional[float] = None
    rotate_deg: Optional[Triple] = None
    translate: Optional[Triple] = None
    frames: Optional[Sequence[Keys]] = None
    albedo: Optional[Triple] = None
    albedo_file: Optional[str] = None
    coat: Optional[Keys] = None
    visible: Optional[bool] = None
    casts_shadow: Optional[bool] = None
    visible_indirect: Optional[bool] = None
    holdout: Optional[bool] = None
    triangles: Optional[Triangles] = None


@dataclass(kw_only=True, slots=True)
class Material(_Object):
    """A fiber and how strands of it differ. At most one of color, hair, melanin and sigma_a, or principled,
    chiang_hair_bsdf or marschner alone in place of them. Of colors, roughness, eccentricity, tilt, medulla, gains,
    presence and thickness a dict says how they vary along a strand and from strand to strand ("Sources" in
    scenes/README.md): `color={"root": [0.1, 0.05, 0.02], "tip": [0.7, 0.5, 0.3]}`."""

    name: Optional[str] = None
    eta: Optional[float] = None
    eccentricity: Union[float, Keys, None] = None
    roughness: Union[float, Keys, None] = None
    presence: Union[float, Keys, None] = None
    thickness: Union[float, Keys, None] = None
    tilt_deg: Union[float, Keys, None] = None
    color: Union[Triple, str, Keys, None] = None
    hair: Union[str, Keys, None] = None
    melanin: Optional[Keys] = None
    sigma_a: Union[Triple, Keys, None] = None
    azimuthal_sigma_deg: Optional[Keys] = None
    longitudinal_lambda_deg: Optional[Keys] = None
    curl_diameter_cm: Optional[float] = None
    twist: Optional[bool] = None
    root_angle_deg: Optional[float] = None
    principled: Optional[Keys] = None
    chiang_hair_bsdf: Optional[Keys] = None
    marschner: Optional[Keys] = None
    medulla: Optional[Keys] = None
    variation: Optional[Keys] = None
    longitudinal_shape: Optional[str] = None
    fresnel: Optional[str] = None
    gain: Optional[Keys] = None
    tint: Optional[Keys] = None
    glint: Optional[bool] = None


@dataclass(kw_only=True, slots=True)
class Groom(_Object):
    """Strands of a file, of arrays (`strands=tress.Strands(...)`), or of a recipe (`generate`, with `strands` their
    number)."""

    strands: Union[Strands, int, None] = None
    name: Optional[str] = None
    file: Optional[str] = None
    generate: Optional[str] = None
    seed: Optional[int] = None
    length_cm: Optional[float] = None
    length_variation: Optional[float] = None
    clump: Optional[float] = None
    frizz: Optional[float] = None
    wavelength_cm: Optional[float] = None
    wave_amplitude_cm: Optional[float] = None
    curl_diameter_cm: Optional[float] = None
    width_cm: Optional[float] = None
    ball_radius_cm: Optional[float] = None
    radius_cm: Optional[float] = None
    widths: Optional[str] = None
    taper: Optional[Keys] = None
    basis: Optional[str] = None
    normals: Optional[bool] = None
    up: Optional[str] = None
    points_per_strand: Optional[int] = None
    scale: Optional[float] = None
    rotate_deg: Optional[Triple] = None
    translate: Optional[Triple] = None
    frames: Optional[Sequence[Keys]] = None
    cm_per_unit: Optional[float] = None
    material: Optional[str] = None
    looks: Optional[Sequence[Keys]] = None
    visible: Optional[bool] = None
    casts_shadow: Optional[bool] = None
    visible_indirect: Optional[bool] = None


@dataclass(kw_only=True, slots=True)
class Scene(_Object):
    """What is rendered. `grooms` may hold Strands as they are. File names are relative to `folder`."""

    camera: Optional[Camera] = None
    image: Optional[Image] = None
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
        kinds = {"camera": Camera, "image": Image, "environment": Environment}
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
        for item in ("camera", "image", "environment_visible", "expected"):
            value = getattr(self, item)
            if value is not None:
                keys[item] = value.keys() if isinstance(value, _Object) else _plain(value)
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
