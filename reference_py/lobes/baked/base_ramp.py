# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the light of a base goes through its layers: of tables, and of the Lambert lobe at every node of a grid, as few ramps together."""

from dataclasses import replace
from functools import reduce

import numpy as np

from ..diffuse_ramp import RAMP_COSINES, ramp_energy, ramp_of
from ..live_grid import DIGITS, LiveLobes, LiveRamp
from ..view_table import DiffuseTable, interpolate

# Ramps beside Lambert's: as many as a color holds. Of a varnish whose roughness, tint and index are live .5 % of the light goes amiss at the worst; with two it would be 2 %.
_MODES = 3


def reciprocal(table: DiffuseTable) -> DiffuseTable:
    """The table of a base's light with the ramp of where it goes, which is as it comes."""
    return replace(table, ramp=ramp_of(interpolate(table.weight, RAMP_COSINES)))


def with_ramp(lobes: LiveLobes) -> LiveLobes:
    """The lobes with the ramp of their Lambert lobe, whose light goes as it comes."""
    knots = [axis.knots.knots for axis in lobes.axes]
    size = tuple(map(len, knots))

    def through(node: tuple[int, ...]) -> np.ndarray:
        here = reduce(lambda stack, part: part[0].at(stack, float(part[1][part[2]])), zip(lobes.axes, knots, node), lobes.stack)
        return replace(lobes, stack=here).lambert_light(RAMP_COSINES)

    light = np.stack([through(node) for node in np.ndindex(size)])
    beside_lambert = np.stack([ramp_of(values) for values in light]) - RAMP_COSINES[:, None]
    # where little light gets out little is seen of where it goes
    seen = np.sqrt(np.stack([ramp_energy(values * RAMP_COSINES[:, None]) for values in light]))
    rows = np.swapaxes(beside_lambert * seen[:, None], 1, 2).reshape(-1, len(RAMP_COSINES))
    modes = np.linalg.svd(rows, full_matrices=False)[2][:_MODES]
    amounts = (modes @ beside_lambert).reshape(*size, len(modes), 3).round(DIGITS)
    return replace(lobes, ramp=LiveRamp(modes, amounts))
