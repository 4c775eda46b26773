# SPDX-License-Identifier: GPL-3.0-or-later
"""How many azimuthal modes of f a surface deep in a stack has to tell: each rough interface above blurs what comes from below it."""

from dataclasses import replace

import numpy as np

from .direction_grid import Grid
from .effective_stack import EffectiveStack
from .film_operators import film_operators
from .operators import InterfaceOperators, Resolution

# Modes that add less than this to f, in 1/sr, are left out: their bound is some ten times what they do add.
_UNSEEN = 1e-7
# Of the facets across the plane of incidence: fewer would move f by more than 1e-5.
_FEWEST_ACROSS = 24


def operators_by_depth(
    effective: EffectiveStack, channel: int, surface: str, grid: Grid, resolution: Resolution
) -> tuple[list[InterfaceOperators], Resolution]:
    """Operators of the interfaces in a channel, from the top, with the modes that are seen of each, and the resolution of the base.

    Below a medium that scatters no more are left out: what it turns takes other ways than those that are followed here.
    """
    operators: list[InterfaceOperators] = []
    asked: dict[tuple, Resolution] = {}
    through, is_clear = np.eye(grid.count(1.0))[None], True
    for k, interface in enumerate(effective.interfaces):
        like = (interface.facet(channel), interface.alpha, interface.distribution)
        # of interfaces that are alike the first has the most modes
        setup = (interface.alpha, interface.distribution, surface, grid, asked.setdefault(like, resolution))
        own = film_operators(interface.facet(channel), effective.distinct_facets[k], *setup).cut(resolution.modes)
        operators.append(own)
        is_clear = is_clear and interface.scattering is None
        if is_clear and resolution.modes > 1:
            through = through[: resolution.modes] @ own.t_down
            resolution = _seen(resolution, through, grid.weights(interface.n_below))
    return operators, resolution


def _seen(resolution: Resolution, through: np.ndarray, weights: np.ndarray) -> Resolution:
    """Without the last modes of which nothing shows, where `through` (modes, N, M) of the light from outside comes straight down.

    By Cauchy's inequality f, whose density is that of a row over `weights`, is at most this for anything below that gives back what it gets.
    """
    most = np.max(np.square(through) @ (1.0 / weights), axis=-1)
    modes = max(2, 1 + int(np.max(np.flatnonzero(most > _UNSEEN), initial=0)))
    return replace(
        resolution, modes=modes, across=min(resolution.across, max(_FEWEST_ACROSS, modes // 2)), left_out=resolution.left_out + resolution.modes - modes
    )
