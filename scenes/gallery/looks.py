#!/usr/bin/python3
"""Renders one swatch of hair by look after look and tiles the pictures: looks.png in the output folder.

The looks are the rows of the table in scenes/README.md, in its order. The groom (USD, with root uv and a color by point), its
mask and the scenes are written beside the picture. Needs Debian's python3-openimageio and python3-numpy.
"""
import argparse
import json
import os
import subprocess

import numpy
import OpenImageIO

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
STRANDS, POINTS, CLUMPS = 2600, 16, 26
WIDTH, HEIGHT, COLUMNS, GAP = 144, 184, 6, 3
DIGITS = [31599, 11415, 29671, 29647, 23497, 31183, 31215, 29257, 31727, 31695]  # 3 x 5 pixels each, the highest bit first
BROWN = {"hair": "light brown"}
BLEACHED = {"melanin": {"eumelanin": 0.06, "pheomelanin": 0.08}}
MASK = {"texture": "streaks.png", "space": "linear"}

# One tile each: what the material has, and what the scene has besides.
LOOKS = [
    (BROWN, {}),
    ({"hair": {"root": "dark brown", "tip": "platinum"}}, {}),
    ({"hair": {"mix": ["dark brown", "blond"], "share": MASK}}, {}),
    ({"color": {"attribute": "Cd"}}, {}),
    ({"hair": "dark brown", "roughness": {"mix": [0.05, 0.6], "share": MASK}}, {}),
    ({"color": {"random": [[0.01, 0.08, 0.25], [0.6, 0.12, 0.02]]}}, {}),
    ({"hair": {"random": ["dark brown", "white"], "share": 0.3}}, {}),
    ({"marschner": {"hair_color": {"melanin": 0.7, "strayDensity": 0.3, "strayMelanin": 0}}}, {}),
    ({**BROWN, "gain": {"R": 0.2, "TRT": 3}, "tint": {"TRT": [1, 0.3, 0.2]}}, {}),
    ({"principled": {"melanin": 0.8, "roughness": 0.6, "coat": 1}},
     {"left": {"principled": {"melanin": 0.8, "roughness": 0.6}}}),
    (BROWN, {"looks": [{"material": "blue", "share": MASK}]}),
    ({**BROWN, "presence": {"ramp": [[0.2, 1], [0.9, 0]]}}, {}),
    ({"hair": "white", "thickness": {"random": [0, 0.25], "share": 0.015}}, {"layer": "coverage", "least_width": 1}),
    (BROWN, {"red": {"include": ["hair"]}}),
    (BROWN, {"layer": "CryptoStrand"}),
    (BROWN, {"layer": "P"}),
    (BROWN, {"layer": "strand_uv"}),
    (BROWN, {"layer": "strand_place"}),
    ({"melanin": {"eumelanin": {"normal": 0.5, "deviation": 0.25}}}, {}),
    ({"color": {"hsvadjust": [0.5, 0.12, 0.05], "hue": {"normal": 0, "deviation": 0.08}, "value": {"random": [0.5, 1.5], "seed": 1}}}, {}),
    ({"hair": "blond", "dye": {"root": [1, 1, 1], "tip": [0.1, 0.3, 0.9]}}, {}),
    ({"marschner": {"hair_color": {"melanin": 0.05, "strayDensity": 0, "dye": [0.9, 0.25, 0.3], "randomDyeHue": 0.4}}}, {}),
    ({**BROWN, "thickness": {"random": [0, 2], "share": 0.5}}, {"left": BROWN}),
    (BROWN, {"instances": [{"scale": 0.35, "translate": [0.75 * x, 0, z]} for z in (1.1, -1) for x in (-1, 1)]}),
    ({**BROWN, "wetness": 1}, {"left": BROWN}),
    ({**BLEACHED, "cortex": {"scattering": 1.5, "asymmetry": 0.2}}, {"left": BLEACHED}),
]


def text_of(rows):
    return "[" + ", ".join("(" + ", ".join(f"{x:.4g}" for x in row) + ")" for row in rows) + "]"


def rectangle(center, edge_cm, radiance):
    return {"rectangle": {"center": center, "look_at": [0, 0, -0.5], "width_cm": edge_cm, "height_cm": edge_cm, "radiance": radiance}}


