# SPDX-License-Identifier: GPL-3.0-or-later
"""Base colors that make one material as bright as another: mean albedos, solved per channel.

A view of a layered material sees R + a c / (1 - b c) of a base of albedo c: exactly for a Lambert base, nearly for
others. So a map from one material's base color to another's is (p0 + p1 c) / (1 + p2 c) per channel (`ColorMap`),
which three colors determine, and textures go through it.
"""

from collections.abc import Callable, Container
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from ..material.schema import ANISOTROPY, NORMAL, THIN_FILM
from ..material.stack import Base, LayerOrBase, Stack
from ..models.model import Model
from ..optics.colour import ciede2000, lab_of_linear
from ..optics.frame import spherical
from ..optics.gauss import gauss_legendre
from ..optics.interface import Microfacets
from ..registry import make_model
from .report import Match
from .slots import Slots, is_body

_X, _W = gauss_legendre(6)
COSINES = 0.5 * (_X + 1.0)
"""Cosines of the views that albedos are compared at, Gauss points; weighted by twice the cosine."""
_WEIGHTS = COSINES * _W
_WO = spherical(np.arccos(COSINES), 0.0)
TOLERANCE, FINE = 1e-4, 1e-6
"""Of a solved mean albedo; the second where a color comes back from it."""
_STEPS = 6
_PROBES = (0.0, 0.6, 0.95)
_UNSEEN = 1e-9
# Colors that are looked at where a film makes brighter ones darker, and then between two of them.
_SCANNED, _CLOSE_BY = 21, 0.03
_BETWEEN = np.linspace(-0.04, 0.04, 9)

Albedos = Callable[[np.ndarray], np.ndarray]
"""Albedo (views, 3) of a material whose base color is (3,)."""


def truth(stack: Stack, filmed: Container[int] = ()) -> Albedos:
    """Albedos of a stack by the exact model; None is its own color, and what scatters above a base of its own color has that too.

    Anisotropy counts by its mean width, normals do not count, films only of the elements `filmed`: indices of layers, -1 the base.
    """
    layers = tuple(_plain(e, i in filmed) for i, e in enumerate(stack.layers))
    plain = replace(stack, layers=layers, base=_plain(stack.base, -1 in filmed))

    def albedos(color=None):
        return make_model("adding", plain if color is None else with_color(plain, color)).albedo(_WO)

    return albedos


def with_color(stack: Stack, color) -> Stack:
    """A stack whose base, and a medium on it that goes on without end, have another color."""
    base = recolored(stack.base, color)
    if not stack.layers or not is_body(stack.layers[-1], stack.base):
        return replace(stack, base=base)
    return replace(stack, layers=(*stack.layers[:-1], stack.layers[-1].with_values(scatter_color=base["color"])), base=base)


def recolored(base: Base, color) -> Base:
    """A base with another color."""
    return base.with_values(**{color_key(base): tuple(float(c) for c in np.broadcast_to(color, 3))})


def color_key(base: Base) -> str:
    """The parameter that is the base's color."""
    return "color" if "color" in base else "reflectance"


def _plain(element: LayerOrBase, keeps_film: bool) -> LayerOrBase:
    left_out = {p.name for f in (ANISOTROPY, NORMAL, *(() if keeps_film else (THIN_FILM,))) for p in f.parameters}
    values = {k: v for k, v in element.values.items() if k not in left_out}
    if element.has(ANISOTROPY):
        values["roughness"] = Microfacets.of(element).alpha ** 0.5
    return type(element)(element.kind, MappingProxyType(values))


def rendered_by(make: Callable[[Stack], Model], slots: Slots) -> Albedos:
    """Albedos of slots by the model that renders them, which `make` makes of a stack."""

    def albedos(color):
        colored = slots.with_color(np.clip(color, 0.0, 1.0))
        weight = slots.coat_weight if slots.coat else 0.0
        total = np.zeros((len(COSINES), 3))
        for share, coated in ((weight, True), (1.0 - weight, False)):
            if share > 0.0:
                total = total + share * make(colored.image(coated)).albedo(_WO)
        return total

    return albedos


def mean(albedo: np.ndarray) -> np.ndarray:
    """Mean (3,) of albedos (views, 3) over the views."""
    return _WEIGHTS @ albedo


