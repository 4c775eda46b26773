# SPDX-License-Identifier: GPL-3.0-or-later
"""Any lobe set as tables of lobes that stock nodes have: its lobes sampled at the knots, Fresnel curves folded.

A lobe with a Fresnel curve becomes a plain one whose weight keeps the lobe's energy at every knot. What is lost is
how the curve changes within the lobe, and for a rough interface that is a lot: of all reflected light 23 % at 60 and
36 % at 80 degrees go elsewhere for frosted metal (L1, alpha .24). So Blenders that can, keep a dielectric's curve,
but for lobes of about a degree, within which nobody sees it: EEVEE takes it for a metal's, .046 for .152 at the edge
of a ball.
A bare Oren-Nayar base stays itself (`RoughBase`). Oren-Nayar lobes beside others become one that keeps their energy at every knot: stock nodes use the weight as the color of its multiple
scattering, whose power differs between Blenders. Where it is the model's and nothing lies above, that is exact;
for Blender up to 5.2 the L1 error is 1.3 % at most (tests/reference_py/test_tabulate.py).
"""

from dataclasses import replace

import numpy as np

from ..material.stack import Stack
from ..optics.diffuse import OREN_NAYAR_POWER, oren_nayar_albedo, oren_nayar_color
from .bare_base import is_bare_oren_nayar
from .closure import fresnel_share
from .live_grid import LiveLobes
from .live_tables import NARROWEST_CURVE, LiveTables, live_tables
from .lobe import DielectricCurve, DiffuseLobe, GlossyLobe
from .made import Made
from .own_normals import normal_place
from .patch_lobes import PatchLobes
from .view_table import AZIMUTHS, KNOTS, BaseColorTable, DiffuseTable, GlossyTable, OrenNayarTable, RoughBase, TableLobes, knot_cosines


def tabulate(lobe_set, keep_dielectrics: bool = False, power: int = OREN_NAYAR_POWER) -> TableLobes | LiveTables | PatchLobes:
    """A lobe set in tables, those of one over live values in tables over these too, or, of a PatchLobes, one of such; `keep_dielectrics` leaves lobes their dielectric curve that
    are grey, isotropic, of weight 2 at most and wider than NARROWEST_CURVE. `power` is that of Oren-Nayar lobes (`DiffuseLobe`).
    Bare metals over live values keep their curve with it, and have what they have in the place of such lobes without.

    `lobe_set` has `lobes(cos_theta_o)`, the same list of kinds at every view, and those that make a bare rough base its `stack`. Lobes of no weight are left out, but one stays.
    """
    if isinstance(lobe_set, PatchLobes):
        return PatchLobes(lobe_set.stack, tuple((patch, tabulate(part.lobe_set, keep_dielectrics, power)) for patch, part in lobe_set.parts))
    if isinstance(lobe_set, LiveLobes):
        keeps = keep_dielectrics and lobe_set.knows_metal
        return live_tables(lobe_set if keeps else lobe_set.stock or lobe_set, keep_dielectrics)
    lobe_set = stock_lobes(lobe_set)
    stack = getattr(lobe_set, "stack", None)
    if stack is not None and is_bare_oren_nayar(stack):
        return TableLobes((_rough_base(stack, power),))
    tables = lobe_set.tables if isinstance(lobe_set, TableLobes) else tables_of(lobe_set, power)
    tables = [table if keep_dielectrics and _has_seen_curve(table) else _without_curve(table) for table in tables]
    return TableLobes(tuple([t for t in tables if isinstance(t, BaseColorTable) or np.any(t.weight > 0.0)] or tables[-1:]))


def _rough_base(stack: Stack, power: int) -> RoughBase:
    return RoughBase(np.array(stack.base["color"]), float(stack.base["sigma_deg"]), power, normal_place(stack, None))


def without_metals(made: Made) -> Made:
    """What shows where a metal's Fresnel curve is not known."""
    lobe_set = made.lobe_set
    if isinstance(lobe_set, PatchLobes):
        return replace(made, lobe_set=replace(lobe_set, parts=tuple((patch, without_metals(part)) for patch, part in lobe_set.parts)))
    if not isinstance(lobe_set, LiveLobes) or not lobe_set.knows_metal:
        return made
    return replace(made, lobe_set=lobe_set.stock, choice=made.choice and replace(made.choice, chosen=made.choice.stock))


def stock_lobes(lobe_set):
    """The lobe set that stock nodes have in the place of one: of ramps of diffuse light (`diffuse_ramp`) they know Lambert's alone."""
    if not isinstance(lobe_set, TableLobes):
        return lobe_set
    tables = (lobe_set.stock or lobe_set).tables
    return TableLobes(tuple([table if getattr(table, "ramp", None) is None else replace(table, ramp=None) for table in tables]))