def write_groom(folder):
    """A weft that rises from a band of scalp, bends over and hangs, in clumps; u runs across, v to the back."""
    draw = numpy.random.default_rng(1)
    u, v = draw.random(STRANDS), draw.random(STRANDS)
    t = numpy.linspace(0, 1, POINTS)
    clump = numpy.floor(u * CLUMPS)
    middle = (clump + 0.5 + 0.3 * draw.standard_normal(CLUMPS)[clump.astype(int)]) / CLUMPS
    phase = 0.6 * draw.standard_normal(CLUMPS)[clump.astype(int)]
    length = 4.9 + 0.35 * draw.standard_normal(CLUMPS)[clump.astype(int)] + 0.25 * draw.standard_normal(STRANDS)
    gone = length[:, None] * t
    radius = 0.8 + 0.4 * v[:, None]  # of the bend: hair from further back lies on top
    angle = numpy.minimum(gone / radius, numpy.pi / 2)
    hang = gone - angle * radius
    wave = 0.11 * numpy.sin(2.4 * hang + phase[:, None]) * numpy.minimum(hang, 1)
    stray = draw.standard_normal((2, STRANDS))[:, :, None] * 0.07 * t**2
    x = (u[:, None] + (middle - u)[:, None] * 0.75 * t**1.5 - 0.5) * 3 + wave + stray[0]
    y = -radius * numpy.sin(angle) + stray[1]
    z = 1.2 + radius * numpy.cos(angle) - hang + 0.25 * v[:, None]
    points = numpy.stack([x, y, z], 2).reshape(-1, 3)
    hue = (1.2 * u[:, None] + 1.5 * t)[:, :, None] + numpy.array([0, 1 / 3, 2 / 3])
    color = (0.06 + 0.6 * (0.5 + 0.5 * numpy.cos(2 * numpy.pi * hue)) ** 2).reshape(-1, 3)
    with open(os.path.join(folder, "swatch.usda"), "w") as file:
        file.write('#usda 1.0\n(metersPerUnit = 0.01\nupAxis = "Z")\ndef BasisCurves "hair" {\n'
                   '  uniform token type = "cubic"\n  uniform token basis = "bspline"\n  uniform token wrap = "pinned"\n'
                   f"  int[] curveVertexCounts = {[POINTS] * STRANDS}\n  point3f[] points = {text_of(points)}\n"
                   '  float[] widths = [0.018] (interpolation = "constant")\n'
                   f"  int[] primvars:id = {list(range(STRANDS))} (interpolation = \"uniform\")\n"
                   f"  color3f[] primvars:Cd = {text_of(color)} (interpolation = \"vertex\")\n"
                   f"  texCoord2f[] primvars:st = {text_of(zip(u, v))} (interpolation = \"uniform\")\n}}\n")
    streaks = numpy.zeros((8, 64, 1), numpy.uint8)
    for first, last in ((8, 13), (24, 36), (48, 54)):
        streaks[:, first:last] = 255
    write_png(streaks, os.path.join(folder, "streaks.png"))


def write_png(pixels, path):
    image = OpenImageIO.ImageBuf(OpenImageIO.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], OpenImageIO.UINT8))
    image.set_pixels(OpenImageIO.ROI(0, pixels.shape[1], 0, pixels.shape[0], 0, 1, 0, pixels.shape[2]), numpy.ascontiguousarray(pixels))
    image.write(path)


def scene(material, extra):
    lights = [rectangle([-9, -14, 12], 8, [14, 13.5, 13]), rectangle([9, 9, 6], 10, [10, 10, 10.5])]
    if "red" in extra:
        lights.append({**rectangle([12, -8, 2], 8, [40, 3, 2]), "light_link": extra["red"]})
    made = {"camera": {"eye": [-3, -16, 5], "look_at": [0, -0.9, -0.05], "vertical_fov_deg": 20},
            "image": {"width": WIDTH, "height": HEIGHT, "view": "agx", "exposure": 0.8},
            "environment": {"constant": [0.12, 0.12, 0.125]}, "lights": lights,
            "materials": [{"name": "look", **material}, {"name": "blue", "color": [0.05, 0.25, 0.7]}],
            "grooms": [{"name": "hair", "file": "swatch.usda", "material": "look", "looks": extra.get("looks", [])}]}
    if "instances" in extra:
        made["grooms"][0]["instances"] = extra["instances"]
    if "red" in extra:
        made["meshes"] = [{"name": "ball", "file": os.path.join(ROOT, "scenes", "sphere.obj"), "translate": [1.3, -2.6, -1.6],
                           "scale": 0.8, "albedo": [0.5, 0.5, 0.5]}]
    return made


