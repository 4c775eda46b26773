# SPDX-License-Identifier: GPL-3.0-or-later
"""Spheres and maps on the axes of matplotlib."""

import numpy as np

from .seen_colors import displayed


def show_sphere(axes, xyz: np.ndarray, theta_deg: np.ndarray, label: str = "") -> None:
    """A sphere of XYZ (size, size, 3) with a smooth rim."""
    sin = np.sin(np.radians(np.nan_to_num(theta_deg, nan=90.0)))
    cover = np.clip((1.0 - sin) * 0.5 * len(theta_deg), 0.0, 1.0)
    axes.imshow(np.concatenate([displayed(xyz), cover[..., None]], axis=-1), interpolation="bilinear")
    axes.set_title(label, fontsize=8)
    axes.set_axis_off()


def show_map(figure, axes, values: np.ndarray, label: str, limit: float, colormap: str = "RdBu_r") -> None:
    """A signed map (size, size) with its scale; nan beside the sphere."""
    image = axes.imshow(values, cmap=colormap, vmin=-limit, vmax=limit)
    axes.set_title(label, fontsize=8)
    axes.set_axis_off()
    figure.colorbar(image, ax=axes, shrink=0.75).ax.tick_params(labelsize=7)
