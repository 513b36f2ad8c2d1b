"""What one fiber scatters: rows of the table, and the BCSDF of any model."""

from __future__ import annotations

import json
import os
from typing import NamedTuple, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _tress
from ._tress import LOBES, PassReport
from .objects import Keys, Material

fit = _tress.fit


class Drawn(NamedTuple):
    """Directions that a BCSDF has drawn, of the shape of what was asked."""

    theta_i: np.ndarray
    phi_i: np.ndarray
    weight: np.ndarray  #: (..., 3): S/Q, what a unit of light from there is worth, by channel
    pdf: np.ndarray  #: Q, 1/rad^2; 0 of models that can only be sampled
    lobe: np.ndarray  #: index into LOBES of the lobe that drew


class Bcsdf:
    """One fiber under a model of `tress render --model`.

    Directions are angles about the fiber, radians: theta from the normal plane towards the tip, phi from the major axis;
    r is the known direction (the camera), i the other (light). Arrays broadcast. S and Q are densities per dtheta_i
    dphi_i: the BCSDF is S / cos^2 theta_i, the density per solid angle Q / cos theta_i.

    estimator: exact traces at every direction and learns nothing; fitted and corrected answer by rows, which sample()
    teaches and publish() fits. Which node of the table, and which place on the fiber's width, an element has is drawn by
    (seed, stream, index): values of fitted rows and of chiang2016 and fiber3d are right in the mean over streams; those
    of the exact elliptical model are the same for all.
    One call at a time; each runs on all cores without the GIL.
    """

    def __init__(
        self,
        material: Union[Material, Keys, None] = None,
        *,
        model: str = "elliptical",
        estimator: str = "exact",
        epsilon: Optional[float] = None,
        seed: int = 0,
    ) -> None:
        keys = material.keys() if isinstance(material, Material) else dict(material or {})
        self._native = _tress.Bcsdf(json.dumps(keys), model, estimator, epsilon, seed)

    @staticmethod
    def _flat(*angles: npt.ArrayLike) -> tuple[tuple[int, ...], list[np.ndarray]]:
        arrays = np.broadcast_arrays(*[np.asarray(angle, np.float32) for angle in angles])
        return arrays[0].shape, [np.ascontiguousarray(array).reshape(-1) for array in arrays]

    def lobes(
        self,
        theta_r: npt.ArrayLike,
        phi_r: npt.ArrayLike,
        theta_i: npt.ArrayLike,
        phi_i: npt.ArrayLike,
        *,
        stream: int = 0,
    ) -> np.ndarray:
        """S of every lobe, (..., 6, 3): LOBES by channels, 1/rad^2."""
        shape, flat = self._flat(theta_r, phi_r, theta_i, phi_i)
        return self._native.evaluate(*flat, stream)[0].reshape(*shape, len(LOBES), 3)

    def evaluate(
        self,
        theta_r: npt.ArrayLike,
        phi_r: npt.ArrayLike,
        theta_i: npt.ArrayLike,
        phi_i: npt.ArrayLike,
        *,
        stream: int = 0,
    ) -> np.ndarray:
        """S, (..., 3)."""
        return self.lobes(theta_r, phi_r, theta_i, phi_i, stream=stream).sum(axis=-2)

    def pdf(
        self,
        theta_r: npt.ArrayLike,
        phi_r: npt.ArrayLike,
        theta_i: npt.ArrayLike,
        phi_i: npt.ArrayLike,
        *,
        stream: int = 0,
    ) -> np.ndarray:
        """Q of what sample() draws."""
        shape, flat = self._flat(theta_r, phi_r, theta_i, phi_i)
        return self._native.evaluate(*flat, stream)[1].reshape(shape)

    def sample(self, theta_r: npt.ArrayLike, phi_r: npt.ArrayLike, *, stream: int = 0) -> Drawn:
        """One direction for each known one."""
        shape, flat = self._flat(theta_r, phi_r)
        theta, phi, weight, pdf, lobe = self._native.sample(*flat, stream)
        return Drawn(theta.reshape(shape), phi.reshape(shape), weight.reshape(*shape, 3), pdf.reshape(shape), lobe.reshape(shape))

    def save(self, file: Union[str, os.PathLike[str]]) -> None:
        """What fitted rows have learned, joined with what the cache file holds by now."""
        self._native.save(os.fspath(file))

    def load(self, file: Union[str, os.PathLike[str]]) -> None:
        """Before the first sample()."""
        self._native.load(os.fspath(file))

    def publish(self) -> Optional[PassReport]:
        """Ends a pass: what sample() met is learned. None where there are no rows."""
        return self._native.publish()


__all__ = ["LOBES", "Bcsdf", "Drawn", "fit"]
