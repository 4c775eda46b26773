# SPDX-License-Identifier: GPL-3.0-or-later
"""The bake of a stack, whatever of it is live, and its JSON."""

from collections.abc import Callable
from dataclasses import replace

from ...material.place import Place
from ...material.stack import Stack
from ...optics.bases import DiffuseBase
from ...optics.optical_stack import OpticalStack, rough_surfaces
from ..axes import has_waves
from ..diffuse_ramp import RAMP_COSINES, ramp_of
from ..live_grid import LiveLobes
from ..serialize import pack_grid, pack_tables, unpack_grid, unpack_tables
from ..truth import truth_of
from ..view_table import BASE_COLOR, DiffuseTable, TableLobes, interpolate
from .bake import Baker
from .bare_metal import bake_metal, is_bare_metal
from .black_and_white import BlackAndWhite, base_of, followed, over
from .brushed_bake import brushed, is_brushed
from .brushed_grid import bake_brushed
from .live import axes_of, bake_live, without_knots
from .ramped import RampBaker

# Of live values at once whose grids are made twice, for OSL and for stock nodes; beside a film one alone.
_MOST_AXES_TWICE = 2


def baked(stack: Stack, live: tuple[Place, ...], glossy: int, progress: Callable[[float], None] | None) -> TableLobes | LiveLobes:
    """The lobe set of a stack that follows these live values, which `follows` allows."""
    if is_brushed(stack):
        return bake_brushed(stack, live, progress or (lambda share: None)) if live else brushed(stack, progress)
    if not live:
        return best_of(Baker(stack, truth_of(stack), progress), glossy)
    if live == (BASE_COLOR,):
        return _over_base_color(stack, glossy, progress)
    report = progress or (lambda share: None)
    if is_bare_metal(stack, live):
        return bake_metal(stack, live, glossy, report)
    return _over_live_values(stack, live, glossy, report)


def _over_live_values(stack: Stack, live: tuple[Place, ...], glossy: int, report: Callable[[float], None]) -> LiveLobes:
    """The grid of a stack over live values; for OSL its base's light apart, as if the color were live too, so that it has a ramp."""
    optical, axes = OpticalStack.of(stack), axes_of(stack, without_knots(stack, live))
    scatters = any(surface.scattering is not None for surface in optical.interfaces)
    # light that a rough base reflects knows still where it came from, which fits beside a rough coat have too
    has_ramp = isinstance(optical.base, DiffuseBase) and not scatters and (not optical.base.sigma_deg or not rough_surfaces(stack))
    takes_long = len(axes) > (1 if has_waves(axes) else _MOST_AXES_TWICE)
    if BASE_COLOR in live or not stack.layers or not has_ramp or takes_long:
        return bake_live(stack, live, glossy, report)
    ramped = bake_live(stack, (*live, BASE_COLOR), glossy, lambda share: report(0.5 * share))
    stock = bake_live(stack, live, glossy, lambda share: report(0.5 + 0.5 * share))
    assert ramped.base is not None, "its color is followed"
    return replace(ramped, base=replace(ramped.base, is_live=False), stock=stock)


def best_of(baker: Baker, glossy: int) -> TableLobes:
    """The closest bake of at most so many glossy lobes, and what stock nodes have in its place."""
    ramped, stock = RampBaker(baker), baker.bake(glossy).lobe_set
    best = min([stock, *map(ramped.lobe_set, ramped.counts(glossy))], key=baker.shape_error)
    return best if best is stock else replace(best, stock=stock)


def _over_base_color(stack: Stack, glossy: int, progress) -> TableLobes:
    """The lobes of a stack over a diffuse base of any color."""
    black, truth = over(stack, 0.0), BlackAndWhite(stack)
    baker, base = Baker(black, truth, progress), base_of(truth.black, stack)
    stock = followed(baker.lobe_set(baker.path(glossy), keep=(DiffuseTable,)), base)
    # what a medium reflects knows still where it came from; so does a rough base's light, but fits that it shares with the layers show it worse
    if baker.is_smooth or any(surface.scattering is not None for surface in OpticalStack.of(stack).interfaces):
        return stock
    of_layers = Baker(black, truth.black, progress)
    *tables, lambert = of_layers.lobe_set(of_layers.path(glossy), keep=(DiffuseTable,)).tables
    light = replace(base, own=lambert.weight, ramp=ramp_of(interpolate(base.through, RAMP_COSINES)))
    return TableLobes((*tables, light), stock)


def pack_lobes(lobe_set: TableLobes | LiveLobes) -> dict:
    """A baked lobe set as JSON's types."""
    return {"grid": pack_grid(lobe_set)} if isinstance(lobe_set, LiveLobes) else {"tables": pack_tables(lobe_set)}


def unpack_lobes(data: dict, stack: Stack) -> TableLobes | LiveLobes:
    """The lobe set of `pack_lobes`. Raises ValueError, KeyError or TypeError on anything else."""
    return unpack_grid(data["grid"], stack) if "grid" in data else unpack_tables(data["tables"], stack)
