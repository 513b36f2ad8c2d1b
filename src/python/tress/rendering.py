"""render()."""

from __future__ import annotations

import json
import os
import warnings as python_warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Optional, Union

from . import _tress
from ._tress import Progress
from .objects import Scene
from .pictures import Picture

Path = Union[str, os.PathLike[str]]


def render(
    scene: Union[Scene, Mapping[str, Any], Path],
    *,
    samples: Optional[int] = None,
    noise: Optional[float] = None,
    seconds: Optional[float] = None,
    width: Optional[int] = None,
    height: Optional[int] = None,
    frame: Optional[int] = None,
    least_width: Optional[float] = None,
    curve_error: Optional[float] = None,
    crop: Optional[tuple[int, int, int, int]] = None,
    seed: Optional[int] = None,
    model: Optional[str] = None,
    estimator: str = "fitted",
    epsilon: Optional[float] = None,
    picture_error: Optional[float] = None,
    learner: Optional[str] = None,
    table_memory: Optional[int] = None,
    warm_cache: Optional[Path] = None,
    cache_mode: str = "append",
    cache_limit: Optional[float] = None,
    light_samples: Optional[int] = None,
    bcsdf_samples: Optional[int] = None,
    near: Union[float, str, None] = None,
    max_depth: Optional[int] = None,
    roulette: Optional[str] = None,
    deep_light: Optional[str] = None,
    deep_light_depth: Optional[int] = None,
    adaptive: Optional[bool] = None,
    spectral: Optional[bool] = None,
    denoise: bool = False,
    mattes: bool = True,
    layers: Sequence[str] = (),
    threads: Optional[int] = None,
    progress: Optional[Callable[[Progress], Any]] = None,
) -> Picture:
    """Renders a Scene, the keys of a scene file as a dict, or a file: a scene or a bare groom.

    What is given is what the option of `tress render` of that name means (`tress render --help`), and None is its
    default; the same scene and options give the same bits as the program. seed: the frame, or 0.
    model: None is by the scene's materials alone: `chiang2016` where all hair is given by its lobes (principled); else
    `elliptical` where a material shapes lobes; else `rough`. An option that the model has not is an error: corrected and
    a learner are of `elliptical`, an epsilon, picture_error and table_memory of models with rows.
    warm_cache: a file, or "default" for $XDG_CACHE_HOME/tress, else ~/.cache/tress, with a file for each kind of fiber;
    cache_limit: MB that this may take, 1024 by default. The kinds that were used longest ago go.
    denoise: a layer `denoised` beside R, G, B, which a .png shows; stats["denoised_noise"] is the noise that is left, by
    which `noise` goes then.
    layers: beside the usual ones, data for compositors: some of P, strand_uv, strand_place, strand_id, CryptoStrand.
    progress: called after each pass on the calling thread; it may return False to end the render there. What it raises
    ends the render and comes out of here. So does Ctrl-C (KeyboardInterrupt); what was learned is then in the warm
    cache all the same.
    What the scene's reader warns of is warned of here (`warnings`); what it notes is in the picture's stats["notes"].
    """
    keywords = {
        key: value
        for key, value in {
            "samples": samples,
            "noise": noise,
            "seconds": seconds,
            "width": width,
            "height": height,
            "frame": frame,
            "least_width": least_width,
            "curve_error": curve_error,
            "crop": crop,
            "seed": seed,
            "model": model,
            "estimator": estimator,
            "epsilon": epsilon,
            "picture_error": picture_error,
            "learner": learner,
            "table_memory": table_memory,
            "warm_cache": None if warm_cache is None else os.fspath(warm_cache),
            "cache_mode": cache_mode,
            "cache_limit": cache_limit,
            "light_samples": light_samples,
            "bcsdf_samples": bcsdf_samples,
            "near": near,
            "max_depth": max_depth,
            "roulette": roulette,
            "deep_light": deep_light,
            "deep_light_depth": deep_light_depth,
            "adaptive": adaptive,
            "spectral": spectral,
            "denoise": denoise,
            "mattes": mattes,
            "layers": list(layers),
            "threads": threads,
        }.items()
        if value is not None
    }
    if isinstance(scene, (str, os.PathLike)):
        native = _tress.render(os.fspath(scene), "", "", {}, keywords, progress)
    else:
        whole = scene if isinstance(scene, Scene) else Scene.from_keys(scene)
        keys, arrays = whole._native()
        native = _tress.render(None, json.dumps(keys), whole.folder, arrays, keywords, progress)
    for text in native.stats["warnings"]:
        python_warnings.warn(text, stacklevel=2)
    return Picture(native)
