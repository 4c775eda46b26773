# SPDX-License-Identifier: GPL-3.0-or-later
"""Adding: operators of a stack from those of its parts (Stam01; Jakob14, section 5).

All reflections between two parts are one linear solve. Matrices are (modes, from, to), see `operators`.
"""

from dataclasses import dataclass

import numpy as np

from ...optics.slab import Slab

# Light that smooth interfaces trap for good makes the solve singular. It meets no one outside (its couplings are
# exactly 0), so a loss this small per round trip decides only that it is 0 and not undefined.
TRAPPED_LOSS = 1e-13


@dataclass(frozen=True, eq=False, repr=False)
class Layers:
    """Reflection and transmission of some layers without base, for light from above (r_up, t_down) and from below."""

    r_up: np.ndarray
    t_down: np.ndarray
    r_down: np.ndarray
    t_up: np.ndarray

    def over_medium(self, medium: "Medium") -> "Layers":
        """With a medium below."""
        if isinstance(medium, ScatteringMedium):
            return add(self, medium.layers)
        column = medium.share[:, None]
        return Layers(self.r_up, self.t_down * medium.share, column * self.r_down * medium.share, column * self.t_up)


@dataclass(frozen=True, eq=False, repr=False)
class Medium:
    """A medium that only absorbs, of which one crossing leaves `share` (N,)."""

    share: np.ndarray

    def over(self, below: np.ndarray) -> np.ndarray:
        """Reflection operator of what is below, seen through the medium."""
        return below * (self.share[:, None] * self.share)

    def once(self, specular: np.ndarray) -> np.ndarray:
        """Light that met one event in the medium, over something that reflects shares (N,) as a mirror."""
        return np.zeros(1)


@dataclass(frozen=True, eq=False, repr=False)
class ScatteringMedium(Medium):
    """A medium that scatters too, the same from above and below. `share` is what it lets pass as if nothing were met."""

    slab: Slab

    @property
    def layers(self) -> Layers:
        """As layers without interface."""
        return Layers(self.slab.reflection, self.slab.transmission, self.slab.reflection, self.slab.transmission)

    def over(self, below: np.ndarray) -> np.ndarray:
        """Reflection operator of what is below, seen through the medium."""
        back, on = self.slab.reflection, self.slab.transmission
        return back + on @ round_trips(below, back, below @ on)

    def once(self, specular: np.ndarray) -> np.ndarray:
        """One event, over something that reflects shares (N,) as a mirror: before it, after it, both or neither."""
        mirrored = self.share * specular
        back, on = self.slab.reflected_once, self.slab.transmitted_once
        return back + mirrored[:, None] * on + on * mirrored + mirrored[:, None] * back * mirrored


def empty(count: int, modes: int) -> Layers:
    """No layer at all, in a medium of `count` nodes."""
    nothing, everything = np.zeros((modes, count, count)), np.broadcast_to(np.eye(count), (modes, count, count))
    return Layers(nothing, everything, nothing, everything)


def round_trips(first: np.ndarray, second: np.ndarray, then: np.ndarray) -> np.ndarray:
    """(1 + first second + (first second)^2 + ...) then."""
    return np.linalg.solve(np.eye(first.shape[-2]) - (1.0 - TRAPPED_LOSS) * (first @ second), then)


def add(upper: Layers, lower: Layers) -> Layers:
    """`upper` directly over `lower`."""
    down = upper.t_down @ round_trips(lower.r_up, upper.r_down, np.concatenate([lower.r_up, lower.t_down], axis=-1))
    up = lower.t_up @ round_trips(upper.r_down, lower.r_up, np.concatenate([upper.t_up, upper.r_down], axis=-1))
    middle, above = lower.r_up.shape[-1], upper.t_up.shape[-1]
    return Layers(
        r_up=upper.r_up + down[..., :middle] @ upper.t_up,
        t_down=down[..., middle:],
        r_down=lower.r_down + up[..., above:] @ lower.t_down,
        t_up=up[..., :above],
    )
