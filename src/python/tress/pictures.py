"""Pictures: layers as arrays, files."""

from __future__ import annotations

import os
import tempfile
from typing import Any, Optional, Union

import numpy as np

from . import _tress

Path = Union[str, os.PathLike[str]]


def _order(channel: str) -> tuple[int, str]:
    """R, G, B, A; X, Y, Z; others by name."""
    last = channel.rsplit(".", 1)[-1]
    return ("RGBAXYZ".find(last.upper()) if len(last) == 1 else -1, channel)


def _layer_of(channel: str) -> str:
    if channel in ("R", "G", "B", "A"):
        return "beauty"
    return channel.rsplit(".", 1)[0]


class Picture:
    """A layered picture, linear, top row first (src/integrate/PICTURE.md has what each layer is)."""

    def __init__(self, native: _tress.Picture) -> None:
        self._native = native

    @property
    def width(self) -> int:
        return self._native.width

    @property
    def height(self) -> int:
        return self._native.height

    @property
    def channels(self) -> list[str]:
        """Names of the channels, as in an EXR: "R", "TT.G", "Z"."""
        return self._native.channels

    @property
    def layers(self) -> list[str]:
        """beauty, and the others in their order."""
        return list(dict.fromkeys(_layer_of(name) for name in self.channels))

    @property
    def metadata(self) -> dict[str, str]:
        """The strings of its header."""
        return self._native.metadata

    @property
    def stats(self) -> dict[str, Any]:
        """What the render reported at its end: noise, seconds, passes, notes, warnings; empty of a file."""
        return self._native.stats

    def channel(self, name: str) -> np.ndarray:
        """(height, width) float32: the picture's own memory, not a copy. It keeps the picture alive."""
        return self._native.channel(name)

    def __getitem__(self, layer: str) -> np.ndarray:
        """A layer, (height, width, channels) float32 in the order R, G, B, A or x, y, z: a copy, since channels lie
        apart. A layer of one channel is channel()."""
        names = sorted((name for name in self.channels if _layer_of(name) == layer), key=_order)
        if not names:
            raise _tress.Error(f"layer: expected one of {', '.join(self.layers)}, found {layer!r}")
        return self.channel(names[0]) if len(names) == 1 else np.stack([self.channel(name) for name in names], axis=-1)

    def __contains__(self, layer: object) -> bool:
        return layer in self.layers

    def save(self, file: Path, *, precision: str = "half", exposure: Optional[float] = None, view: Optional[str] = None) -> None:
        """.exr: every layer, and a .png beside it, as tress render does; .png: that alone. precision: half or float."""
        stem, ending = os.path.splitext(os.fspath(file))
        if ending.lower() not in (".exr", ".png"):
            raise _tress.Error(f"file: expected a name that ends in .exr or .png, found {os.fspath(file)!r}")
        if ending.lower() == ".exr":
            self._native.write_exr(os.fspath(file), precision)
        self._native.write_png(stem + ".png", exposure, view)

    def _repr_png_(self) -> bytes:
        """Bytes of a PNG, which notebooks show."""
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "picture.png")
            self._native.write_png(file)
            with open(file, "rb") as stream:
                return stream.read()

    def __repr__(self) -> str:
        return f"Picture({self.width} x {self.height}, {len(self.layers)} layers)"


def read_exr(file: Path) -> Picture:
    """Any EXR of float or half channels."""
    return Picture(_tress.read_exr(os.fspath(file)))


def compare(a: Picture, b: Picture) -> dict[str, Any]:
    """B against A as `tress diff` has it: identical, rel_mse, mae, bias, largest."""
    return _tress.compare(a._native, b._native)
