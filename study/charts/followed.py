# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina chart followed`: where one, two or three textured values of a surface keep a bake, and how far off is what surfaces with films and anisotropy get."""

from collections import Counter
from itertools import combinations
from pathlib import Path

import numpy as np

from ...reference_py.atomic import require_writable
from ...reference_py.errors import LaminaError
from ...reference_py.lobes.bare_base import is_bare_brushed
from ...reference_py.lobes.cache import ALWAYS_LIVE
from ...reference_py.lobes.closure import lobe_energy
from ...reference_py.lobes.methods import make_lobe_set, require_bake_follows
from ...reference_py.lobes.methods.baking import METHOD
from ...reference_py.lobes.methods.not_bakeable import has_film, not_bakeable
from ...reference_py.material import presets
from ...reference_py.material.coverage import patches
from ...reference_py.material.place import Place, places
from ...reference_py.material.schema import CHOICE, SCHEMA
from ...reference_py.material.stack import Stack
from ...reference_py.models.position_free import PositionFree
from ...reference_py.optics.error_measure import worst_share
from ...reference_py.optics.frame import spherical
from ..stress import CASES
from ..suite import suite
from ..tables import Report, write_table
from .output import print_table

MOST_LIVE, MOST_LAYERS = 3, 8
BAKED, ANALYTIC, PAPER, REFUSED = "baked", "analytic", "weidlich_wilkie", "refused"
_COLUMNS = ("surfaces", "live_values", "cases", BAKED, ANALYTIC, PAPER, REFUSED, "one_value_of")
_HEADING = (
    "lamina chart followed",
    f"what a surface has with so many textured values, in the quality baked; surfaces of coverage apart, of at most {MOST_LAYERS} layers; one_value_of: what is not baked alone",
)
VIEWS_DEG, AZIMUTHS_DEG, _WALKS = (5.0, 45.0, 70.0), (0.0, 30.0, 60.0, 90.0), 1 << 15
_COAT = {"kind": "dielectric", "ior": 1.5, "roughness": 0.3}
_BRUSHED, _FILM = {"anisotropy": 0.7, "rotation": 0.1}, {"film_thickness": 400.0, "film_ior": 1.9}
_GREY, _METAL = {"kind": "lambert", "color": [0.7, 0.45, 0.25]}, {"kind": "conductor", "metal": "copper", "roughness": 0.4}
_GLASS = {"kind": "dielectric", "ior": 1.5}
_STAINED = _GLASS | {"tint": [0.9, 0.5, 0.3]}
STANDS_IN = {
    "film on bare metal": ([], _METAL | _FILM),
    "brushed metal": ([], _METAL | _BRUSHED),
    "film on a smooth coat over paint": ([_GLASS | _FILM], _GREY),
    "film on a rough coat over paint": ([_COAT | _FILM], _GREY),
    "film on a smooth coat over metal": ([_GLASS | _FILM], _METAL),
    "film on a rough coat over metal": ([_COAT | _FILM], _METAL),
    "film of textured thickness on a rough coat over paint": ([_COAT | _FILM], _GREY, Place(0, "film_thickness")),
    "film of textured thickness on a smooth coat over metal": ([_GLASS | _FILM], _METAL, Place(0, "film_thickness")),
    "film of textured index on a rough coat over paint": ([_COAT | _FILM], _GREY, Place(0, "film_ior")),
    "film of textured thickness on a coat of textured roughness over metal": ([_COAT | _FILM], _METAL, Place(0, "film_thickness"), Place(0, "roughness")),
    "film of textured thickness and index on a rough coat over paint": ([_COAT | _FILM], _GREY, Place(0, "film_thickness"), Place(0, "film_ior")),
    "film of textured thickness on a coat of textured roughness and tint over metal": (
        [_COAT | _FILM],
        _METAL,
        Place(0, "film_thickness"),
        Place(0, "roughness"),
        Place(0, "tint"),
    ),
    "brushed coat over paint": ([_COAT | _BRUSHED], _GREY),
    "brushed coat over metal": ([_COAT | _BRUSHED], _METAL),
    "smooth coat over brushed metal": ([_GLASS], _METAL | _BRUSHED),
    "rough coat over brushed metal": ([_COAT], _METAL | _BRUSHED),
    "brushed coat of textured roughness over metal": ([_COAT | _BRUSHED], _METAL, Place(0, "roughness")),
    "smooth coat over brushed metal of textured roughness": ([_GLASS], _METAL | _BRUSHED, Place(None, "roughness")),
    "brushed coat over paint of textured color": ([_COAT | _BRUSHED], _GREY, Place(None, "color")),
    "rough coat of textured tint over brushed metal": ([_COAT], _METAL | _BRUSHED, Place(0, "tint")),
    "smooth coat of textured thickness over brushed metal of textured roughness": (
        [_STAINED],
        _METAL | _BRUSHED,
        Place(0, "thickness"),
        Place(None, "roughness"),
    ),
    "smooth coat over brushed metal of textured anisotropy": ([_GLASS], _METAL | _BRUSHED, Place(None, "anisotropy")),
    "coat and metal brushed in two directions": ([_COAT | _BRUSHED], _METAL | _BRUSHED | {"rotation": 0.35}),
}
_STANDS_IN_COLUMNS = ("stack", "stands_in", "albedo_worst", "beyond_4_stderr")
_STANDS_IN_HEADING = ("lamina chart followed", f"albedo against position_free at {VIEWS_DEG} degrees and azimuths {AZIMUTHS_DEG}; {_WALKS} walks each")


