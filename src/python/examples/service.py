"""The learning service with a target of one's own: the light that a ripple of water focuses, by the sun's height."""

# %% A target: the rays that leave a node, azimuth and weight
import os

import numpy as np
import tress

small = bool(os.environ.get("TRESS_EXAMPLE_SMALL"))


class Ripple(tress.Target):
    name = "ripple-1"

    def trace(self, slice, a, b):
        at = (np.arange(256) + 0.5) / 256 * 2 * np.pi
        slope = b * np.sin(at)
        return a + np.arcsin(np.sin(a + slope) / 1.33) - a / 1.33, np.full(256, 1 / 256)


# %% A grid of rows: two heights of the sun by five steepnesses of the ripple
service = tress.Service(Ripple(), epsilon=0.01)
water = service.add_slice(1, axis_a=[0.0, 0.6], axis_b=np.linspace(0.1, 0.9, 5), blur_rad=0.05)

# %% Passes: ask, and publish. Rows that have converged answer by their fit
random = np.random.default_rng(1)
for number in range(8):
    shape = (64 if small else 512, 2, 5)
    drawn = service.draw(water, np.arange(2)[:, None], np.arange(5), random.random(shape, np.float32))
    print(number, service.publish())

# %% What was learned
row = service.row(water, 1, 4)
print(row["state"], "by", len(row.get("components", [])), "components; error at most", row["objective"])
print("mean weight of a draw (the mass of a row):", float((drawn.value / drawn.q).mean()))
service.save("ripple.cache")
