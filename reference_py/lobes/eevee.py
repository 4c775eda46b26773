# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of lobes for EEVEE, which gives the same nodes other energies than Cycles: each lobe gets the weight with which EEVEE has its energy.

EEVEE's Glossy node is isotropic GGX of alpha sqrt(alpha_x alpha_y), its color times the albedo that a table over view and roughness holds: Smith's
masking of the view times that of the light (`brdf_lut`, `F_brdf_single_scatter` in Blender's eevee shaders), where Cycles has the height-correlated
one. A Metallic node gets a metal's color at the edge, so dielectric curves are folded; a Diffuse node has no roughness.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from ..optics.diffuse import oren_nayar_albedo
from .axes import Scale
from .closure import unit_energy
from .live_grid import MIN_ALPHA
from .live_tables import LiveTable, LiveTables
from .lobe import GlossyLobe
from .patch_lobes import PatchLobes
from .tabulate import tabulate
from .view_table import AZIMUTHS, KNOTS, BaseColorTable, DiffuseTable, GlossyTable, OrenNayarTable, RoughBase, TableLobes, knot_cosines

# Points along each side of the unit square that an albedo is the mean over.
_POINTS = 32
_LEAST = 1e-3
# Of Cycles' energies here: median of the worst view's error 7e-4, at most 1.4 % where a lobe is tilted at the horizon.
_RULE = (56, 16)
# Of what is interpolated over live values, from one root of alpha or cosine to the next.
_CELLS = 24
_SCALE = Scale(0.0, 1.0, _CELLS + 1)


def eevee_tables(lobe_set, tables: TableLobes | LiveTables | PatchLobes) -> TableLobes | LiveTables | PatchLobes:
    """Tables of a lobe set whose energies are right in EEVEE. `tables` are those that `tabulate` made of it for Cycles."""
    if isinstance(lobe_set, PatchLobes):
        parts = zip(lobe_set.parts, tables.parts)
        return PatchLobes(tables.stack, tuple((patch, eevee_tables(part.lobe_set, known)) for (patch, part), (_, known) in parts))
    # live ones of Cycles may keep a dielectric's curve, which cannot be folded any more
    folded = tabulate(lobe_set if isinstance(tables, LiveTables) else tables)
    if isinstance(folded, LiveTables):
        return replace(folded, tables=tuple(map(_live_table, folded.tables)))
    return TableLobes(tuple(map(_table, folded.tables)))


def eevee_albedo(alpha: np.ndarray, cos_theta_o: np.ndarray) -> np.ndarray:
    """Albedo (...) of a white Glossy node in EEVEE for alpha and view cosines (...): the mean of the light's masking over visible normals.

    These are sampled by spherical caps (Dupuy and Benyoub 2023, "Sampling visible GGX normals with spherical caps").
    """
    alpha, z = (np.asarray(v, float)[..., None] for v in np.broadcast_arrays(alpha, np.clip(cos_theta_o, 1e-4, 1.0)))
    even = (np.arange(_POINTS) + 0.5) / _POINTS
    u1, u2 = (u.ravel() for u in np.meshgrid(even[: _POINTS // 2], even))  # the other half of a ring mirrors these
    x = np.sqrt(1.0 - z * z)
    length = np.hypot(alpha * x, z)
    hx, hz = alpha * x / length, z / length
    cap = (1.0 - u2) * (1.0 + hz) - hz
    ring = np.sqrt(np.maximum(1.0 - cap * cap, 0.0))
    wh = np.stack([alpha * (ring * np.cos(2.0 * np.pi * u1) + hx), alpha * ring * np.sin(2.0 * np.pi * u1) + 0.0 * hx, np.maximum(cap + hz, 0.0)])
    wh = wh / np.linalg.norm(wh, axis=0)
    cos_i = 2.0 * (x * wh[0] + z * wh[2]) * wh[2] - z
    masking = 2.0 / (1.0 + np.sqrt(1.0 + alpha * alpha * (1.0 / np.square(np.maximum(cos_i, 1e-9)) - 1.0)))
    return np.mean(np.where(cos_i > 0.0, masking, 0.0), axis=-1)


@lru_cache(maxsize=1)
def _albedos() -> np.ndarray:
    """`eevee_albedo` at even roots of alpha and of cosines (_CELLS + 1, _CELLS + 1)."""
    roots = np.linspace(0.0, 1.0, _CELLS + 1)
    return eevee_albedo(np.maximum(roots, 1e-3)[:, None] ** 2, roots[None] ** 2)


def _albedo_between(root: np.ndarray, cos_theta_o: np.ndarray) -> np.ndarray:
    """`eevee_albedo` (...) for the root of alpha (...), linear between those of `_albedos`."""
    (i, s), (j, t) = (_SCALE.place(v) for v in (root, np.sqrt(cos_theta_o)))
    table = _albedos()
    return (table[i, j] * (1.0 - t) + table[i, j + 1] * t) * (1.0 - s) + (table[i + 1, j] * (1.0 - t) + table[i + 1, j + 1] * t) * s


@lru_cache(maxsize=2)
def _units(distribution: str) -> np.ndarray:
    """Energies (_CELLS + 1, KNOTS, 1) of isotropic lobes of weight 1 at even roots of alpha."""
    alphas = np.maximum(_SCALE.knots, MIN_ALPHA**0.5) ** 2 * np.ones((KNOTS, 1))
    return np.stack([unit_energy(GlossyLobe(distribution, np.ones(3), alpha, alpha), knot_cosines())[:, :1] for alpha in alphas.T])


def _live_table(table: LiveTable) -> LiveTable:
    if table.shape is None or not np.any(table.shape):
        return table
    root_x, root_y, slope = np.moveaxis(table.shape, -1, 0)
    root, energy = np.sqrt(root_x * root_y), table.energy
    if table.unit is None:  # a share of such a lobe
        i, t = _SCALE.place(root)
        units, views = _units(table.distribution), np.arange(KNOTS)
        energy = energy * (units[i, views] * (1.0 - t)[..., None] + units[i + 1, views] * t[..., None])
    unit = np.maximum(_albedo_between(root, _tilted(slope)), _LEAST)[..., None]
    return replace(table, distribution="ggx", energy=energy, shape=np.stack([root, root, slope], axis=-1), unit=unit)


def _tilted(slope: np.ndarray) -> np.ndarray:
    """Cosines (..., KNOTS) of the view from a node's normal, which is the surface's and `slope` (..., KNOTS) along the plane of incidence.

    Where a lobe has next to nothing its slope is its neighbours', by which a grazing view may be behind it.
    """
    cosines = knot_cosines()
    sines = np.sqrt(1.0 - np.square(cosines))
    return np.maximum(cosines + slope * np.square(sines), 0.0) / np.hypot(1.0, slope * sines)


def _table(table):
    if isinstance(table, OrenNayarTable):
        return DiffuseTable(oren_nayar_albedo(knot_cosines(), table.weight, table.sigma_deg, table.power), table.axis, table.normal)
    if isinstance(table, RoughBase):
        return replace(table, is_lambert=True)
    if isinstance(table, BaseColorTable) and table.distribution is not None:
        white = _table(GlossyTable(table.distribution, np.ones((KNOTS, 3)), table.shape))
        return replace(table, own=table.own * white.weight, through=table.through * white.weight, distribution=white.distribution, shape=white.shape)
    if not isinstance(table, GlossyTable):
        return table
    cosines = knot_cosines()
    alpha_x, alpha_y, slope = table.shape.T
    alpha = np.sqrt(alpha_x * alpha_y)
    sines = np.sqrt(1.0 - np.square(cosines))
    lobe = GlossyLobe(table.distribution, np.ones(3), alpha_x, alpha_y, np.arctan(slope * sines), None, table.frame)
    if table.axis is None and table.frame is None:
        energy = unit_energy(lobe, cosines, rule=_RULE)
        axis = None
    else:
        axis = table.axis if table.axis is not None else table.frame
        energy = np.stack([unit_energy(lobe, cosines, axis + phi, _RULE) for phi in np.arccos(AZIMUTHS)])
    weight = table.weight * energy / np.maximum(eevee_albedo(alpha, _tilted(slope)), _LEAST)[:, None]
    return replace(table, distribution="ggx", weight=weight, shape=np.stack([alpha, alpha, slope], axis=-1), frame=None, axis=axis)