def solve(albedos: Albedos, wanted: np.ndarray, start: np.ndarray, most: float = 1.0, tolerance: float = TOLERANCE) -> tuple[np.ndarray, np.ndarray]:
    """Base color (3,) in 0..most whose mean albedo is `wanted` (3,), and its albedos (views, 3).

    A secant per channel; where no color is bright or dark enough the nearest one.
    """
    old = np.clip(np.asarray(start, float), 0.0, most)
    shown = albedos(old)
    value_old = mean(shown)
    new = np.clip(old + np.where(wanted > value_old, 1.0, -1.0) * np.maximum(np.abs(wanted - value_old), 0.02), 0.0, most)
    new = np.where(new == old, np.where(old > 0.5 * most, old - 0.1, old + 0.1), new)
    for _ in range(_STEPS):
        if np.all(np.abs(value_old - wanted) < tolerance):
            return old, shown
        shown = albedos(new)
        value = mean(shown)
        if np.all((np.abs(value - wanted) < tolerance) | ((new <= 0.0) & (value > wanted)) | ((new >= most) & (value < wanted))):
            break
        slope = np.divide(value - value_old, new - old, out=np.full(3, 1.0), where=np.abs(new - old) > 1e-9)
        step = np.where(np.abs(value - wanted) < 0.1 * tolerance, 0.0, (wanted - value) / np.maximum(slope, 0.02))
        old, value_old, new = new, value, np.clip(new + step, 0.0, most)
    return new, shown


def compared(original: np.ndarray, converted: np.ndarray, without_film: bool = False, lost: np.ndarray | None = None) -> Match:
    """How two materials' albedos (views, 3) differ.

    `without_film` says that both were taken without their thin film; `lost` is light (views, 3) that the original sends
    out beside this albedo, and that no stack has: it counts as missing, whatever stands in its place.
    """
    lost = np.zeros_like(original) if lost is None else lost
    whole = original + lost
    difference = np.abs(converted - original) + lost
    view = int(np.argmax(np.max(difference, axis=-1)))
    total = max(float(np.sum(mean(whole))), 1e-9)
    return Match(
        mean=mean(whole), mean_error=mean(converted) - mean(whole), worst=float(np.max(difference)),
        worst_theta_deg=float(np.degrees(np.arccos(COSINES[view]))),
        soft_light=float(np.sum(mean(difference))) / total, lost_light=float(np.sum(mean(lost))) / total,
        color_difference=float(ciede2000(*(lab_of_linear(mean(albedo)) for albedo in (whole, converted)))),
        without_film=without_film,
    )  # fmt: skip


def solve_near(albedos: Albedos, exact: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """As `solve` for albedos `exact` (views, 3), where brighter colors need not show brighter: the color that is nearest over the views.

    Its mean albedo is `exact`'s where such a color is close by.
    """

    def nearest(colors: np.ndarray) -> np.ndarray:
        off = [mean(np.abs(albedos(color) - exact)) for color in colors]
        return colors[np.argmin(off, axis=0), np.arange(3)]

    coarse = nearest(np.linspace(0.0, 1.0, _SCANNED)[:, None] * np.ones(3))
    color = nearest(np.clip(coarse + _BETWEEN[:, None], 0.0, 1.0))
    found, _ = solve(albedos, mean(exact), color)
    color = np.where(np.abs(found - color) < _CLOSE_BY, found, color)
    return color, albedos(color)


@dataclass(frozen=True, eq=False, repr=False)
class ColorMap:
    """(p0 + p1 c) / (1 + p2 c) per channel, each (3,), kept in 0..most."""

    p0: np.ndarray
    p1: np.ndarray
    p2: np.ndarray
    most: float = 1.0

    def __call__(self, color: np.ndarray) -> np.ndarray:
        """Colors (..., 3) as the other material wants them."""
        return np.clip((self.p0 + self.p1 * color) / (1.0 + self.p2 * color), 0.0, self.most)


def color_map(source: Albedos, target: Albedos, most: float = 1.0) -> ColorMap:
    """The map from base colors of `source` to those of `target` that have the same mean albedo."""
    forward, back = _through(source), _through(target)
    # as matrices, chains of such maps are products; the inverse of (a b; c d) is (d -b; -c a)
    a, b, c, d = back
    ia, ib, ic, id_ = d, -b, -c, a
    fa, fb, fc, fd = forward
    m = np.array([ia * fa + ib * fc, ia * fb + ib * fd, ic * fa + id_ * fc, ic * fb + id_ * fd])
    # a base that is not seen may have any color: it stays
    unseen = (np.abs(fa - fb * fc) < _UNSEEN) | (np.abs(a - b * c) < _UNSEEN) | (np.abs(m[3]) < _UNSEEN)
    m = np.where(unseen, np.array([1.0, 0.0, 0.0, 1.0])[:, None], m)
    return ColorMap(m[1] / m[3], m[0] / m[3], m[2] / m[3], most)


def _through(albedos: Albedos) -> tuple[np.ndarray, ...]:
    """(a, b, c, d), each (3,), of the mean albedo (a x + b) / (c x + d) through three colors."""
    x0, x1, x2 = _PROBES
    y0, y1, y2 = (mean(albedos(np.full(3, x))) for x in _PROBES)
    # with x0 = 0: (y - y0) / x = s / (1 + c x), from two more points
    s1, s2 = (y1 - y0) / (x1 - x0), (y2 - y0) / (x2 - x0)
    below = s2 * x2 - s1 * x1
    c = np.divide(s1 - s2, below, out=np.zeros(3), where=np.abs(below) > _UNSEEN)
    slope = s1 * (1.0 + c * x1)
    return slope + y0 * c, y0, c, np.ones(3)