def chart(folder: Path, report: Report) -> None:
    """Write followed.csv and stands_in.csv."""
    tables = folder / "followed.csv", folder / "stands_in.csv"
    for table in tables:
        require_writable(table)
    groups = {"presets": [presets.load(name) for name in presets.names()], "suite": list(suite().values()), "stress": [case.stack for case in CASES.values()]}
    rows = [row for name, stacks in groups.items() for row in _rows(name, stacks)]
    write_table(tables[0], _HEADING, _COLUMNS, rows, report)
    print_table(_COLUMNS, rows)
    errors = [[name, *_error(Stack.from_dict({"layers": layers, "base": base}), tuple(live))] for name, (layers, base, *live) in STANDS_IN.items()]
    write_table(tables[1], _STANDS_IN_HEADING, _STANDS_IN_COLUMNS, errors, report)
    print_table(_STANDS_IN_COLUMNS, errors)


def chosen(stack: Stack, live: tuple[Place, ...]) -> str:
    """What the surface of one patch has in the quality `baked` over these live values."""
    if is_bare_brushed(stack) and not live and not not_bakeable(stack):
        return ANALYTIC
    if not_bakeable(stack):
        return PAPER if has_film(stack) else ANALYTIC
    try:
        require_bake_follows(stack, live)
    except LaminaError:
        return REFUSED
    return BAKED if METHOD.follows(stack, live) else PAPER if has_film(stack) else ANALYTIC


def textured(stack: Stack) -> list[Place]:
    """The values of a surface that a texture can give."""
    found = []
    for where, element in places(stack):
        kind = (SCHEMA.bases if where is None else SCHEMA.layers)[element.kind]
        found += [Place(where, p.name) for p in kind.all_parameters if p.type != CHOICE and p.name in element.values and p.name not in ALWAYS_LIVE]
    return found


def _rows(name: str, stacks: list[Stack]) -> list[list[str]]:
    surfaces = [patch.stack for stack in stacks for patch in patches(stack) if len(patch.layers) <= MOST_LAYERS]
    rows = []
    for count in range(MOST_LIVE + 1):
        found = [(live, chosen(stack, live)) for stack in surfaces for live in combinations(textured(stack), count)]
        counts = Counter(what for _, what in found)
        alone = sorted({live[0].name for live, what in found if what != BAKED}) if count == 1 else []
        rows.append([name, str(count), str(len(found)), *(str(counts[what]) for what in (BAKED, ANALYTIC, PAPER, REFUSED)), " ".join(alone)])
    return rows


def _error(stack: Stack, live: tuple[Place, ...]) -> tuple[str, ...]:
    """What it gets where these values are textured, its worst error of albedo, and what of that is beyond four standard errors."""
    made, cosines = make_lobe_set(stack, "baked", live=live).lobe_set, np.cos(np.radians(VIEWS_DEG))
    phi = np.radians(AZIMUTHS_DEG)
    truth, stderr = PositionFree(stack, walks=_WALKS).albedo_stderr(spherical(np.radians(VIEWS_DEG)[:, None], phi))
    albedo = np.stack([sum(lobe_energy(lobe, cosines, a) for lobe in made.lobes(cosines, a)) for a in phi], axis=1)
    off = np.abs(albedo - truth)
    return made.name, *(f"{np.max(worst_share(gap, truth)):.4f}" for gap in (off, np.maximum(off - 4.0 * stderr, 0.0)))
