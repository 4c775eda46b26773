# SPDX-License-Identifier: GPL-3.0-or-later
"""Is f of `adding` right where view and light both graze the surface? By direction, with the walks of `position_free` as judge, as many as their error
asks for; of one surface alone, where these miss rare and bright facets and do not know it, those of `two_ended`.

Errors are relative to f itself: beside the peak of such a view, a hundred times as bright, they would not show.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..reference_py.material import presets
from ..reference_py.material.stack import Stack
from ..reference_py.optics.frame import spherical
from ..reference_py.optics.optical_stack import OpticalStack
from ..reference_py.registry import make_model
from .two_ended import metal_f, reflected_f

THETA_O_DEG, THETA_I_DEG, AZIMUTHS_DEG = (76.0, 83.0, 86.0), (75.0, 79.0, 85.0), (60.0, 150.0, 177.0)
TWO_ENDED_WALKS = 1 << 21
SEEN = 1e-3
"""A direction counts if its f cos is above this share of the mean over the hemisphere."""
STATED, SIGMAS = 0.035, 4.0
# Rounds of so many walks, until the standard error of what is seen is a quarter of what is stated.
_ROUND, _MOST_ROUNDS, _NOISE = 1 << 19, 32, 0.25 * STATED


def _layer(roughness: float, **values) -> dict:
    return {"kind": "dielectric", "ior": 1.5, "roughness": roughness, **values}


_SILVER, _BLACK = {"kind": "conductor", "metal": "silver", "roughness": 0.3}, {"kind": "lambert", "color": [0.0] * 3}
STACKS = {
    "silver": Stack.from_dict({"layers": [], "base": _SILVER}),
    "coated_silver": Stack.from_dict({"layers": [_layer(0.3)], "base": _SILVER}),
    "silver_under_a_smooth_coat": Stack.from_dict({"layers": [_layer(0.0)], "base": _SILVER}),
    "black_plastic": Stack.from_dict({"layers": [_layer(0.3)], "base": _BLACK}),
    "rough_black_plastic": Stack.from_dict({"layers": [_layer(0.6)], "base": _BLACK}),
    "clean_copper": presets.load("clean_copper"),
    "frosted_paint": presets.load("frosted_paint"),
}

# Of one surface alone.
_ALONE = ("silver", "black_plastic", "rough_black_plastic")


@dataclass(frozen=True)
class Direction:
    """f (3,) by both truths in one direction, and whether anybody sees it."""

    stack: str
    degrees: tuple[float, float, float]
    adding: np.ndarray
    walked: np.ndarray
    stderr: np.ndarray
    is_seen: bool

    def error(self, f: np.ndarray) -> float:
        """The largest error of f (3,), relative and signed."""
        errors = f / np.maximum(self.walked, 1e-12) - 1.0
        return float(errors[np.argmax(np.abs(errors))])

    @property
    def noise(self) -> float:
        """Relative standard error of the walks, worst channel."""
        return float(np.max(self.stderr / np.maximum(self.walked, 1e-12)))


def directions() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Degrees (P, 3) of view, light and azimuth, and (wo, wi), each (P, 3)."""
    degrees = np.stack(np.meshgrid(THETA_O_DEG, THETA_I_DEG, AZIMUTHS_DEG, indexing="ij"), axis=-1).reshape(-1, 3)
    theta_o, theta_i, azimuth = np.radians(degrees).T
    return degrees, spherical(theta_o, 0.0), spherical(theta_i, azimuth)


def measured(name: str, seed: int = 1) -> Iterator[Direction]:
    """Every direction of a stack of `STACKS`."""
    degrees, wo, wi = directions()
    adding = make_model("adding", STACKS[name])
    f, mean = adding.f(wo, wi), adding.albedo(wo) / (2.0 * np.pi)
    walked, stderr = _two_ended(STACKS[name], wo, wi, seed) if name in _ALONE else _walked(STACKS[name], wo, wi, seed, SEEN * mean / wi[:, 2:])
    seen = np.all(walked * wi[:, 2:] > SEEN * mean, axis=1)
    for row in zip(degrees.tolist(), f, walked, stderr, seen.tolist()):
        yield Direction(name, tuple(row[0]), *row[1:])


def _walked(stack: Stack, wo, wi, seed: int, least: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """f (P, 3) and its standard error; what is below `least` (P, 3) is not seen."""
    model, rng = make_model("position_free", stack, walks=_ROUND), np.random.default_rng(seed)
    total, squares, rounds = np.zeros(least.shape), np.zeros(least.shape), np.zeros((len(wo), 1))
    open_ = np.arange(len(wo))
    while len(open_) and np.max(rounds) < _MOST_ROUNDS:
        f, stderr = model.f_stderr(wo[open_], wi[open_], rng=rng)
        total[open_] += f
        squares[open_] += np.square(stderr)
        rounds[open_] += 1
        noisy = np.any(np.sqrt(squares) > _NOISE * np.maximum(total, rounds * least), axis=1)
        open_ = open_[noisy[open_]]
    return total / rounds, np.sqrt(squares) / rounds


def _two_ended(stack: Stack, wo, wi, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """The same of one surface."""
    optics, rng = OpticalStack.of(stack), np.random.default_rng(seed)
    if not optics.interfaces:
        lobe = (optics.base.reflectance, optics.base.facets.alpha, optics.base.facets.distribution)
        return tuple(np.array(part) for part in zip(*(metal_f(*lobe, *pair, TWO_ENDED_WALKS, rng, _NOISE) for pair in zip(wo, wi))))
    interface = optics.interfaces[0]
    pairs = [reflected_f(interface.eta, interface.alpha, interface.distribution, *pair, TWO_ENDED_WALKS, rng, _NOISE) for pair in zip(wo, wi)]
    f, stderr = (np.repeat(np.array(part)[:, None], 3, axis=1) for part in zip(*pairs))
    return f, stderr
