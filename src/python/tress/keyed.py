"""What the objects of a scene have in common: fields that are keys of a scene file."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np

from .arrays import Strands, Triangles

Triple = Sequence[float]
Keys = Mapping[str, Any]
KeysList = Sequence[Keys]
T = TypeVar("T", bound="Keyed")


def plain(value: Any) -> Any:
    """The value as JSON has it: numpy's numbers and arrays become numbers and lists."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    return value


@dataclass(kw_only=True, slots=True)
class Keyed:
    """`_other` has the keys that were read and are not known, for the reader of scene files to refuse."""

    _other: dict[str, Any] = field(default_factory=dict, repr=False)

    @classmethod
    def from_keys(cls: type[T], keys: Keys) -> T:
        """Makes the object from the keys that a scene file has for it."""
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
                fields[item.name] = plain(value)
        return fields | self._other
