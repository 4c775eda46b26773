# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of lobes for EEVEE, which gives the same nodes other energies than Cycles: each lobe gets the weight with which EEVEE has its energy.

EEVEE's Glossy node is isotropic GGX of alpha sqrt(alpha_x alpha_y), its color times the albedo that a table over view and roughness holds: Smith's
masking of the view times that of the light (`brdf_lut`, `F_brdf_single_scatter` in Blender's eevee shaders), where Cycles has the height-correlated
one. A Metallic node gets a metal's color at the edge, so dielectric curves are folded; a Diffuse node has no roughness.
"""

from dataclasses import replace

import numpy as np

from ..optics.diffuse import oren_nayar_albedo
from .closure import unit_energy
from .lobe import GlossyLobe
from .patch_lobes import PatchLobes
from .tabulate import tabulate
from .view_table import AZIMUTHS, DiffuseTable, GlossyTable, OrenNayarTable, TableLobes, knot_cosines

# Points along each side of the unit square that an albedo is the mean over.
_POINTS = 32
_LEAST = 1e-3
# Of Cycles' energies here: median error 5e-4, at most 1.4 % where a lobe is tilted at the horizon, in a third of the time that ENERGY_RULE takes.
_RULE = (64, 24)


def eevee_tables(lobe_set) -> TableLobes | PatchLobes:
    """A lobe set in tables, as `tabulate` makes them, whose energies are right in EEVEE."""
    tables = tabulate(lobe_set)
    if isinstance(tables, PatchLobes):
        return PatchLobes(tables.stack, tuple((patch, TableLobes(tuple(map(_table, part.tables)))) for patch, part in tables.parts))
    return TableLobes(tuple(map(_table, tables.tables)))


def eevee_albedo(alpha: np.ndarray, cos_theta_o: np.ndarray) -> np.ndarray:
    """Albedo (...) of a white Glossy node in EEVEE for alpha and view cosines (...): the mean of the light's masking over visible normals.

    These are sampled by spherical caps (Dupuy and Benyoub 2023, "Sampling visible GGX normals with spherical caps").
    """
    alpha, z = (np.asarray(v, float)[..., None] for v in np.broadcast_arrays(alpha, np.clip(cos_theta_o, 1e-4, 1.0)))
    u1, u2 = (u.ravel() for u in np.meshgrid(*2 * [(np.arange(_POINTS) + 0.5) / _POINTS]))
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


def _table(table):
    if isinstance(table, OrenNayarTable):
        return DiffuseTable(oren_nayar_albedo(knot_cosines(), table.weight, table.sigma_deg, table.power), table.axis)
    if not isinstance(table, GlossyTable):
        return table
    cosines = knot_cosines()
    alpha_x, alpha_y, slope = table.shape.T
    alpha = np.sqrt(alpha_x * alpha_y)
    # the node's normal is the surface's and `slope` along the plane of incidence
    sines = np.sqrt(1.0 - np.square(cosines))
    tilted = (cosines + slope * np.square(sines)) / np.hypot(1.0, slope * sines)
    lobe = GlossyLobe(table.distribution, np.ones(3), alpha_x, alpha_y, np.arctan(slope * sines), None, table.frame)
    if table.axis is None and table.frame is None:
        energy = unit_energy(lobe, cosines, rule=_RULE)
        axis = None
    else:
        axis = table.axis if table.axis is not None else table.frame
        energy = np.stack([unit_energy(lobe, cosines, axis + phi, _RULE) for phi in np.arccos(AZIMUTHS)])
    weight = table.weight * energy / np.maximum(eevee_albedo(alpha, tilted), _LEAST)[:, None]
    return replace(table, distribution="ggx", weight=weight, shape=np.stack([alpha, alpha, slope], axis=-1), frame=None, axis=axis)
