# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina chart live_values`: bakes that follow live values, at nine combinations of them, beside bakes of each combination alone."""

import time
from pathlib import Path

import numpy as np

from ...reference_py.atomic import require_writable
from ...reference_py.lobes.baked import baked
from ...reference_py.lobes.error_estimate import ErrorEstimator
from ...reference_py.lobes.live_grid import LiveLobes
from ...reference_py.lobes.methods import make_lobe_set
from ...reference_py.lobes.truth import truth_of
from ...reference_py.material.place import Place, in_words
from ...reference_py.material.stack import Stack
from ..tables import Report, write_table
from .tiers import THETA_DEG

_VARNISH = {"kind": "dielectric", "roughness": 0.35, "tint": [0.9, 0.7, 0.4], "thickness": 0.7}
_GLAZE = {"kind": "dielectric", "tint": [0.6, 0.7, 0.9]}
_WOOD = {"kind": "lambert", "color": [0.7, 0.45, 0.25]}
_CLAY = {"kind": "oren_nayar", "color": [0.7, 0.45, 0.25], "sigma_deg": 30.0}
_METAL = {"kind": "conductor", "reflectance": [0.9, 0.6, 0.3], "edge_color": [0.9, 0.8, 0.7], "roughness": 0.4}
_MILK = {"kind": "dielectric", "roughness": 0.55, "scatter_color": [0.8, 0.6, 0.3], "density": 1.0, "scatter_g": 0.4}
STACKS = {
    "varnish over paint": ([_VARNISH], _WOOD),
    "varnish over metal": ([_VARNISH], _METAL),
    "glaze over metal": ([_GLAZE], _METAL),
    "glaze over clay": ([_GLAZE], _CLAY),
    "varnish over clay": ([_VARNISH], _CLAY),
    "metal": ([], _METAL),
    "milk over metal": ([_MILK], _METAL),
    "milk over paint": ([_MILK], _WOOD),
    "varnish over glaze over metal": ([_VARNISH, _GLAZE], _METAL),
    "varnish over frosted glaze over metal": ([_VARNISH, _GLAZE | {"roughness": 0.3}], _METAL),
    "filmed glaze over paint": ([_GLAZE | {"film_thickness": 300.0, "film_ior": 1.9}], _WOOD),
    "filmed varnish over metal": ([_VARNISH | {"film_thickness": 300.0, "film_ior": 1.9}], _METAL),
}
_COLOR = Place(None, "color")
CASES = (
    ("varnish over paint", (Place(0, "tint"),)),
    ("varnish over paint", (Place(0, "tint"), Place(0, "thickness"))),
    ("varnish over metal", (Place(0, "tint"), Place(0, "thickness"))),
    ("glaze over metal", (Place(0, "tint"),)),
    ("varnish over paint", (Place(0, "roughness"),)),
    ("varnish over metal", (Place(None, "roughness"),)),
    ("varnish over paint", (Place(0, "roughness"), Place(0, "thickness"), _COLOR)),
    ("varnish over paint", (Place(0, "roughness"), Place(0, "tint"), Place(0, "thickness"), _COLOR)),
    ("metal", (Place(None, "reflectance"),)),
    ("metal", (Place(None, "roughness"),)),
    ("metal", (Place(None, "roughness"), Place(None, "reflectance"))),
    ("varnish over metal", (Place(None, "reflectance"),)),
    ("varnish over metal", (Place(None, "edge_color"),)),
    ("varnish over metal", (Place(None, "reflectance"), Place(None, "edge_color"))),
    ("glaze over clay", (Place(None, "sigma_deg"),)),
    ("varnish over clay", (_COLOR,)),
    ("varnish over clay", (Place(None, "sigma_deg"), _COLOR)),
    ("varnish over paint", (Place(0, "ior"),)),
    ("glaze over metal", (Place(0, "ior"),)),
    ("varnish over glaze over metal", (Place(1, "ior"),)),
    ("filmed glaze over paint", (Place(0, "film_thickness"), _COLOR)),
    ("filmed varnish over metal", (Place(0, "film_thickness"), Place(0, "roughness"))),
    ("milk over metal", (Place(0, "density"),)),
    ("milk over metal", (Place(0, "scatter_color"),)),
    ("milk over paint", (Place(0, "density"), Place(0, "scatter_color"))),
    ("varnish over paint", (Place(0, "roughness"), Place(0, "tint"), Place(0, "ior"), _COLOR)),
    ("varnish over glaze over metal", (Place(0, "roughness"), Place(1, "thickness"), Place(None, "reflectance"))),
    ("varnish over metal", (Place(None, "roughness"), Place(None, "reflectance"), Place(0, "thickness"))),
    ("varnish over metal", (Place(0, "roughness"), Place(None, "roughness"), Place(0, "thickness"))),
    ("varnish over frosted glaze over metal", (Place(0, "roughness"), Place(1, "roughness"), Place(None, "roughness"))),
)
VALUES, _SEED, _GLOSSY = 9, 17, 2
# What values are drawn from; colors from .03 to .97.
_RANGES = {
    "roughness": (0.05, 0.9),
    "thickness": (0.05, 3.0),
    "ior": (1.2, 2.2),
    "sigma_deg": (0.0, 60.0),
    "density": (0.05, 12.0),
    "film_thickness": (0.0, 840.0),
}
COLUMNS = (
    "stack",
    "live",
    "axes",
    "cpu_s",
    "albedo_worst",
    "albedo_median",
    "shape_worst",
    "shape_median",
    "own_albedo_worst",
    "own_shape_worst",
    "own_shape_median",
)
_HEADING = (
    "lamina chart live_values",
    f"against adding at {', '.join(f'{t:g}' for t in THETA_DEG)} degrees, {VALUES} combinations of seed {_SEED}",
    "own: bakes of each combination alone; axes: of its grid; cpu_s: of making the bake that follows",
    "albedo: relative, worst view and channel; shape: cosine-weighted L1 over albedo, worst channel",
)


