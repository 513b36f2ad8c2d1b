"""The learning service with a target written in Python (include/README.md has the life of a service)."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, NamedTuple, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _tress
from ._tress import PassReport, Slice


class Target:
    """What rows are learned from: a circular density that can be traced at the nodes of a grid,
    g(x) = sum over rays of weight G(x - azimuth), G the Gaussian of the slice's blur."""

    #: Of what trace() computes; caches of another name are refused.
    name: str = "python-target"

    def trace(self, slice: Slice, a: float, b: float) -> Sequence[npt.ArrayLike]:
        """Azimuths (radians), weights (>= 0), and, if wanted, an attribute (>= 0) of the rays of a node. Pure: the same
        node gives the same rays for ever. Called from any thread, one at a time, since Python has the GIL; must not call
        the service."""
        raise NotImplementedError


class SampledTarget:
    """What can only be drawn from: `parts` densities over (azimuth, height)."""

    name: str = "python-samples"
    parts: int = 1

    def draw(self, slice: Slice, a: float, b: float, stream: int, first: int, count: int) -> Sequence[npt.ArrayLike]:
        """Azimuths, heights, parts, weights and, if wanted, attributes of the exits of paths first to first + count of a
        stream. Pure: the same arguments give the same exits. As Target.trace() otherwise."""
        raise NotImplementedError


class Draw(NamedTuple):
    x: np.ndarray  #: azimuths, radians in [-pi, pi)
    value: np.ndarray  #: of the fit where the row has converged, else of the target, 1/rad
    q: np.ndarray  #: density of the draw, 1/rad; value / q is its weight


class SampledDraw(NamedTuple):
    azimuth: np.ndarray  #: radians in [-pi, pi)
    height: np.ndarray
    part: np.ndarray  #: index of the part that was drawn
    mass: np.ndarray  #: of the row, all parts: the weight of the draw; 0 where no row answers


class Service:
    """Learns rows while it is asked. The same calls between two publishes, in any order, give the same table, to the bit.

    An exception of the target comes out of the call that asked it, and the service then refuses all further calls: what
    it knows of rows may be of a target that gave nothing.
    epsilon, learner, memory_mb, max_components: as the options of `tress render`. Any thread may call any method.
    """

    def __init__(
        self,
        target: Union[Target, SampledTarget],
        *,
        epsilon: Optional[float] = None,
        queries_before_creation: Optional[int] = None,
        max_components: Optional[int] = None,
        memory_mb: Optional[int] = None,
        learner: Optional[str] = None,
        seed: Optional[int] = None,
    ) -> None:
        options = {
            "epsilon": epsilon,
            "queries_before_creation": queries_before_creation,
            "max_components": max_components,
            "memory_mb": memory_mb,
            "learner": learner,
            "seed": seed,
        }
        told = {key: value for key, value in options.items() if value is not None}
        self.target = target
        self._native = _tress.Service(target, target.parts if hasattr(target, "draw") else 0, told)

    def add_slice(
        self,
        lobe: int = 0,
        parameters: Sequence[float] = (),
        *,
        axis_a: Sequence[float],
        axis_b: Sequence[float],
        blur_rad: float = 0.2,
    ) -> int:
        """A grid of rows, by the key (lobe, parameters); its number."""
        return self._native.add_slice(lobe, list(parameters), list(axis_a), list(axis_b), blur_rad)

    @staticmethod
    def _nodes(a: npt.ArrayLike, b: npt.ArrayLike, x: npt.ArrayLike) -> tuple[tuple[int, ...], list[np.ndarray]]:
        arrays = np.broadcast_arrays(np.asarray(a, np.uint32), np.asarray(b, np.uint32), np.asarray(x, np.float32))
        return arrays[0].shape, [np.ascontiguousarray(array).reshape(-1) for array in arrays]

    def draw(self, slice: int, a: npt.ArrayLike, b: npt.ArrayLike, u: npt.ArrayLike) -> Draw:
        """A query for each element: of node (a, b), by u in [0, 1), from the row's own proposal, which is told to it."""
        shape, flat = self._nodes(a, b, u)
        return Draw(*(array.reshape(shape) for array in self._native.draw(slice, *flat)))

    def evaluate(self, slice: int, a: npt.ArrayLike, b: npt.ArrayLike, x: npt.ArrayLike) -> np.ndarray:
        """A query for each element: the density at azimuth x, 1/rad, which an open row learns."""
        shape, flat = self._nodes(a, b, x)
        return self._native.evaluate(slice, *flat).reshape(shape)

    def look_up(self, slice: int, a: npt.ArrayLike, b: npt.ArrayLike) -> np.ndarray:
        """A query for each element, of a SampledTarget: whether the row has converged."""
        shape, (a, b, _) = self._nodes(a, b, 0)
        return self._native.look_up(slice, a, b).reshape(shape).astype(bool)

    def sample(self, slice: int, a: npt.ArrayLike, b: npt.ArrayLike, u: npt.ArrayLike) -> SampledDraw:
        """A query for each element, of a SampledTarget: a draw from the row by u[..., 3] in [0, 1); mass 0 where none is."""
        u = np.asarray(u, np.float32)
        shape, (a, b, part) = self._nodes(a, b, u[..., 0])
        others = [np.ascontiguousarray(np.broadcast_to(u[..., i], shape)).reshape(-1) for i in (1, 2)]
        return SampledDraw(*(array.reshape(shape) for array in self._native.sample(slice, a, b, part, *others)))

    def credit(self, slice: int, a: npt.ArrayLike, b: npt.ArrayLike, light: npt.ArrayLike) -> None:
        """Tells how much of the picture's light a query of each node stood for."""
        self._native.credit(slice, *self._nodes(a, b, light)[1])

    def state(self) -> bytes:
        """All that the service is, after a publish(): for restore() of one with the same target, options and slices."""
        return self._native.state()

    def restore(self, state: bytes) -> None:
        """Before the first pass."""
        self._native.restore(state)

    def publish(self, paths: int = 0) -> PassReport:
        """Ends a pass: tests, fits, publication."""
        return self._native.publish(paths)

    def row(self, slice: int, a: int, b: int) -> dict[str, Any]:
        """A row as plain values: state, objective, and of a fit its components or masses."""
        return self._native.row(slice, a, b)

    def density(self, slice: int, a: int, b: int, part: int, x: npt.ArrayLike, height: npt.ArrayLike) -> np.ndarray:
        """Of a converged row of a SampledTarget."""
        x, height = np.broadcast_arrays(np.asarray(x, np.float32), np.asarray(height, np.float32))
        flat = [np.ascontiguousarray(array).reshape(-1) for array in (x, height)]
        return self._native.density(slice, a, b, part, *flat).reshape(x.shape)

    def save(self, file: Union[str, os.PathLike[str]]) -> dict[str, Any]:
        """Joined with what the file holds by now; what it then has."""
        return self._native.save(os.fspath(file))

    def load(self, file: Union[str, os.PathLike[str]]) -> None:
        """Before the first pass."""
        self._native.load(os.fspath(file))

    @property
    def hash(self) -> str:
        """Of the table: equal tables have equal ones."""
        return self._native.hash

    @property
    def log(self) -> list[str]:
        """What the service has found worth a line."""
        return self._native.log