def is_grey_dielectric(table) -> bool:
    """Whether a table is of an upright isotropic lobe with a dielectric curve, its weight grey and 2 at most."""
    return (
        isinstance(table, GlossyTable)
        and isinstance(table.fresnel, DielectricCurve)
        and table.frame is None
        and table.axis is None
        and bool(np.all(table.shape[:, 0] == table.shape[:, 1]) and not np.any(table.shape[:, 2]))
        and bool(np.all(table.weight == table.weight[:, :1]) and np.max(table.weight) <= 2.0)
    )


def _has_seen_curve(table) -> bool:
    return is_grey_dielectric(table) and bool(np.max(table.shape[:, 0]) > NARROWEST_CURVE)


def _without_curve(table):
    if not isinstance(table, GlossyTable) or table.fresnel is None:
        return table
    alpha_x, alpha_y, slope = table.shape.T
    lobe = GlossyLobe(table.distribution, table.weight, alpha_x, alpha_y, np.arctan(slope * _knot_sines()), table.fresnel, table.frame)
    if table.frame is None:
        return replace(table, weight=table.weight * fresnel_share(lobe, knot_cosines()), fresnel=None)
    shares = np.stack([fresnel_share(lobe, knot_cosines(), phi) for phi in _azimuths(table.frame)])
    return replace(table, weight=table.weight * shares, fresnel=None, axis=table.frame)


def _azimuths(axis: float) -> np.ndarray:
    return axis + np.arccos(AZIMUTHS)


def tables_of(lobe_set, power: int = OREN_NAYAR_POWER) -> list[GlossyTable | DiffuseTable | OrenNayarTable]:
    """The lobes of a live set at the knots, with the curves that they have."""
    cosines = knot_cosines()
    lobes = lobe_set.lobes(cosines)
    frames = [lobe.frame for lobe in lobes if isinstance(lobe, GlossyLobe) and lobe.frame is not None]
    # each lobe's weights about its own axis; those of lobes without one turn with the first that has
    around = {frame: [lobe_set.lobes(cosines, phi) for phi in _azimuths(frame)] for frame in dict.fromkeys(frames)}
    tables, rough = [], []
    for i, lobe in enumerate(lobes):
        own = lobe.frame if isinstance(lobe, GlossyLobe) else None
        axis = own if own is not None else next(iter(frames), None)
        weight = np.broadcast_to(lobe.weight, (KNOTS, 3))
        if axis is not None:
            sheets = np.stack([np.broadcast_to(rotated[i].weight, (KNOTS, 3)) for rotated in around[axis]])
            weight, axis = (weight, None) if np.all(sheets == weight) else (sheets, axis)
        if _is_oren_nayar(lobe):
            rough.append((replace(lobe, weight=weight), axis))
        else:
            tables.append(_table(lobe, weight, axis))
    return [*tables, _oren_nayar_table(rough, power)] if rough else tables


def _is_oren_nayar(lobe) -> bool:
    return isinstance(lobe, DiffuseLobe) and lobe.color is not None


def _table(lobe: GlossyLobe | DiffuseLobe, weight: np.ndarray, axis: float | None):
    if isinstance(lobe, GlossyLobe):
        shape = *_at_knots(lobe.alpha_x, lobe.alpha_y), _slope(lobe.tilt)
        return GlossyTable(lobe.distribution, weight, np.stack(shape, axis=-1), lobe.fresnel, lobe.frame, axis, lobe.normal)
    return DiffuseTable(weight, axis, lobe.normal)


def _oren_nayar_table(lobes: list[tuple[DiffuseLobe, float | None]], power: int) -> OrenNayarTable | DiffuseTable:
    """One lobe of the energy of several whose facets are equally inclined and whose axes are the same."""
    energy = sum(lobe.weight * oren_nayar_albedo(knot_cosines(), lobe.color, lobe.sigma_deg, lobe.power) for lobe, _ in lobes)
    (first, axis), *_ = lobes
    if not first.sigma_deg:
        return DiffuseTable(energy, axis, first.normal)
    return OrenNayarTable(oren_nayar_color(knot_cosines(), energy, first.sigma_deg, power), first.sigma_deg, power, axis, first.normal)


def _at_knots(*values) -> list[np.ndarray]:
    return [np.broadcast_to(np.asarray(value, float), (KNOTS,)) for value in values]


def _knot_sines() -> np.ndarray:
    return np.sqrt(1.0 - np.square(knot_cosines()))


def _slope(tilt) -> np.ndarray:
    """tan(tilt) / sin(theta_o) at the knots; at the normal, where both vanish, that of the knot before."""
    tilt, sines = _at_knots(tilt, _knot_sines())
    slope = np.tan(tilt[:-1]) / sines[:-1]
    return np.append(slope, slope[-1])
