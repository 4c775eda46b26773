# SPDX-License-Identifier: GPL-3.0-or-later
"""SVG text: shapes as strings, and axes with lines on them. Coordinates are pixels, y down."""

import colorsys
from collections.abc import Mapping, Sequence
from html import escape

import numpy as np

INK, GRID = "#444", "#ddd"
CHANNELS = ("#c0392b", "#27873b", "#2b5fc0")
_MARGIN_LEFT, _MARGIN = 46.0, 26.0
# Pixels of a letter, in the mean.
_LETTER = 5.6


def document(width: float, height: float, parts: Sequence[str]) -> str:
    """A whole picture, white below."""
    head = f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}" height="{height:g}" viewBox="0 0 {width:g} {height:g}"'
    return f'{head} font-family="sans-serif" font-size="11">\n<rect width="{width:g}" height="{height:g}" fill="#fff"/>\n' + "\n".join(parts) + "\n</svg>\n"


def moved(x: float, y: float, parts: Sequence[str]) -> str:
    """Parts in a frame that begins at (x, y)."""
    return f'<g transform="translate({x:g} {y:g})">' + "\n".join(parts) + "</g>"


def rect(x: float, y: float, width: float, height: float, fill: str) -> str:
    """A filled rectangle."""
    return f'<rect x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}" fill="{fill}"/>'


def line(points: np.ndarray, color: str = INK, width: float = 1.5, dashed: bool = False) -> str:
    """A line through points (n, 2)."""
    dash = ' stroke-dasharray="4 3"' if dashed else ""
    path = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    return f'<polyline points="{path}" fill="none" stroke="{color}" stroke-width="{width:g}"{dash}/>'


def text(x: float, y: float, words: str, anchor: str = "start", color: str = INK) -> str:
    """Words whose base line begins, ends or is centred at a point."""
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" fill="{color}">{escape(words)}</text>'


def channel_colors(count: int) -> list[str]:
    """A color for each channel: red, green and blue for three, else from violet to red."""
    if count == 3:
        return list(CHANNELS)
    return [hue(280.0 * (1.0 - i / max(count - 1, 1)), 0.4, 0.7) for i in range(count)]


def hue(degrees: float, lightness: float, saturation: float) -> str:
    """#rrggbb of a hue. Many programs that read SVG know no hsl()."""
    return "#" + "".join(f"{round(255.0 * v):02x}" for v in colorsys.hls_to_rgb(degrees / 360.0, lightness, saturation))


def legend(right: float, y: float, entries: Sequence[tuple[str, str]]) -> list[str]:
    """A row of (words, color) that ends at `right`."""
    parts = []
    for words, color in reversed(entries):
        parts.append(text(right, y, words, "end", color))
        right -= _LETTER * len(words) + 8.0
    return parts


def fitted(words: str, width: float) -> str:
    """Words, cut where they would be wider than so many pixels."""
    letters = int(width / _LETTER)
    return words if len(words) <= letters else words[: letters - 1].rstrip() + "…"


def axes(
    size: tuple[float, float],
    title: str,
    x: np.ndarray,
    lines: Sequence[tuple[np.ndarray, str, bool]],
    x_label: str,
    x_ticks: Sequence[float],
    y_ticks: Mapping[float, str],
) -> list[str]:
    """A plot of lines, each (values (n,), color, dashed) over x (n,), between the first and the last of the ticks. Values that are not finite are left out."""
    (width, height), bottom, top = size, min(y_ticks), max(y_ticks)
    left, right, low, high = _MARGIN_LEFT, width - 10.0, height - _MARGIN - 12.0, _MARGIN
    first, last = float(x[0]), float(x[-1])

    def at(value, y):
        return left + (value - first) / (last - first) * (right - left), low - np.clip((y - bottom) / (top - bottom), 0.0, 1.0) * (low - high)

    parts = [text(left, 15.0, title), text(0.5 * (left + right), height - 6.0, x_label, "middle")]
    for tick, words in y_ticks.items():
        parts += [line([at(first, tick), at(last, tick)], GRID, 1.0), text(left - 4.0, at(first, tick)[1] + 4.0, words, "end")]
    parts += [text(at(tick, bottom)[0], low + 14.0, f"{tick:g}", "middle") for tick in x_ticks]
    for values, color, dashed in lines:
        known = np.isfinite(values)
        parts.append(line(np.stack(at(x[known], values[known]), axis=-1), color, 1.5, dashed))
    return parts
