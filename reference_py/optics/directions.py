# SPDX-License-Identifier: GPL-3.0-or-later
"""Directions as columns: (3, n).T is the layout that computes fastest."""

import numpy as np


def components(w: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The three columns (n,) of w (n, 3)."""
    return w[:, 0], w[:, 1], w[:, 2]


def vectors(x, y, z) -> np.ndarray:
    """The (n, 3) array of three columns, each of them contiguous in memory."""
    out = np.empty((3, len(z)))
    out[0], out[1], out[2] = x, y, z
    return out.T


def take(w: np.ndarray, index: np.ndarray) -> np.ndarray:
    """Rows of w (n, m) in the layout that computes fastest."""
    return w.T.take(index, axis=1).T
