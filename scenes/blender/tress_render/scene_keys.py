"""Keys of a tress scene (scenes/README.md) from what an artist's scene says in plain numbers. Knows nothing of Blender.

Lengths are in units of the host, `cm` centimetres each; matrices are 4 x 4 numpy arrays, camera and lights look along
their -z. What has no counterpart goes to `warnings`, a Warnings.
"""

import math

import numpy as np

SMALLEST_CM = 0.001  # of edges and radii of lights


class Warnings:
    """What could not be handed over: each sentence once, in the order they were met."""

    def __init__(self):
        self.said = []

    def __call__(self, sentence):
        if sentence not in self.said:
            self.said.append(sentence)


def triple(x):
    return [float(v) for v in x]


def axes(matrix):
    """Unit x, y, z of a matrix, and their lengths."""
    columns = [np.asarray(matrix, float)[:3, i] for i in range(3)]
    lengths = [float(np.linalg.norm(c)) or 1.0 for c in columns]
    return [c / l for c, l in zip(columns, lengths)], lengths


def place(matrix, cm):
    return np.asarray(matrix, float)[:3, 3] * cm


def camera(matrix, cm, width, height, kind="PERSP", lens_mm=50.0, ortho_scale=6.0, sensor_mm=36.0, sensor_height_mm=24.0,
           sensor_fit="AUTO", shift_x=0.0, shift_y=0.0, pixel_aspect=1.0, dof=None, warnings=Warnings()):
    """Keys of `camera`. dof: None or a dict of fstop, distance (units), blades, rotation (radians), ratio."""
    x, y, z = axes(matrix)[0]
    eye = place(matrix, cm)
    if abs(pixel_aspect - 1) > 1e-6:
        warnings("pixels that are not square: taken for square")
    across = {"AUTO": "width" if width >= height else "height", "HORIZONTAL": "width", "VERTICAL": "height"}[sensor_fit]
    # Blender counts shifts in the side that the sensor fits, its sensor being that wide or, where it says so, high.
    side = width if across == "width" else height
    distance = dof["distance"] * cm if dof else 10.0
    keys = {"eye": triple(eye), "look_at": triple(eye - max(distance, SMALLEST_CM) * z), "up": triple(y)}
    if kind == "ORTHO":
        keys["orthographic_height_cm"] = ortho_scale * cm * height / side
    else:
        if kind != "PERSP":
            warnings(f"a camera of type {kind}: rendered as a perspective one")
        keys["focal_length_mm"] = lens_mm
        keys["sensor_mm"] = sensor_height_mm if sensor_fit == "VERTICAL" else sensor_mm
        keys["sensor_fit"] = across
    if shift_x:
        keys["shift_x"] = shift_x * side / width
    if shift_y:
        keys["shift_y"] = shift_y * side / height
    if dof:
        if abs(dof.get("ratio", 1) - 1) > 1e-6:
            warnings("an anamorphic aperture (ratio): rendered as a round one")
        lens = {"focus_cm": max(distance, SMALLEST_CM)}
        if kind == "ORTHO":
            lens["radius_cm"] = max(cm / (2 * dof["fstop"]), 1e-4)  # as Cycles has it: a lens of 1 unit
        else:
            # The focal length in metres over the f-number, in units of the host.
            lens["radius_cm"] = max(lens_mm * 1e-3 / (2 * dof["fstop"]) * cm, 1e-4)
        if dof.get("blades", 0) > 2:
            lens["blades"] = int(dof["blades"])
            lens["blade_rotation_deg"] = math.degrees(dof.get("rotation", 0))
        keys["depth_of_field"] = lens
    return keys


def sun(matrix, color, strength, angle):
    """A sun of `strength` W/m2 across its direction. angle: full, radians."""
    z = axes(matrix)[0][2]
    return {"distant": {"direction": triple(z), "angle_deg": min(max(math.degrees(angle), 0.01), 180.0),
                        "irradiance": triple(np.asarray(color) * strength)}}


