"""A groom from arrays: curls over a ball, three materials' worth of color, a light, and a look at the layers."""

# %% Strands: (strand, point, xyz) in centimetres, root first
import os

import numpy as np
import tress

small = bool(os.environ.get("TRESS_EXAMPLE_SMALL"))  # the tests run this on a thumbnail
random = np.random.default_rng(7)
count, points = (400 if small else 15000), 24
direction = random.standard_normal((count, 3))
direction /= np.linalg.norm(direction, axis=1, keepdims=True)
direction[:, 2] = abs(direction[:, 2])
along = np.linspace(0, 1, points)[:, None]
turns = 6 * np.pi * along + random.uniform(0, 2 * np.pi, (count, 1, 1))
side = np.cross(direction, [0.3, 0.5, 0.8])[:, None]
curl = 0.35 * along * (np.cos(turns) * side + np.sin(turns) * np.cross(direction, side[:, 0])[:, None])
strands = tress.Strands(
    4 * direction[:, None] + 5 * along * direction[:, None] + curl - [0, 0, 2] * along**2,
    width=np.broadcast_to(0.012 - 0.008 * along[:, 0], (count, points)),
    color=np.clip([0.45, 0.2, 0.08] + 0.3 * direction * [0.4, 0.5, 0.2], 0.02, 0.9),
)

# %% A scene: what is not said is as in a scene file without the key
scene = tress.Scene(
    camera=tress.Camera(turn_deg=20, vertical_fov_deg=28),
    image=tress.Image(width=64 if small else 480, height=64 if small else 480, samples=1 if small else 48),
    environment=tress.Environment(studio=True, scale=0.4, group="fill"),
    lights=[
        tress.Light(
            rectangle={"center": [40, -50, 50], "look_at": [0, 0, 0], "width_cm": 30, "height_cm": 30, "radiance": [14, 13, 12]},
            group="key",
        )
    ],
    materials=[tress.Material(name="curls", color="file", roughness=0.25, variation={"width": 0.2})],
    grooms=[tress.Groom(name="curls", strands=strands, material="curls")],
)

# %% The picture, with its progress on the way
picture = tress.render(scene, progress=lambda done: print(f"{done.share:4.0%} noise {done.noise:.3f}", end="\r"))
picture.save("curls.exr")
print(picture, {key: picture.stats[key] for key in ("seconds", "noise", "stopped_by")})

# %% Layers are arrays: relit, without another render
relit = 0.2 * picture["light.fill"] + 1.5 * picture["light.key"]
print("mean of beauty and of the relit picture:", picture["beauty"][..., :3].mean(), relit.mean())
