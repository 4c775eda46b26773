# SPDX-License-Identifier: GPL-3.0-or-later
"""The whole functions of `osl/` for a shader's text: what a file includes comes before it, and its constants get their values here."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from ....reference_py.lobes.analytic import base, calibration, interface_tables
from ....reference_py.lobes.diffuse_ramp import RAMP_COSINES
from ....reference_py.lobes.live_grid import FLOOR
from ....reference_py.lobes.methods import paper
from ....reference_py.lobes.view_table import AZIMUTHS, KNOTS, MIN_COS_O
from ....reference_py.optics import interface, thin_film

PARTS = Path(__file__).resolve().parents[3] / "osl"
# Below this alpha a lobe takes Cycles' anisotropic path (osl/break_isotropy.h); above it the isotropic one is within 1e-4.
NEAR_SPECULAR_ALPHA = 0.06
# Blocks of a distribution's tables of energies in their order in a shader's array, and the constants that say where they start.
# The last is for stacks with anisotropy alone.
TABLE_BLOCKS = {"thin": "THIN", "dense": "DENSE", "diffuse": "DIFFUSE", "gain": "GAIN", "closure": "CLOSURE", "anisotropic": "ANISOTROPIC"}


def functions(names: Iterable[str]) -> str:
    """The text of these files and of all that they include, each once, callees first, and before them the constants they declare.

    Comments are left out: those are for who reads `osl/`, and texts are long as it is.
    """
    order: dict[str, None] = {}
    for name in names:
        _visit(name, order)
    declared = dict.fromkeys(constant for name in order for constant in _part(name).constants)
    return "".join([*(f"#define {name} {constants()[name]}\n" for name in declared), *(_part(name).text for name in order)])


def _visit(name: str, order: dict[str, None]) -> None:
    if name not in order:
        for included in _part(name).includes:
            _visit(included, order)
        order[name] = None


@dataclass(frozen=True)
class _Part:
    """A file: the files that it includes, the constants that it declares, and its functions without comments."""

    includes: tuple[str, ...]
    constants: tuple[str, ...]
    text: str


@cache
def _part(name: str) -> _Part:
    lines = (PARTS / name).read_text(encoding="utf-8").splitlines(keepends=True)
    includes = tuple([line.split('"')[1] for line in lines if line.startswith("#include")])
    declared = tuple([line.split()[1] for line in lines if line.startswith("#define")])
    return _Part(includes, declared, "".join([line for line in lines if line.strip() and not line.lstrip().startswith(("#", "//"))]))


@cache
def constants() -> dict[str, str]:
    """Every constant that a file of `osl/` may declare, as the preprocessor's text."""
    values: dict[str, float] = {
        "MIN_COS_O": MIN_COS_O, "KNOTS": KNOTS, "FLOOR": FLOOR, "RAMP": len(RAMP_COSINES), "NEAR_SPECULAR_ALPHA": NEAR_SPECULAR_ALPHA,
        "TINT_FLOOR": interface.TINT_FLOOR, "NODE_COUNT": paper.NODE_COUNT,
        "FILM_STEPS": thin_film.STEPS, "FILM_LAST_PHASE": thin_film.LAST_PHASE_NM, "FILM_TERMS": thin_film.TERMS,
        "FILM_THINNEST": thin_film.THINNEST_NM,
        "MOST_RHO": interface_tables.MOST_RHO, "RHO_CELLS": interface_tables.RHO_CELLS, "ALPHA_CELLS": interface_tables.ALPHA_CELLS, "UNIT": interface_tables.UNIT,
        "T_KNOTS": len(interface_tables.T), "V_KNOTS": len(interface_tables.V), "CLOSURE_CELLS": interface_tables.CLOSURE_CELLS,
        "LEAST_RATIO": interface_tables.LEAST_RATIO, "LEAST_KAPPA": interface_tables.LEAST_KAPPA, "ANISOTROPIC_ALPHAS": interface_tables.ANISOTROPIC_ALPHAS,
        "ANISOTROPIC_RATIOS": interface_tables.ANISOTROPIC_RATIOS, "ANISOTROPIC_COSINES": interface_tables.ANISOTROPIC_COSINES,
        **dict(zip(TABLE_BLOCKS.values(), table_starts())),
        **{f"AZIMUTH_{i}": float(place) for i, place in enumerate(AZIMUTHS)},
    }  # fmt: skip
    rows = {"ANISOTROPIC_KNOTS": np.cos(2.0 * interface_tables.ANISOTROPIC_AZIMUTHS), "MEAN_COSINE": base.MEAN_COSINES, "MEAN_WEIGHT": base.MEAN_WEIGHTS}
    for name, value in (*vars(calibration).items(), *rows.items()):
        if name.isupper():
            values |= {f"{name}_{i}": v for i, v in enumerate(value)} if isinstance(value, tuple | np.ndarray) else {name: value}
    return {name: str(value) if isinstance(value, int) else _literal(value) for name, value in values.items()}


def _literal(value: float) -> str:
    text = f"{value:.9g}"
    return text if "." in text or "e" in text else f"{text}.0"


@cache
def table_starts() -> tuple[int, ...]:
    """Where each block starts within the tables of a distribution, then where they end."""
    sizes = interface_tables.tables()["ggx"]
    return (0, *np.cumsum([sizes[block].size for block in TABLE_BLOCKS]).tolist())
