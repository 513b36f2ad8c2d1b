"""Light that is scattered many times, by a second program: straight_lock.py TRESS FOLDER [ROUGHNESS...]

A lock of white, straight, parallel strands under a sun, by `tress render --model chiang2016` and by a Monte Carlo that shares
no line with it: Chiang et al. 2016 and ribbons in numpy. Fails where the means differ by more than 4 standard errors of
both together (false-alarm rate 6e-5 each; seeds are fixed).

straight_lock.py --as-cycles FOLDER [ROUGHNESS...] prints the second program's mean by the most hits a path may have: as it is, with Cycles'
geometry (light leaves a ribbon where it met it, not as far from the axis as it came, and no ribbon is met within two radii of where light starts),
with the random numbers of Cycles 3.4 (lcg_of_cycles), and with both.
"""

import json
import math
import pathlib
import struct
import subprocess
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scenes" / "blender" / "tress_render"))
import files  # noqa: E402

TRESS, FOLDER = sys.argv[1], pathlib.Path(sys.argv[2])
ROUGHNESS = [float(x) for x in sys.argv[3:]] or [0.3, 0.1]
STRANDS, RADIUS, LOCK, HALF_LENGTH, ETA = 150, 0.05, 1.0, 4.0, 1.55  # cm
SUN = np.array([0.0, -1.0, 0.65]) / math.hypot(1, 0.65)
SUN_ANGLE, IRRADIANCE, RADIAL = 0.1, 2.0, 0.3
EYE, FOV = np.array([0.0, -40.0, 0.0]), math.radians(2)
DEPTH = 64
NEAR_OF_CYCLES = 2 * RADIUS  # from where light starts: what Cycles does not meet

random = np.random.default_rng(7)
angle, away = random.uniform(0, 2 * math.pi, STRANDS), LOCK * np.sqrt(random.uniform(0, 1, STRANDS))
AXES = np.stack([away * np.cos(angle), away * np.sin(angle)], 1)


def widths(roughness):
    """Variances of M of R, TT, TRT and the rest, logistic scales of N of R, TT, TRT."""
    deviation = 0.726 * roughness + 0.812 * roughness**2 + 3.7 * roughness**20
    scale = (0.265 * RADIAL + 1.194 * RADIAL**2 + 5.372 * RADIAL**22) * math.sqrt(math.pi / 8)
    return deviation**2 * np.array([1, 0.25, 4, 4]), np.full(3, scale)


def fresnel(cosine):
    inner = np.sqrt(1 - (1 - cosine**2) / ETA**2)
    return 0.5 * (((cosine - ETA * inner) / (cosine + ETA * inner))**2 + ((ETA * cosine - inner) / (ETA * cosine + inner))**2)


def longitudinal(sin_i, sin_o, v):
    cos_i, cos_o = np.sqrt(1 - sin_i**2), np.sqrt(1 - sin_o**2)
    a = cos_i * cos_o / v
    log_i0 = np.where(a > 500, a - 0.5 * np.log(2 * math.pi * np.maximum(a, 1)) + 1 / (8 * np.maximum(a, 1)),
                      np.log(np.i0(np.minimum(a, 500))))
    return np.exp(log_i0 - sin_i * sin_o / v - 1 / v) / (v * (1 - math.exp(-2 / v)))


def logistic(x, s):
    e = np.exp(-np.abs((x + math.pi) % (2 * math.pi) - math.pi) / s)
    return e / (s * (1 + e)**2) / math.tanh(0.5 * math.pi / s)


def meet(at, way, left, near=0.0):
    """Nearest ribbon ahead but for the strand that is left, and at least `near` away from what is left: its index or -1, the distance, the offset over the radius."""
    across = np.hypot(way[:, 0], way[:, 1])[:, None]
    d = way[:, :2] / across
    to = AXES[None] - at[:, None, :2]
    along = to[..., 0] * d[:, None, 0] + to[..., 1] * d[:, None, 1]
    offset = to[..., 0] * d[:, None, 1] - to[..., 1] * d[:, None, 0]  # of the axis, along way x z; the ray's is its opposite
    z = at[:, None, 2] + along / across * way[:, None, 2]
    is_met = (np.abs(offset) < RADIUS) & (along > 0) & (np.abs(z) < HALF_LENGTH)
    is_met[np.arange(len(at))[left >= 0], left[left >= 0]] = False
    is_met &= (along > near * across) | (left < 0)[:, None]
    along = np.where(is_met, along, np.inf)
    nearest = along.argmin(1)
    rows = np.arange(len(at))
    distance = along[rows, nearest] / across[:, 0]
    return np.where(np.isfinite(distance), nearest, -1), distance, -offset[rows, nearest] / RADIUS