def area(matrix, cm, color, watts, shape, size, size_y, spread=math.pi, warnings=Warnings(), are_true_watts=False):
    """A lamp of `watts`, as Blender counts them, from a rectangle or, approximately, from that of an ellipse's area.

    are_true_watts: they are the flux, as in Blender 4.3; else, as in 3.4, pi / 4 of them are.
    """
    (x, y, z), (sx, sy, _) = axes(matrix)
    width, height = size * sx, (size_y if shape in ("RECTANGLE", "ELLIPSE") else size) * sy
    area_units = width * height
    if shape in ("DISK", "ELLIPSE"):
        warnings("round area lights: squares of the same area and power")
        root = math.sqrt(math.pi / 4)
        width, height, area_units = width * root, height * root, area_units * math.pi / 4
    if spread < math.radians(179):
        warnings("the spread of area lights is not used: they shine as surfaces do")
    center = place(matrix, cm)
    least = SMALLEST_CM / cm
    # A Lambertian surface has 1/pi of its power per area for radiance; Cycles took a quarter.
    radiance = np.asarray(color) * watts / ((math.pi if are_true_watts else 4) * max(area_units, least * least))
    return {"rectangle": {"center": triple(center), "look_at": triple(center - 10 * z), "up": triple(y),
                          "width_cm": max(width * cm, SMALLEST_CM), "height_cm": max(height * cm, SMALLEST_CM),
                          "radiance": triple(radiance)}}


def ball_radius(radius, cm):
    """Lamps without a size have a small one: 0.1 mm, with the same power."""
    return max(radius, 0.01 / cm)


def point(matrix, cm, color, watts, radius):
    """A ball that sends `watts` into all directions."""
    radius = ball_radius(radius, cm)
    radiance = np.asarray(color) * watts / (4 * math.pi ** 2 * radius ** 2)
    return {"sphere": {"center": triple(place(matrix, cm)), "radius_cm": radius * cm, "radiance": triple(radiance)}}


def spot(matrix, cm, color, watts, radius, cone, blend):
    """A point light of the same watts of which only a cone is let through. cone: full angle, radians."""
    z = axes(matrix)[0][2]
    radius = ball_radius(radius, cm)
    center = place(matrix, cm)
    radiance = np.asarray(color) * watts / (4 * math.pi ** 2 * radius ** 2)
    return {"spot": {"center": triple(center), "look_at": triple(center - 10 * z), "radius_cm": radius * cm,
                     "cone_deg": min(max(math.degrees(cone), 0.1), 180.0), "soft": min(max(blend, 0.0), 1.0),
                     "radiance": triple(radiance)}}


def link(collection, names_of):
    """`include` or `exclude` of light_link or shadow_link, or None: a collection of Blender 4.0 and later whose members
    have a state each. names_of(object): what it is called in the scene."""
    found = [(state, names_of(ob)) for ob, state in _members(collection)]
    of = lambda asked: {name for state, names in found if state == asked for name in names}
    if any(state == "INCLUDE" for state, _ in found):
        return {"include": sorted(of("INCLUDE") - of("EXCLUDE"))}
    return {"exclude": sorted(of("EXCLUDE"))} if found else None


def _members(collection, state=None):
    """The state of a collection in another is that of all that is in it."""
    for ob, entry in zip(collection.objects, collection.collection_objects):
        yield ob, state or entry.light_linking.link_state
    for child, entry in zip(collection.children, collection.collection_children):
        yield from _members(child, state or entry.light_linking.link_state)


def environment_map(file, strength, turn):
    """A latitude-longitude picture whose middle is seen along +x. turn: of the picture, radians, from above."""
    degrees = (90 + math.degrees(turn) + 180) % 360 - 180
    return {"file": file, "scale": float(strength), "rotate_deg": degrees}


def crop(border, width, height):
    """X0, Y0, X1, Y1 of --crop from a border (min x, min y, max x, max y) in shares of the picture, y up; the last two
    excluded, one pixel at least."""
    x0, x1 = int(border[0] * width), int(border[2] * width)
    y0, y1 = int(border[1] * height), int(border[3] * height)
    x0, y0 = min(max(x0, 0), width - 1), min(max(y0, 0), height - 1)
    x1, y1 = min(max(x1, x0 + 1), width), min(max(y1, y0 + 1), height)
    return x0, height - y1, x1, height - y0
