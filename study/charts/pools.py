# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina chart pools`: what the albedo of many masks loses where patches share closures, at masks of 0, .5 and 1."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np

from ...addon.session import blender
from ...reference_py.atomic import require_writable
from ...reference_py.lobes.closure import lobe_energy
from ...reference_py.lobes.methods import make_lobe_set
from ...reference_py.lobes.patch_lobes import PatchLobes
from ...reference_py.material.coverage import patches
from ...reference_py.material.stack import Stack
from ...reference_py.optics.error_measure import albedo_error
from ..tables import Report, write_table
from .output import print_table

VIEWS_DEG = (5.0, 30.0, 55.0, 75.0)
MASKS = (0.0, 0.5, 1.0)
MOST_CASES, SEED = 81, 1
_HEADING = (
    "lamina chart pools",
    f"albedo of the closures over that of the patches; masks of 0, .5 and 1, of more than {MOST_CASES} cases all at .5 and others at random; views 5 30 55 75 degrees",
)
_COLUMNS = ("masks", "shown_by", "cases", "most_closures", "mean", "share_99", "worst")
_METALS = zip(("gold", "copper", "iron", "silver") * 2, (0.05, 0.9, 0.3, 0.6, 0.13, 0.98, 0.38, 0.68))
_PAINTS = [{"kind": "oren_nayar", "color": [0.1 * i + 0.05, 0.9 - 0.1 * i, 0.3], "sigma_deg": 5.0 * i + 5.0} for i in range(8)]
_COATS = [{"kind": "dielectric", "ior": ior, "roughness": roughness} for ior, roughness in ((1.5, 0.3), (1.8, 0.6), (1.3, 0.5))]
SETS = {
    "8 metals": [{"kind": "conductor", "metal": metal, "roughness": roughness} for metal, roughness in _METALS],
    "8 paints": _PAINTS,
    "3 coats over 2 paints": [*_COATS, _PAINTS[1], _PAINTS[5]],
    "3 coats over 5 paints": [*_COATS, *_PAINTS[:5]],
}
_BASE = {"kind": "conductor", "metal": "iron", "roughness": 0.1}


def chart(folder: Path, report: Report) -> None:
    """Write pools.csv and print it."""
    table = folder / "pools.csv"
    require_writable(table)
    with blender(report):
        rows = list(pool_rows(report))
    print_table(_COLUMNS, rows)
    write_table(table, _HEADING, _COLUMNS, rows, report)


def pool_rows(report: Report) -> Iterator[list[str]]:
    """One row for each set of masks and each branch of a material."""
    from ...addon.shader.nodes.stock_nodes import stock_tables

    for name, layers in SETS.items():
        made = make_lobe_set(stack_at(layers, [0.5] * len(layers)), "auto")
        for shown_by, lobe_set in (("OSL script", made.lobe_set), ("stock nodes", stock_tables(made))):
            errors, closures = pool_errors(lobe_set, layers)
            report(f"{name}, {shown_by}: worst {100.0 * errors.max():.2f} %")
            numbers = (np.mean(errors), np.quantile(errors, 0.99), errors.max())
            yield [name, shown_by, str(len(errors)), str(closures), *(f"{value:.5f}" for value in numbers)]


def stack_at(layers: Sequence[dict], masks: Sequence[float]) -> Stack:
    """The layers with these coverages."""
    return Stack.from_dict({"layers": [{**layer, "coverage": mask} for layer, mask in zip(layers, masks)], "base": _BASE})


def pool_errors(lobe_set: PatchLobes, layers: Sequence[dict]) -> tuple[np.ndarray, int]:
    """Relative errors (cases,) of the albedo, the worst view and channel, and the most closures of a case."""
    cases = np.array(list(product(MASKS, repeat=len(layers))))
    if len(cases) > MOST_CASES:  # that of all patches at once is always among them
        cases = np.concatenate([np.full((1, len(layers)), 0.5), np.random.default_rng(SEED).permutation(cases)[: MOST_CASES - 1]])
    energies = [_albedo(part) for _, part in lobe_set.parts]
    errors, closures = [], 0
    for masks in cases:
        parts = tuple((patch, part) for patch, (_, part) in zip(patches(stack_at(layers, masks.tolist())), lobe_set.parts, strict=True))
        shown = replace(lobe_set, parts=parts)
        expected = sum(patch.share * energy for (patch, _), energy in zip(parts, energies))
        errors.append(np.max(albedo_error(_albedo(shown), expected)))
        closures = max(closures, shown.lobe_count)
    return np.array(errors), closures


def _albedo(lobe_set) -> np.ndarray:
    """(views, 3), view by view, as the color of a rough diffuse table changes with it."""
    views = np.cos(np.radians(VIEWS_DEG))[:, None]
    return np.concatenate([np.broadcast_to(sum(lobe_energy(lobe, view) for lobe in lobe_set.lobes(view)), (1, 3)) for view in views])