def start(axis, way, offset):
    side = np.stack([way[:, 1], -way[:, 0]], 1) / np.hypot(way[:, 0], way[:, 1])[:, None]
    return np.concatenate([axis[:, :2] + RADIUS * offset[:, None] * side, axis[:, 2:]], 1)


def sun_directions(count):
    height = 1 - random.uniform(0, 1, count) * (1 - math.cos(SUN_ANGLE / 2))
    turn, sine = random.uniform(0, 2 * math.pi, count), np.sqrt(1 - height**2)
    other = np.cross([1.0, 0, 0], SUN)
    return (height[:, None] * SUN + (sine * np.cos(turn))[:, None] * [1.0, 0, 0] + (sine * np.sin(turn))[:, None] * other)


def lcg_of_cycles(seed, hit):
    """The two random numbers that Cycles 3.4 draws inclinations by at that hit of the path: of a linear congruential generator whose seed goes up by 16
    a hit (sample/lcg.h), so that they go up by 0.1647 and 0.0307 (mod 1)."""
    state, drawn = (seed + 16 * (hit + 1)).astype(np.uint64), []
    for _ in range(3):
        state = (1103515245 * state + 12345) & 0xFFFFFFFF
        drawn.append(state / 4294967295.0)
    return np.maximum(drawn[1], 1e-5), drawn[2]


def second_program(roughness, paths, depth=DEPTH, as_cycles=False, numbers_of_cycles=False):
    """Mean radiance of the picture, of paths of `depth` hits at most, and its standard error."""
    near = NEAR_OF_CYCLES if as_cycles else 0.0
    seed = random.integers(0, 2**32, paths) if numbers_of_cycles else None
    variance, scale = widths(roughness)
    tangent = math.tan(FOV / 2)
    x, y = random.uniform(-tangent, tangent, (2, paths))
    way = np.stack([x, np.ones(paths), y], 1)
    way /= np.linalg.norm(way, axis=1)[:, None]
    at, left, light, path = np.tile(EYE, (paths, 1)), np.full(paths, -1), np.zeros(paths), np.arange(paths)
    for hit in range(depth):
        strand, distance, offset = meet(at, way, left, near)
        met = strand >= 0
        at, way, left, path = at[met], way[met], strand[met], path[met]
        distance, h = distance[met], np.clip(offset[met], -1, 1)
        if len(path) == 0:
            break
        axis = np.concatenate([AXES[left], (at + distance[:, None] * way)[:, 2:]], 1)
        sin_o = -way[:, 2]
        cos_o = np.sqrt(1 - sin_o**2)
        phi_o = np.arctan2(-way[:, 1], -way[:, 0])
        gamma, inner = np.arcsin(h), np.arcsin(h * cos_o / np.sqrt(ETA**2 - sin_o**2))
        f = fresnel(cos_o * np.cos(gamma))
        share = np.stack([f, (1 - f)**2, (1 - f)**2 * f, (1 - f) * f * f])
        # Clockwise, seen from the tip: a ray to the right of the axis (way x z) is reflected to the right.
        turned = [math.pi * p - 2 * gamma + 2 * p * inner for p in range(3)]

        def scattered(direction):
            phi = phi_o - np.arctan2(direction[:, 1], direction[:, 0])
            total = share[3] * longitudinal(direction[:, 2], sin_o, variance[3]) / (2 * math.pi)
            for p in range(3):
                total = total + share[p] * longitudinal(direction[:, 2], sin_o, variance[p]) * logistic(phi - turned[p], scale[p])
            return total

        sun, met_at = sun_directions(len(path)), start(axis, way, h)
        is_dark = meet(met_at if as_cycles else start(axis, sun, h), sun, left, near)[0] >= 0
        light[path] += np.where(is_dark, 0, IRRADIANCE * scattered(sun))
        order = (random.uniform(0, 1, len(path)) > np.cumsum(share, 0)).sum(0).clip(0, 3)
        v = variance[order]
        u, turn = (lcg_of_cycles(seed[path], hit) if numbers_of_cycles else
                   (random.uniform(1e-12, 1, len(path)), random.uniform(0, 1, len(path))))
        cosine = 1 + v * np.log(u + (1 - u) * np.exp(-2 / v))
        sin_i = -cosine * sin_o + np.sqrt(np.maximum(0, 1 - cosine**2)) * np.cos(2 * math.pi * turn) * cos_o
        sin_i = sin_i.clip(-0.999999, 0.999999)
        s = scale[order.clip(0, 2)]
        spread = 2 * s * np.arctanh(((2 * random.uniform(0, 1, len(path)) - 1) * np.tanh(0.5 * math.pi / s)).clip(-1 + 1e-15, 1 - 1e-15))
        phi = np.where(order < 3, np.choose(order.clip(0, 2), turned) + spread, random.uniform(-math.pi, math.pi, len(path)))
        cos_i = np.sqrt(1 - sin_i**2)
        way = np.stack([cos_i * np.cos(phi_o - phi), cos_i * np.sin(phi_o - phi), sin_i], 1)
        at = met_at if as_cycles else start(axis, way, h)
    return light.mean(), light.std() / math.sqrt(paths)