def layer_as_colors(exr, name):
    """What a layer of data says, as colors on black."""
    image = OpenImageIO.ImageBuf(exr)
    layers = dict(zip(image.spec().channelnames, numpy.moveaxis(image.get_pixels(OpenImageIO.FLOAT), 2, 0)))
    if name == "P":
        colors = numpy.stack([(layers["P." + axis] / 5 + 0.5) * layers["coverage"] for axis in "XYZ"], 2)
    elif name == "strand_uv":
        colors = numpy.stack([layers["strand_uv.u"], layers["strand_uv.v"], 0 * layers["strand_uv.u"]], 2)
    elif name == "CryptoStrand":
        colors = numpy.zeros((HEIGHT, WIDTH, 3))
        for rank in range(12):
            strand, share = (f"CryptoStrand{rank // 2:02}.{letter}" for letter in ("RG", "BA")[rank % 2])
            bits = numpy.ascontiguousarray(layers[strand]).view(numpy.uint32)
            colors += numpy.stack([bits >> shift & 255 for shift in (0, 8, 16)], 2) / 255 * layers[share][:, :, None]
    else:
        colors = numpy.repeat(layers[name][:, :, None], 3, 2)
    return numpy.round(255 * numpy.clip(colors, 0, 1)).astype(numpy.uint8)


def tile(number, folder, tress, samples):
    """The picture of a look; where it has something to be held against, that is its left half."""

    def render(name, material, *more):
        file, exr = (os.path.join(folder, name + end) for end in (".json", ".exr"))
        with open(file, "w") as stream:
            json.dump(scene(material, extra), stream, indent=1)
        wanted = ("--layers", "all" if extra["layer"] == "coverage" else "all," + extra["layer"]) if "layer" in extra else ("--denoise",)
        subprocess.run([tress, "render", file, "-o", exr, "--warm-cache", os.path.join(folder, "looks.cache"), *wanted, *more], check=True)
        return layer_as_colors(exr, extra["layer"]) if "layer" in extra else OpenImageIO.ImageBuf(exr[:-4] + ".png").get_pixels(
            OpenImageIO.UINT8)[:, :, :3]

    material, extra = LOOKS[number - 1]
    name, spp = f"look_{number:02}", ("--spp", str(samples))
    if "least_width" in extra:
        pixels = render(name, material, "--spp", "16", "--set", f"image/least_width={extra['least_width']}")
        pixels[:, :WIDTH // 2] = render(name + "_left", material, "--spp", "16")[:, :WIDTH // 2]
        pixels = numpy.minimum(pixels[60:60 + HEIGHT // 4, 54:54 + WIDTH // 4], 85).repeat(4, 0).repeat(4, 1) * 3  # 4 times as large
    else:
        pixels = render(name, material, *spp)
    if "left" in extra:
        pixels[:, :WIDTH // 2] = render(name + "_left", extra["left"], *spp)[:, :WIDTH // 2]
    for place, digit in enumerate(str(number)):  # in the upper left corner, each dot 2 x 2 pixels
        for dot in range(15):
            if DIGITS[int(digit)] >> 14 - dot & 1:
                row, column = 5 + 2 * (dot // 3), 5 + 8 * place + 2 * (dot % 3)
                pixels[row:row + 2, column:column + 2] = 255
    return pixels


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", default=os.path.join(ROOT, "build", "gallery"), help="folder")
    parser.add_argument("--tress", default=os.path.join(ROOT, "build", "release", "tress"), help="the program")
    parser.add_argument("--samples", type=int, default=48, help="a pixel")
    parser.add_argument("--first", type=int, default=1, help="look to render; those before are of scenes/looks.png")
    options = parser.parse_args()
    os.makedirs(options.output, exist_ok=True)
    write_groom(options.output)
    rows = -(-len(LOOKS) // COLUMNS)
    sheet = numpy.full((rows * (HEIGHT + GAP) - GAP, COLUMNS * (WIDTH + GAP) - GAP, 3), 255, numpy.uint8)
    if options.first > 1:
        known = OpenImageIO.ImageBuf(os.path.join(ROOT, "scenes", "looks.png")).get_pixels(OpenImageIO.UINT8)[:, :, :3]
        sheet[:known.shape[0]] = known[:sheet.shape[0]]
    for index in range(options.first - 1, len(LOOKS)):
        row, column = index // COLUMNS * (HEIGHT + GAP), index % COLUMNS * (WIDTH + GAP)
        sheet[row:row + HEIGHT, column:column + WIDTH] = tile(index + 1, options.output, options.tress, options.samples)
    write_png(sheet, os.path.join(options.output, "looks.png"))


if __name__ == "__main__":
    main()