def chart(folder: Path, report: Report) -> None:
    """Write live_values.csv."""
    table = folder / "live_values.csv"
    require_writable(table)
    rows = []
    for i, (name, live) in enumerate(CASES):
        report(f"{100 * i // len(CASES):3} % {name}: {in_words(live)}")
        layers, base = STACKS[name]
        rows.append([name, " and ".join(map(str, live)), *_row(Stack.from_dict({"layers": layers, "base": base}), live)])
    write_table(table, _HEADING, COLUMNS, rows, report)


def _row(stack: Stack, live: tuple[Place, ...]) -> list[str]:
    began = time.process_time()
    followed = baked(stack, live, _GLOSSY, None)
    seconds = time.process_time() - began
    rng, found = np.random.default_rng(_SEED), []
    for _ in range(VALUES):
        here = stack
        for place in live:
            here = place.with_value(here, float(rng.uniform(*_RANGES[place.name])) if place.name in _RANGES else tuple(rng.uniform(0.03, 0.97, 3)))
        estimator = ErrorEstimator(here, truth_of(here), np.cos(np.radians(THETA_DEG)))
        errors, own = (estimator.errors(lobes) for lobes in (followed.with_values_of(here), make_lobe_set(here, "baked").lobe_set))
        found.append([f(e) for e in (errors, own) for f in (lambda e: np.max(e.albedo), lambda e: np.max(e.shape), lambda e: np.median(e.shape))])
    albedo, shape, middle, own_albedo, own_shape, own_middle = np.array(found).T
    axes = len(followed.axes) if isinstance(followed, LiveLobes) else 0
    cells = (np.max(albedo), np.median(albedo), np.max(shape), np.median(middle), np.max(own_albedo), np.max(own_shape), np.median(own_middle))
    return [str(axes), f"{seconds:.1f}", *(f"{value:.5f}" for value in cells)]
