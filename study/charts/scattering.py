# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina chart scattering`: do the two truths agree where media scatter, and do half spaces have their known answers?"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ...reference_py.atomic import require_writable
from ...reference_py.lobes.error_estimate import ErrorEstimator, ball_cosines
from ...reference_py.lobes.methods import make_lobe_set
from ...reference_py.lobes.truth import truth_of
from ...reference_py.material.stack import Stack
from ...reference_py.optics.frame import spherical
from ...reference_py.optics.scattering import albedo_of_color
from ...reference_py.optics.slab import half_space_albedo
from ...reference_py.registry import make_model
from ..half_space import albedo, f, spherical_albedo
from ..suite import scattering_suite
from ..tables import Report, write_table
from .output import print_table
from .suite_chart import write_agreement

ALBEDOS = (0.5, 0.9, 0.99, 1.0)
VIEWS_DEG = (0.0, 40.0, 65.0, 85.0)
_HEADING = ("lamina chart scattering", "adding against position_free: seed 1; relative errors; columns as in study/agreement.py")
_HALF_HEADING = ("lamina chart scattering", "isotropic half space without interface, adding against Chandrasekhar's H functions, views 0 40 65 85 degrees")
_COLUMNS = ("single_albedo", "albedo_0deg", "albedo_exact", "albedo_worst", "f_worst", "spherical", "spherical_exact", "albedo_of_color")
_BAKED_HEADING = ("lamina chart scattering", "bakes of two glossy lobes against adding, views of a ball's pixels; relative errors of the worst channel")
_BAKED = ("stack", "albedo_worst", "soft_light", "shape_median", "shape_worst")
# Of the layer that stands for a half space: at albedo 1 what passes it is the inverse of this.
_DEEP = 1e6
_WALKS = {"most_walks": 262_144, "f_walks": 6000}


def chart(folder: Path, report: Report) -> None:
    """Write half_space.csv, scattering_bakes.csv and scattering_agreement.csv and print them."""
    for name, heading, columns, rows in (
        ("half_space", _HALF_HEADING, _COLUMNS, half_space_rows()),
        ("scattering_bakes", _BAKED_HEADING, _BAKED, bake_rows(report)),
    ):
        table = folder / f"{name}.csv"
        require_writable(table)
        measured = list(rows)
        print_table(columns, measured)
        write_table(table, heading, columns, measured, report)
    write_agreement(folder / "scattering_agreement.csv", _HEADING, scattering_suite(), report, **_WALKS)


def half_space_rows() -> Iterator[list[str]]:
    """One row for each single-scattering albedo; `worst` are relative errors, `albedo_of_color` what the exact color is turned back to."""
    wo = spherical(np.radians(VIEWS_DEG), 0.0)
    for single in ALBEDOS:
        model = make_model("adding", half_space(single))
        found, exact = model.albedo(wo)[:, 0], albedo(single, wo[:, 2])
        views, lights = np.repeat(wo, len(wo), axis=0), np.tile(spherical(np.radians(VIEWS_DEG), 1.0), (len(wo), 1))
        off = np.abs(model.f(views, lights)[:, 0] / f(single, views[:, 2], lights[:, 2]) - 1.0)
        color = spherical_albedo(single)
        numbers = (found[0], exact[0], np.max(np.abs(found / exact - 1.0)), np.max(off), half_space_albedo(single, 0.0), color)
        yield [f"{single:g}", *(f"{v:.6f}" for v in numbers), f"{albedo_of_color((color,), 0.0)[0]:.6f}"]


def bake_rows(report: Report) -> Iterator[list[str]]:
    """Errors of a bake of two glossy lobes for each stack, as `study.charts.tiers` has them."""
    for name, stack in scattering_suite().items():
        report(f"bake of {name}")
        errors = ErrorEstimator(stack, truth_of(stack), ball_cosines()).errors(make_lobe_set(stack, "baked").lobe_set)
        yield [name, *(f"{v:.5f}" for v in (np.max(errors.albedo), np.mean(errors.soft_light), np.median(errors.shape), np.max(errors.shape)))]


def half_space(single: float, g: float = 0.0) -> Stack:
    """A layer that stands for a half space of a medium, without interface, over black."""
    medium = {"extinction": [1000.0] * 3, "scatter_albedo": [single] * 3, "scatter_g": g, "thickness": _DEEP / 1000.0}
    return Stack.from_dict({"layers": [{"kind": "dielectric", "ior": 1.0, **medium}], "base": {"kind": "lambert", "color": [0.0] * 3}})
