# SPDX-License-Identifier: GPL-3.0-or-later
"""Plots of models: albedo by angle, f in the plane of incidence, and the same as lobes around the surface."""

from collections.abc import Sequence

import numpy as np

from ..models.model import Model
from ..optics.frame import spherical
from . import svg

WIDTH, HEIGHT = 340.0, 250.0
VIEWS_DEG = (0.0, 30.0, 60.0)
_THETA_DEG = np.linspace(0.0, 85.0, 18)
# Angles of light in the plane of incidence: positive where a mirror sends it.
_LIGHT_DEG = np.linspace(-88.0, 88.0, 177)
# Powers of ten that are shown below the largest value.
_DECADES = 6
# What a legend has room for beside a title, and beside lobes.
_NAMED_IN_A_ROW, _NAMED_IN_A_COLUMN = 6, 8


def albedo(model: Model) -> list[str]:
    """Directional albedo by the view's angle, a line for each channel."""
    values = model.albedo(spherical(np.radians(_THETA_DEG), 0.0))
    colors = svg.channel_colors(model.channels)
    # the last is dashed: where it lies on another, both show
    lines = [(column, color, color == colors[-1]) for column, color in zip(values.T, colors)]
    top = max(1.0, float(np.ceil(5.0 * np.max(values)) / 5.0))
    ticks = {tick: f"{tick:.3g}" for tick in np.linspace(0.0, top, 5)}
    parts = svg.axes((WIDTH, HEIGHT), f"albedo, {model.name}", _THETA_DEG, lines, "view, degrees from the normal", (0.0, 30.0, 60.0, 85.0), ticks)
    names = ("red", "green", "blue") if model.channels == 3 else ("shortest", "longest wavelength")
    return parts + svg.legend(WIDTH - 10.0, 15.0, list(zip(names, colors if model.channels == 3 else (colors[0], colors[-1]))))


def plane(model: Model, views_deg: Sequence[float] = VIEWS_DEG) -> list[np.ndarray]:
    """For each view: f times the light's cosine (177, channels) in the plane of incidence."""
    wi = spherical(np.radians(_LIGHT_DEG), np.pi)
    return [model.f(np.broadcast_to(spherical(np.radians(view), 0.0), wi.shape), wi) * wi[:, 2:] for view in views_deg]


def lobes(values: Sequence[np.ndarray], views_deg: Sequence[float] = VIEWS_DEG) -> list[str]:
    """f cos over the light's angle, of `plane`: the mean over channels for each view, as powers of ten."""
    means = [np.maximum(v.mean(axis=-1), 1e-30) for v in values]
    top = int(np.ceil(np.log10(max(float(np.max(means)), 1e-20))))
    ticks = {float(power): f"1e{power}" for power in range(top - _DECADES, top + 1)}
    # a line ends where it leaves what is shown
    shown = [np.where(mean >= 10.0 ** (top - _DECADES), np.log10(mean), np.nan) for mean in means]
    lines, title = list(zip(shown, _shades(means), _dashes(means))), "f cos in 1/sr, plane of incidence"
    x_label, x_ticks = "light, degrees; a mirror sends it to the right", (-60.0, -30.0, 0.0, 30.0, 60.0)
    entries = [(f"{view:g}", color) for view, color in _named(views_deg, _NAMED_IN_A_ROW)]
    return svg.axes((WIDTH, HEIGHT), title, _LIGHT_DEG, lines, x_label, x_ticks, ticks) + svg.legend(WIDTH - 10.0, 15.0, entries)


def polar(values: Sequence[np.ndarray], views_deg: Sequence[float] = VIEWS_DEG) -> list[str]:
    """The same around the surface: each view's largest value reaches the outer circle, each circle inwards is a tenth of the one outside."""
    centre, radius = np.array([0.5 * WIDTH, HEIGHT - 30.0]), 0.5 * WIDTH - 18.0
    angle = np.radians(np.linspace(-90.0, 90.0, 91))
    parts = [svg.text(46.0, 15.0, "lobes: f cos, a tenth from circle to circle")]
    for ring in range(1, _DECADES + 1):
        parts.append(svg.line(centre + radius * ring / _DECADES * _around(angle), svg.GRID, 1.0))
    parts.append(svg.line(centre + np.array([[-radius, 0.0], [radius, 0.0]]), svg.INK, 1.0))
    for view, value, color, dashed in zip(views_deg, values, _shades(values), _dashes(values)):
        mean = np.maximum(value.mean(axis=-1), 1e-30)
        reach = np.maximum(1.0 + np.log10(mean / np.max(mean)) / _DECADES, 0.0)
        parts.append(svg.line(centre + radius * reach[:, None] * _around(np.radians(_LIGHT_DEG)), color, 1.5, dashed))
        parts.append(svg.line(centre + np.array([radius + 2.0, radius + 12.0])[:, None] * _around(np.radians(-view)), color, 2.0))
    return parts + _legend(views_deg)


def _around(angle) -> np.ndarray:
    """Points (..., 2) of the circle at angles from the normal, to the right."""
    return np.stack([np.sin(angle), -np.cos(angle)], axis=-1)


def _shades(values: Sequence) -> list[str]:
    places = [i / max(len(values) - 1, 1) for i in range(len(values))]
    return [svg.hue(210.0 + 110.0 * place, 0.25 + 0.3 * place, 0.6) for place in places]


def _dashes(values: Sequence) -> list[bool]:
    return [i % 2 == 1 for i in range(len(values))]


def _legend(views_deg: Sequence[float]) -> list[str]:
    named = _named(views_deg, _NAMED_IN_A_COLUMN)
    return [svg.text(WIDTH - 10.0, 32.0 + 13.0 * i, f"view {view:g}", "end", color) for i, (view, color) in enumerate(named)]


def _named(views_deg: Sequence[float], most: int) -> list[tuple[float, str]]:
    """(view, color) of all views, or of every so many where a legend has no room for them."""
    every = -(-len(views_deg) // most)
    return list(zip(views_deg, _shades(views_deg)))[::every]
