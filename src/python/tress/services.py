"""The learning service with a target written in Python (include/README.md has the life of a service)."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
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


#: Names of the numbers of Answer.state and of rows()["state"].
STATES = ("absent", "open", "converged", "refused")


class Answer(NamedTuple):
    """What include/tress/adaptive/query.h gives, of the shape of what was asked."""

    x: np.ndarray  #: azimuths, radians in [-pi, pi)
    value: np.ndarray  #: the density there, by row or target: 1/rad; of samples the sum of the parts, 1/rad/height
    q: np.ndarray  #: the density with which draw() draws the place, same unit: value / q is its weight
    height: np.ndarray  #: 0 for densities
    parts: np.ndarray  #: (..., 4): of samples the density of each part; otherwise parts[..., 0] is value
    state: np.ndarray  #: of the row, index into STATES
    answered: np.ndarray  #: False: no row of samples answers here yet, and value, parts and q are 0


class Service:
    """Learns rows while it is asked. The same calls between two publishes, in any order, give the same table, to the bit.

    An exception of the target comes out of the call that asked it, and the service then refuses all further calls: what
    it knows of rows may be of a target that gave nothing. A target may have both trace() and draw().
    epsilon, learner, memory_mb, max_components: as the options of `tress render`. Other options: as in
    include/tress/adaptive/options.h. progress: called inside publish() and prepare() with the share that is done; they
    leave the rest for later passes if it returns False.
    Any thread may call any method. Nodes (a, b) are indices into the axes, and arrays broadcast.
    """

    def __init__(
        self,
        target: Union[Target, SampledTarget],
        *,
        epsilon: Optional[float] = None,
        sampled_epsilon: Optional[float] = None,
        learns_to_epsilon: Optional[bool] = None,
        picture_error: Optional[float] = None,
        queries_before_creation: Optional[int] = None,
        tests_before_refusal: Optional[int] = None,
        heard_share: Optional[float] = None,
        own_paths: Optional[bool] = None,
        max_components: Optional[int] = None,
        memory_mb: Optional[int] = None,
        learner: Optional[str] = None,
        seed: Optional[int] = None,
        check_passes: Optional[bool] = None,
        progress: Optional[Callable[[float], Any]] = None,
    ) -> None:
        options = {key: value for key, value in locals().items() if key not in ("self", "target", "progress")}
        given = {key: value for key, value in options.items() if value is not None}
        self.target = target
        self._draws = hasattr(target, "draw")
        self._traces = hasattr(target, "trace")
        self._shapes: dict[int, tuple[int, int]] = {}
        self._of_samples: set[int] = set()
        parts = target.parts if self._draws else 0
        self._native = _tress.Service(target, self._traces, parts, given, progress)

    def add_slice(
        self,
        lobe: int = 0,
        parameters: Sequence[float] = (),
        *,
        axis_a: Sequence[float],
        axis_b: Sequence[float],
        blur_rad: float = 0.2,
        samples: Optional[bool] = None,
        coarse: Sequence[tuple[Sequence[int], Sequence[int]]] = (),
        coarse_rows_of: Optional[int] = None,
        max_components: int = 8,
    ) -> int:
        """A grid of rows, by the key (lobe, parameters); its number. samples: whether it is learned from draw() or
        trace(), for a target that has both. coarse: coarser grids of samples, as indices into both axes, of which the
        first is used; coarse_rows_of: a slice whose coarse rows answer for this one."""
        samples = self._draws and not self._traces if samples is None else samples
        axis_a, axis_b = list(axis_a), list(axis_b)
        grids = [(list(a), list(b)) for a, b in coarse]
        number = self._native.add_slice(
            lobe, list(parameters), axis_a, axis_b, blur_rad, samples, grids, coarse_rows_of, max_components
        )
        self._shapes[number] = (len(axis_a), len(axis_b))
        if samples:
            self._of_samples.add(number)
        return number

    @staticmethod
    def _flat(*columns: npt.ArrayLike) -> tuple[tuple[int, ...], list[np.ndarray]]:
        """The first two and the stack of the others, as flat arrays, and the shape of all."""
        arrays = np.broadcast_arrays(*[np.asarray(column, np.float32) for column in columns])
        flat = [np.ascontiguousarray(array).reshape(-1) for array in arrays]
        return arrays[0].shape, [flat[0], flat[1], np.stack(flat[2:], axis=-1)]

    def _query(self, name: str, slice: int, *columns: npt.ArrayLike) -> Answer:
        shape, flat = self._flat(*columns)
        x, value, q, height, parts, state, answered = self._native.query(slice, name, *flat)
        of_one = [array.reshape(shape) for array in (x, value, q, height)]
        return Answer(*of_one, parts.reshape(*shape, 4), state.reshape(shape), answered.reshape(shape).astype(bool))

    def draw(self, slice: int, a: npt.ArrayLike, b: npt.ArrayLike, u: npt.ArrayLike) -> Answer:
        """A query for each element: a place of node (a, b) from the row's own proposal, from which an open row learns.
        u in [0, 1): of densities (...), of samples (..., 3): part, azimuth, height."""
        return self._query("draw", slice, a, b, *(np.moveaxis(u, -1, 0) if slice in self._of_samples else (u, 0, 0)))

    def answer(
        self, slice: int, a: npt.ArrayLike, b: npt.ArrayLike, x: npt.ArrayLike, height: npt.ArrayLike = 0
    ) -> Answer:
        """A query for each element: what draw() gives, at places of the caller."""
        return self._query("answer", slice, a, b, x, height)

    def evaluate(
        self, slice: int, a: npt.ArrayLike, b: npt.ArrayLike, x: npt.ArrayLike, height: npt.ArrayLike = 0
    ) -> np.ndarray:
        """answer().value: the density at azimuth x, which an open row learns."""
        return self.answer(slice, a, b, x, height).value

    def choose(self, slice: int, a: npt.ArrayLike, b: npt.ArrayLike, xi: npt.ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """A node around the place (a, b), by coordinates on the axes, for uniforms xi (..., 2): the mean over xi of
        anything is its linear interpolation between the nodes."""
        shape, flat = self._flat(a, b, *np.moveaxis(xi, -1, 0))
        nodes = self._native.choose(slice, *flat)
        return nodes[:, 0].reshape(shape), nodes[:, 1].reshape(shape)

    def mean(
        self, slice: int, a: npt.ArrayLike, b: npt.ArrayLike, x: npt.ArrayLike, height: npt.ArrayLike = 0
    ) -> Answer:
        """The mean of answer() over the nodes that choose() may give."""
        return self._query("mean", slice, a, b, x, height)

    def draw_mean(self, slice: int, a: npt.ArrayLike, b: npt.ArrayLike, u: npt.ArrayLike) -> Answer:
        """A place drawn from the q of mean(), by u (..., 5): three as of samples in draw(), then xi."""
        return self._query("draw_mean", slice, a, b, *np.moveaxis(u, -1, 0))

    def observe(
        self, slice: int, a: npt.ArrayLike, b: npt.ArrayLike, x: npt.ArrayLike, g: npt.ArrayLike, q: npt.ArrayLike = 0
    ) -> None:
        """Passes values g of the target that the caller has found itself to open rows. q > 0: x was drawn from the row's
        own proposal of this pass with that density, and scores its fit."""
        self._native.pass_to(slice, "observe", *self._flat(a, b, x, g, q)[1])

    def hear(
        self,
        slice: int,
        a: npt.ArrayLike,
        b: npt.ArrayLike,
        azimuth: npt.ArrayLike,
        height: npt.ArrayLike,
        part: npt.ArrayLike,
        weight: npt.ArrayLike,
        attribute: npt.ArrayLike = 0,
    ) -> None:
        """Passes exits of paths that the caller drew from the target of samples itself, which heard_test compares with
        rows; weight 0: the path did not leave."""
        self._native.pass_to(slice, "hear", *self._flat(a, b, azimuth, height, part, weight, attribute)[1])

    def credit(
        self, slice: int, a: npt.ArrayLike, b: npt.ArrayLike, light: npt.ArrayLike, events: npt.ArrayLike = 1
    ) -> None:
        """Reports how much of the picture's light `events` queries of each node stood for."""
        self._native.pass_to(slice, "credit", *self._flat(a, b, light, events)[1])

    def prepare(self) -> None:
        """Learns the coarsest rows of samples, so that the first pass gets answers."""
        self._native.prepare()

    def set_learning(self, on: bool) -> None:
        """Off: the table does not change, whatever is asked."""
        self._native.set_learning(on)

    def publish_pays(self, share: float = 0.01) -> bool:
        """Whether a publish() now would make answers better, at rows of at least this share of the pass's queries."""
        return self._native.publish_pays(share)

    def publish(self, paths: int = 0) -> PassReport:
        """Ends a pass: tests, fits, publication. paths: of the pass whose light was passed to credit()."""
        return self._native.publish(paths)

    @property
    def changed(self) -> list[dict[str, Any]]:
        """Rows whose fit or state the last publish() changed. What a host keeps of rows in a form of its own is made
        anew for these: row() has what it is made of."""
        return self._native.changed

    def row(self, slice: int, a: int, b: int) -> dict[str, Any]:
        """A row as plain values: state, objective, and of a fit its components or masses. No query is counted."""
        return self._native.row(slice, a, b)

    def rows(self, slice: int) -> dict[str, np.ndarray]:
        """All nodes of a slice as arrays (axis_a, axis_b): state (index into STATES), objective, energy, light (of
        credit(), a mean over the paths), queries, paths (of samples)."""
        columns = np.moveaxis(self._native.rows(slice), -1, 0)
        names = ("state", "objective", "energy", "light", "queries", "paths")
        return {name: column.reshape(self._shapes[slice]) for name, column in zip(names, columns)}

    def density(self, slice: int, a: int, b: int, part: int, x: npt.ArrayLike, height: npt.ArrayLike) -> np.ndarray:
        """The density of a part, of a row of samples that answers. No query is counted."""
        x, height = np.broadcast_arrays(np.asarray(x, np.float32), np.asarray(height, np.float32))
        flat = [np.ascontiguousarray(array).reshape(-1) for array in (x, height)]
        return self._native.density(slice, a, b, part, *flat).reshape(x.shape)

    @property
    def heard_test(self) -> dict[str, float]:
        """The error of all rows of samples against the paths of hear()."""
        return self._native.heard_test

    def state(self) -> bytes:
        """All that the service is, after a publish(): for restore() of one with the same target, options and slices."""
        return self._native.state()

    def restore(self, state: bytes) -> None:
        """Loads a cache; call it before the first pass."""
        self._native.restore(state)

    def save(self, file: Union[str, os.PathLike[str]]) -> dict[str, Any]:
        """Merges the table with what the file has by now, and saves it. Returns what the file then has."""
        return self._native.save(os.fspath(file))

    def load(self, file: Union[str, os.PathLike[str]]) -> None:
        """Loads a cache; call it before the first pass."""
        self._native.load(os.fspath(file))

    @property
    def refusals(self) -> list[str]:
        """Errors of slices of the cache whose axes differ from those of a later add_slice()."""
        return self._native.refusals

    @property
    def hash(self) -> str:
        """Hash of the table: equal tables have equal hashes."""
        return self._native.hash

    @property
    def log(self) -> list[str]:
        """What the service has found worth a line."""
        return self._native.log
