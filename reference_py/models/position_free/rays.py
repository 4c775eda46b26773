# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays of a walk, many at once."""

from dataclasses import dataclass, fields

import numpy as np

from ...optics.directions import take


@dataclass(frozen=True, eq=False, repr=False)
class Rays:
    """Rays that wait for a surface, or fly in a medium that scatters, one per row."""

    w: np.ndarray
    """(n, 3), back to where it came from, in the frame of the surface and side that it meets next; within a medium its travel."""
    throughput: np.ndarray
    """(n, 3), RGB"""
    path: np.ndarray
    """(n,), index of the walk"""
    carry: np.ndarray | None = None
    """(n,), what `connect` has to remember; None without a light"""
    share: np.ndarray | None = None
    """(n, 3), how likely the walk was by each channel's distances, to a sum of 1; None where channels do not differ in extinction"""
    depth: np.ndarray | None = None
    """(n,), share of the medium's thickness that is above; None outside of one"""

    def take(self, index: np.ndarray) -> "Rays":
        """The rays at an index (m,)."""
        return Rays(*(v if v is None else take(v, index) if v.ndim == 2 else v[index] for v in self._values()))

    def _values(self) -> tuple:
        return tuple(getattr(self, field.name) for field in fields(self))

    @staticmethod
    def joined(parts: "list[Rays]") -> "Rays":
        """All of them, one after the other."""
        if len(parts) == 1:
            return parts[0]
        columns = zip(*(part._values() for part in parts))
        return Rays(*(None if same[0] is None else np.concatenate([v.T for v in same], axis=-1).T for same in columns))