def write_hair(file):
    header = b"HAIR" + struct.pack("<IIIIffffff", STRANDS, 4 * STRANDS, 2, 3, 2 * RADIUS, 0, 1, 1, 1, 0)[:36]
    points = np.stack([np.concatenate([np.tile(a, (4, 1)), np.linspace(HALF_LENGTH, -HALF_LENGTH, 4)[:, None]], 1) for a in AXES])
    file.write_bytes(header.ljust(128, b"\0") + points.astype("<f4").tobytes())


def of_tress(roughness):
    variance, scale = widths(roughness)
    degree = np.degrees(np.sqrt(variance) * math.sqrt(3) / (2 * math.pi))
    blur = math.degrees(scale[1] * math.pi / math.sqrt(3))
    scene = {
        "camera": {"eye": EYE.tolist(), "look_at": [0, 0, 0], "vertical_fov_deg": math.degrees(FOV)},
        "image": {"width": 64, "height": 64, "samples": 128},
        "lights": [{"distant": {"direction": SUN.tolist(), "angle_deg": math.degrees(SUN_ANGLE), "irradiance": [IRRADIANCE] * 3}}],
        "materials": [{"name": "white", "eccentricity": 1, "eta": ETA, "tilt_deg": 0, "roughness": 0.02, "sigma_a": [0, 0, 0],
                       "longitudinal_lambda_deg": dict(zip(("R", "TT", "TRT", "TRRT"), degree.tolist())),
                       "azimuthal_sigma_deg": dict.fromkeys(("TT", "TRT", "TRRT"), blur)}],
        "environment": {"constant": [0, 0, 0]},
        "grooms": [{"file": "lock.hair", "radius_cm": RADIUS, "up": "z", "cm_per_unit": 1, "basis": "linear", "material": "white"}],
    }
    (FOLDER / "lock.json").write_text(json.dumps(scene))
    picture = FOLDER / "lock.exr"
    subprocess.run([TRESS, "render", FOLDER / "lock.json", "-o", picture, "--model", "chiang2016", "--max-depth", str(DEPTH),
                    "--quiet"], check=True)
    channels = files.read_exr(picture).channels
    red = channels["R"].astype(float)
    return red.mean(), math.sqrt(channels["variance.R"].astype(float).sum()) / red.size


def beside_cycles():
    for roughness in ROUGHNESS:
        for geometry, numbers in ((False, False), (True, False), (False, True), (True, True)):
            what = " and ".join(name for name, is_so in (("geometry", geometry), ("numbers", numbers)) if is_so)
            for depth in (1, 2, 3, DEPTH):
                mean, error = second_program(roughness, 60000, depth, geometry, numbers)
                print(f"roughness {roughness}, {what + ' of Cycles' if what else 'as it is'}, hits {depth}: {mean:.6f} +- {error:.6f}",
                      flush=True)
    return 0


def main():
    FOLDER.mkdir(parents=True, exist_ok=True)
    write_hair(FOLDER / "lock.hair")
    failed = False
    for roughness in ROUGHNESS:
        (theirs, of_theirs), (ours, of_ours) = second_program(roughness, 25000), of_tress(roughness)
        z = (ours - theirs) / math.hypot(of_theirs, of_ours)
        print(f"roughness {roughness}: tress {ours:.5f} +- {of_ours:.5f}, second program {theirs:.5f} +- {of_theirs:.5f}, z {z:.2f}")
        failed = failed or not abs(z) < 4
    return failed


if __name__ == "__main__":
    sys.exit(beside_cycles() if TRESS == "--as-cycles" else main())
