# SPDX-License-Identifier: GPL-3.0-or-later
"""`make mitsuba-slabs`: stacks with media that scatter, as explicit slabs in Mitsuba 3, against `adding`.

The slabs are those that `lamina export --to mitsuba --as layers` writes. Needs Mitsuba (pip install lamina[mitsuba]). Its facets are `single`, and so
is the truth here. A camera sees a wide slab in a uniform white sky, so that radiance is directional albedo.
"""

import sys
from pathlib import Path

import numpy as np

from ..reference_py.exchange.writers.mitsuba import slab_scene
from ..reference_py.material.stack import Stack
from ..reference_py.optics.error_measure import albedo_error, worst_share
from ..reference_py.optics.frame import spherical
from ..reference_py.registry import make_model
from .charts.output import print_table
from .suite import scattering_suite
from .tables import FIGURES, write_table

NAMES = ("rough_one_isotropic", "smooth_milk_over_black", "rough_very_forward", "two_media", "rough_rgb_extinction", "bare_dust_over_metal",
         "between_two_media", "smooth_back_over_rough_metal")  # fmt: skip
VIEWS_DEG = (0.0, 40.0, 65.0, 80.0)
_ROUNDS, _MOST_ROUNDS = 6, 40
# Relative standard error at which more renders are not worth it.
_TARGET = 0.0025


def mitsuba_albedo(mi, stack: Stack, theta_deg: float, samples: int, most_rounds: int = _MOST_ROUNDS) -> tuple[np.ndarray, np.ndarray]:
    """Directional albedo (3,) and its standard error, from renders of `samples` paths per pixel each."""
    scene = mi.load_string(slab_scene(stack), theta=str(theta_deg))
    means = []
    while True:
        means.append(np.array(mi.render(scene, spp=samples, seed=len(means))).reshape(-1, 3).mean(axis=0))
        mean, stderr = np.mean(means, axis=0), np.std(means, axis=0) / np.sqrt(max(len(means) - 1, 1))
        if len(means) >= _ROUNDS and (np.all(stderr < _TARGET * mean) or len(means) >= most_rounds):
            return mean, stderr


def main(samples: int = 16) -> None:
    """Print and write the table."""
    import mitsuba as mi

    mi.set_variant("scalar_rgb")
    columns, rows = ("stack", "view_deg", "adding", "mitsuba", "stderr", "worst_error"), []
    for name in NAMES:
        stack = scattering_suite()[name]
        for theta in VIEWS_DEG:
            exact = make_model("adding", stack, surface="single").albedo(spherical(np.radians(theta), 0.0))
            found, stderr = mitsuba_albedo(mi, stack, theta, samples)
            numbers = (" ".join(f"{v:.4f}" for v in values) for values in (exact, found))
            rows.append([name, f"{theta:g}", *numbers, f"{worst_share(stderr, exact):.4f}", f"{albedo_error(found, exact):.4f}"])
            print(rows[-1], file=sys.stderr, flush=True)
    print_table(columns, rows)
    heading = ("make mitsuba-slabs", f"Mitsuba {mi.__version__}, explicit slabs, single facets; relative errors of the worst channel")
    write_table(Path(FIGURES) / "mitsuba_slabs.csv", heading, columns, rows, lambda line: print(line, file=sys.stderr))


if __name__ == "__main__":
    main()
