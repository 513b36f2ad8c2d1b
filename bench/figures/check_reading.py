#!/usr/bin/python3
"""Whether figures.read() gives a picture as it is, of a file that was written again within the same second.

usage: bench/figures/check_reading.py

Renders of small pictures take less than a second and go to the same file under one seed after another. Silent, or ends with 1.
"""
import os
import sys
import tempfile

import figures
import numpy

OpenImageIO = figures.OpenImageIO


def write(path, value):
    out = OpenImageIO.ImageBuf(OpenImageIO.ImageSpec(4, 4, 4, OpenImageIO.FLOAT))
    OpenImageIO.ImageBufAlgo.fill(out, (value, value, value, value))
    out.write(path)


with tempfile.TemporaryDirectory() as folder:
    path = os.path.join(folder, "picture.exr")
    for value in (0.125, 0.25, 0.5, 0.75):
        write(path + ".new.exr", value)  # beside it: what this process writes it does read again
        os.replace(path + ".new.exr", path)
        os.utime(path, (1e9, 1e9))
        found = [float(numpy.mean(read(path))) for read in (figures.read, figures.coverage)]
        if found != [value, value]:
            sys.exit(f"{path}: expected {value}, as it was written last, found {found} in R, G, B and the coverage")
