"""What tests of the module share. TRESS_SOURCE_DIR, TRESS_BINARY, TRESS_LAB and TRESS_PACKAGE say where things are."""

import os
import pathlib

import numpy as np

SOURCE = pathlib.Path(os.environ["TRESS_SOURCE_DIR"])
BINARY = pathlib.Path(os.environ["TRESS_BINARY"])
LABORATORY = pathlib.Path(os.environ["TRESS_LAB"])
PACKAGE = pathlib.Path(os.environ["TRESS_PACKAGE"])  # the folder that has tress/


def two_strands():
    """(2, 8, 3), centimetres, falling."""
    points = np.zeros((2, 8, 3), np.float32)
    points[:, :, 2] = -np.arange(8)
    points[1, :, 0] = 1
    points[:, :, 0] += 5
    return points


def lock(strands=300, seed=1):
    """(strands, 8, 3): a small lock that fills a picture."""
    root = np.random.default_rng(seed).uniform(-2, 2, (strands, 1, 3)) * [1, 1, 0]
    return (root + np.linspace(0, 1, 8)[:, None] * [0.5, 0, -6]).astype(np.float32)
