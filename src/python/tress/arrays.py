"""Strands and triangles as numpy arrays."""

from __future__ import annotations

import os
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _tress


def _rows(values: npt.ArrayLike, columns: int, place: str, dtype: Any = np.float32) -> np.ndarray:
    """(N, columns) of dtype, C-contiguous: the array itself if it is that already, else a copy."""
    array = np.ascontiguousarray(values, dtype=dtype)
    if array.ndim == 0 or array.shape[-1] != columns:
        raise _tress.Error(f"{place}: expected (..., {columns}) numbers, found {array.shape}")
    return array.reshape(-1, columns)


def _whole(values: npt.ArrayLike, place: str) -> np.ndarray:
    """Whole numbers from 0 to 2^32 - 1, whatever type they came in."""
    array = np.asarray(values).reshape(-1)
    whole = array.astype(np.uint32)
    if not np.array_equal(whole, array):
        raise _tress.Error(f"{place}: expected whole numbers from 0 to 2^32 - 1, found {array[whole != array][0]}")
    return np.ascontiguousarray(whole)


class Strands:
    """Strands, root first.

    points: (strand, point, 3), or (N, 3) with counts: how many of them each strand has. What is C-contiguous float32
    already stays where it is (`points` is then a view of it); all else is copied here, once. A render copies the points
    once more, into the scene, since units and axes change them there; and Embree, as every ray tracer, has a copy in
    its own layout.
    width: diameters in the unit of the points: one for all, one a strand, or one a point. Without it 0.008 cm.
    color: linear RGB in [0, 1], (strand, 3) or one a point; used by a material with color="file" or a source that
    names the attribute "color".
    basis: what the points are: "bspline" (the default; through root and tip), "linear", "catmull_rom",
    "clamped_catmull_rom", "open_bspline", "open_catmull_rom", "bezier", "hermite".
    normal: (strand, point, 3) or one a point, along the minor axes of the fibers' cross-sections, any length; 0
    at points that have no axis of their own. Without it the axes are the material's.
    id: a whole number a strand, which seeds what is random of it; without it its index does. root_uv: (strand, 2),
    where its root is on a material's textures.
    """

    __slots__ = ("points", "counts", "width", "color", "basis", "cm_per_unit", "up", "normal", "id", "root_uv", "remarks")

    def __init__(
        self,
        points: npt.ArrayLike,
        counts: Optional[npt.ArrayLike] = None,
        *,
        width: Optional[npt.ArrayLike] = None,
        color: Optional[npt.ArrayLike] = None,
        normal: Optional[npt.ArrayLike] = None,
        basis: str = "bspline",
        cm_per_unit: float = 1.0,
        up: str = "z",
        id: Optional[npt.ArrayLike] = None,
        root_uv: Optional[npt.ArrayLike] = None,
    ) -> None:
        shape = np.shape(points)
        if counts is None and len(shape) != 3:
            raise _tress.Error(f"points: expected (strand, point, 3) without counts, found {shape}")
        self.points: np.ndarray = _rows(points, 3, "points")
        self.counts: np.ndarray = (
            np.full(shape[0], shape[1], np.uint32)
            if counts is None
            else _whole(counts, "counts")
        )
        self.width: Optional[np.ndarray] = None if width is None else self._a_point(width)
        self.color: Optional[np.ndarray] = None if color is None else _rows(color, 3, "color")
        self.basis = basis
        self.cm_per_unit = cm_per_unit
        self.up = up
        self.normal: Optional[np.ndarray] = None if normal is None else _rows(normal, 3, "normal")
        self.id: Optional[np.ndarray] = None if id is None else np.ascontiguousarray(id, dtype=np.int64)
        self.root_uv: Optional[np.ndarray] = None if root_uv is None else _rows(root_uv, 2, "root_uv")
        self.remarks: list[str] = []

    def _a_point(self, width: npt.ArrayLike) -> np.ndarray:
        array = np.asarray(width, dtype=np.float32, order="C")
        if array.ndim == 0:
            return np.full(len(self.points), array, np.float32)
        array = array.reshape(-1)
        is_a_strand = array.size == len(self.counts) and array.size != len(self.points)
        return np.repeat(array, self.counts) if is_a_strand else array

    def __len__(self) -> int:
        """How many strands."""
        return len(self.counts)

    def __repr__(self) -> str:
        return f"Strands({len(self)} strands, {len(self.points)} points, {self.basis})"

    def strand(self, index: int) -> np.ndarray:
        """The points of one strand, a view."""
        first = int(self.counts[:index].sum(dtype=np.int64))
        return self.points[first : first + int(self.counts[index])]

    def _native(self) -> dict[str, Any]:
        fields = {
            "points": self.points,
            "counts": self.counts,
            "width": self.width,
            "color": self.color,
            "normal": self.normal,
            "id": self.id,
            "root_uv": self.root_uv,
            "basis": self.basis,
            "cm_per_unit": float(self.cm_per_unit),
            "up": self.up,
        }
        return {key: value for key, value in fields.items() if value is not None}


class Triangles:
    """Triangles of a mesh: positions (N, 3), triangles (M, 3) of indices, and for every position, if given, a normal
    and texture coordinates."""

    __slots__ = ("positions", "triangles", "normals", "uvs")

    def __init__(
        self,
        positions: npt.ArrayLike,
        triangles: npt.ArrayLike,
        *,
        normals: Optional[npt.ArrayLike] = None,
        uvs: Optional[npt.ArrayLike] = None,
    ) -> None:
        self.positions = _rows(positions, 3, "positions")
        self.triangles = _rows(triangles, 3, "triangles", np.uint32)
        self.normals = None if normals is None else _rows(normals, 3, "normals")
        self.uvs = None if uvs is None else _rows(uvs, 2, "uvs")

    def _native(self) -> dict[str, Any]:
        fields = {key: getattr(self, key) for key in self.__slots__}
        return {key: value for key, value in fields.items() if value is not None}


def read_groom(
    file: Union[str, os.PathLike[str]], points_per_strand: Optional[int] = None, frame: Optional[float] = None
) -> Strands:
    """Strands of a .hair, Alembic, USD text, pbrt, PLY or .data file, in the file's units and axes. Where it says none
    a unit is 1 cm and z is up: set `cm_per_unit` and `up`. `frame` is that of an animated file, in place of its first
    sample. Instances that share strands are written out. The arrays own what was read. `remarks` says what of the
    file is not used."""
    fields = _tress.read_groom(os.fspath(file), points_per_strand, frame)
    strands = Strands(
        fields["points"],
        fields["counts"],
        width=fields.get("width"),
        color=fields.get("color"),
        basis=fields.get("basis", "bspline"),
        cm_per_unit=fields.get("cm_per_unit", 1.0),
        up=fields.get("up", "z"),
        id=fields.get("id"),
        root_uv=fields.get("root_uv"),
    )
    for key in ("normal", "remarks"):
        setattr(strands, key, fields.get(key))
    return strands
