# SPDX-License-Identifier: GPL-3.0-or-later
"""Small cross-sections of layers: how thick, how rough and of which color, at a glance. Does not need bpy."""

import numpy as np

from ...reference_py.optics.microfacet import slope_deg_from_roughness

SIZE = 32
_SHEET = 0.62  # share of the height that unit thickness takes, and, of that, what no thickness takes
_THINNEST = 0.25
_STEEPEST_DEG = 60.0
_LIGHT, _DARK = 0.72, 0.5  # the checkered paper behind what is clear
_EDGE = 0.08
_BUMPS = 3.0


def layer_picture(transmitted: tuple[float, float, float], thickness: float, roughness: float, distribution: str, coverage: float = 1.0) -> np.ndarray:
    """A layer seen from the side, (SIZE, SIZE, 4) sRGB from the bottom row up, as Blender's icons want it.

    `transmitted` is the color that one crossing leaves of white light, linear RGB. The thickness is shown on a scale
    that never ends: unit thickness fills 62 percent. Uncovered parts are cut away from the right.
    """
    height = _THINNEST + (1.0 - _THINNEST) * (1.0 - (1.0 - _SHEET) ** max(thickness, 0.0)) * 0.9
    x, y = _places()
    inside = (y < _outline(x, height, roughness, distribution)) & (x < coverage)
    paper = np.where((np.floor(x * 4.0) + np.floor(y * 4.0)) % 2.0 == 0.0, _LIGHT, _DARK)[..., None]
    edge = inside & (y > _outline(x, height, roughness, distribution) - _EDGE)
    color = _srgb(np.asarray(transmitted, float)) * np.ones(3)
    picture = np.zeros((SIZE, SIZE, 4))
    picture[inside] = np.concatenate([np.broadcast_to(paper * color, (SIZE, SIZE, 3)), np.ones((SIZE, SIZE, 1))], axis=-1)[inside]
    picture[edge, :3] = 1.0 - 0.5 * (1.0 - picture[edge, :3])
    return picture


def base_picture(color: tuple[float, float, float], roughness: float, distribution: str, coverage: float = 1.0) -> np.ndarray:
    """A base or an opaque layer seen from the side: (SIZE, SIZE, 4), as `layer_picture`; `color` is what it reflects, linear RGB."""
    x, y = _places()
    picture = np.zeros((SIZE, SIZE, 4))
    inside = (y < _outline(x, 0.75, roughness, distribution)) & (x < coverage)
    picture[inside] = (*_srgb(np.asarray(color, float)), 1.0)
    return picture


def _places() -> tuple[np.ndarray, np.ndarray]:
    """x and y of every pixel, 0 to 1."""
    middle = (np.arange(SIZE) + 0.5) / SIZE
    return np.broadcast_to(middle, (SIZE, SIZE)), np.broadcast_to(middle[:, None], (SIZE, SIZE))


def _outline(x: np.ndarray, height: float, roughness: float, distribution: str) -> np.ndarray:
    """The upper surface: a zigzag whose flanks are as steep as the facets are on average, within the picture."""
    slope = np.tan(np.radians(min(slope_deg_from_roughness(min(max(roughness, 0.0), 1.0), distribution), _STEEPEST_DEG)))
    zigzag = np.abs((x * _BUMPS) % 1.0 - 0.5) / _BUMPS
    return height - slope * zigzag


def _srgb(linear: np.ndarray) -> np.ndarray:
    """IEC 61966-2-1, clipped to 0 to 1."""
    linear = np.clip(linear, 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)
