# SPDX-License-Identifier: GPL-3.0-or-later
"""Analytic BRDF models fitted to the same data by the same solver and metric, as in Ngan et al. 2005.

Each is a function of a parameter vector; no stack is behind them. Fresnel is Schlick94's, colors are per channel.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..optics.frame import dot, half_vector
from ..optics.microfacet import BECKMANN, GGX, distribution, masking_g2, masking_v_cavity
from .metric import Metric, rms
from .solve import least_squares

_STARTS, _GUESSES, _STEPS, _DIFFERENCE = 10, 300, 150, 1e-6


@dataclass(frozen=True)
class Term:
    """One named parameter: `size` is "color" (one per channel) or "one". `usual` bounds the guesses."""

    name: str
    size: str
    low: float
    high: float
    usual: tuple[float, float]


@dataclass(frozen=True, eq=False, repr=False)
class BaselineModel:
    """`f(values, wi, wo)`, (n, c), of values by name, each (c,) or a number."""

    name: str
    label: str
    terms: tuple[Term, ...]
    f: Callable[[dict, np.ndarray, np.ndarray], np.ndarray]

    def count(self, channels: int) -> int:
        """Length p of the parameter vector for data of so many channels."""
        return sum(channels if t.size == "color" else 1 for t in self.terms)

    def bounds(self, channels: int) -> tuple[np.ndarray, np.ndarray]:
        """(low, high) of the parameter vector, each (p,)."""
        repeat = [channels if t.size == "color" else 1 for t in self.terms]
        return np.repeat([t.low for t in self.terms], repeat), np.repeat([t.high for t in self.terms], repeat)

    def values(self, x: np.ndarray, channels: int) -> dict:
        """Values by name, each (channels,) or a number, of a parameter vector (p,)."""
        found, at = {}, 0
        for t in self.terms:
            size = channels if t.size == "color" else 1
            found[t.name] = x[at : at + size] if t.size == "color" else x[at]
            at += size
        return found


@dataclass(frozen=True, eq=False, repr=False)
class BaselineFit:
    """A model at its best parameter vector `x` (p,); `error` is the metric's RMS residual."""

    model: BaselineModel
    x: np.ndarray
    channels: int
    error: float

    @property
    def count(self) -> int:
        """Number of parameters."""
        return len(self.x)

    def f(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        """f (n, channels) in 1/sr of the fitted model for directions (n, 3)."""
        return self.model.f(self.model.values(self.x, self.channels), wi, wo)


def fit_baseline(model: BaselineModel, metric: Metric, seed: int = 0) -> BaselineFit:
    """The best of several bounded fits to the metric's data."""
    m, channels = metric.measurement, metric.measurement.channels
    low, high = model.bounds(channels)
    rng = np.random.default_rng(seed)

    def residual(u):
        return metric.residual(model.f(model.values(low + (high - low) * u, channels), m.wi, m.wo)).ravel()

    def jacobian(u, r):
        columns = []
        for i in range(len(u)):
            there, step = u.copy(), -_DIFFERENCE if u[i] > 0.5 else _DIFFERENCE
            there[i] += step
            columns.append((residual(there) - r) / step)
        return np.stack(columns, axis=1)

    guesses = [(_guess(model, channels, m.f, rng) - low) / (high - low) for _ in range(_GUESSES)]
    order = np.argsort([rms(residual(u)) for u in guesses])[:_STARTS]
    zero, one = np.zeros(len(low)), np.ones(len(low))
    found = min((least_squares(residual, jacobian, guesses[i], zero, one, _STEPS, 1e-7) for i in order), key=lambda s: s.cost)
    return BaselineFit(model, low + (high - low) * found.x, channels, rms(found.residual))


def _guess(model: BaselineModel, channels: int, f: np.ndarray, rng) -> np.ndarray:
    parts = []
    for t in model.terms:
        value = t.usual[0] + (t.usual[1] - t.usual[0]) * rng.random()
        if t.name == "diffuse":
            parts.append(np.clip(np.pi * np.median(f, axis=0) * value, t.low, t.high))
        else:
            parts.append(np.full(channels if t.size == "color" else 1, value))
    return np.concatenate(parts)


_DIFFUSE = Term("diffuse", "color", 0.0, 1.0, (0.5, 1.2))


def _specular(suffix: str = "", low: float = 0.05, high: float = 0.6) -> tuple[Term, ...]:
    return (Term(f"f0{suffix}", "color", 0.0, 1.0, (0.02, 0.6)), Term(f"alpha{suffix}", "one", 0.005, 1.0, (low, high)))


def _schlick(f0, cos):
    return f0 + (1.0 - f0) * ((1.0 - cos) ** 5)[:, None]


def _lobe(v, suffix, wi, wo, kind, masking):
    wh = half_vector(wi, wo)
    cos_h = np.clip(dot(wi, wh), 1e-6, 1.0)
    d = distribution(wh[:, 2], v[f"alpha{suffix}"], kind) * masking(wi, wo, wh, cos_h, v[f"alpha{suffix}"])
    return _schlick(v[f"f0{suffix}"], cos_h) * (d / (4.0 * np.maximum(wi[:, 2] * wo[:, 2], 1e-9)))[:, None]


def _smith(wi, wo, wh, cos_h, alpha):
    return masking_g2(wi[:, 2], wo[:, 2], alpha, GGX)


def _cavities(wi, wo, wh, cos_h, alpha):
    return masking_v_cavity(wi[:, 2], wo[:, 2], wh[:, 2], cos_h)


def _ggx(v, wi, wo):
    return v["diffuse"] / np.pi + _lobe(v, "", wi, wo, GGX, _smith)


def _cook_torrance(v, wi, wo):
    return v["diffuse"] / np.pi + sum(_lobe(v, s, wi, wo, BECKMANN, _cavities) for s in ("_1", "_2"))


def _lafortune(v, wi, wo):
    across = (wi[:, 0] * wo[:, 0] + wi[:, 1] * wo[:, 1])[:, None]
    along = (wi[:, 2] * wo[:, 2])[:, None]
    total = v["diffuse"] / np.pi
    for s in ("_1", "_2", "_3"):
        total = total + np.maximum(v[f"c_xy{s}"] * across + v[f"c_z{s}"] * along, 0.0) ** v[f"n{s}"]
    return total


def _ashikhmin_shirley(v, wi, wo):
    wh = half_vector(wi, wo)
    cos_h = np.clip(dot(wi, wh), 1e-6, 1.0)
    n = 2.0 / v["alpha"] ** 2 - 2.0
    lobe = (n + 1.0) / (8.0 * np.pi) * np.clip(wh[:, 2], 1e-9, 1.0) ** n / (cos_h * np.maximum(wi[:, 2], wo[:, 2]))
    fade = (1.0 - (1.0 - 0.5 * wi[:, 2]) ** 5) * (1.0 - (1.0 - 0.5 * wo[:, 2]) ** 5)
    return _schlick(v["f0"], cos_h) * lobe[:, None] + 28.0 / (23.0 * np.pi) * v["diffuse"] * (1.0 - v["f0"]) * fade[:, None]


def _ward(v, wi, wo):
    wh = half_vector(wi, wo)
    tan2 = 1.0 / np.maximum(np.square(wh[:, 2]), 1e-9) - 1.0
    alpha2 = v["alpha"] ** 2
    lobe = np.exp(-tan2 / alpha2) / (4.0 * np.pi * alpha2 * np.sqrt(np.maximum(wi[:, 2] * wo[:, 2], 1e-9)))
    return v["diffuse"] / np.pi + v["f0"] * lobe[:, None]


def _lafortune_terms() -> tuple[Term, ...]:
    terms = [_DIFFUSE]
    for s, usual in (("_1", (-1.1, -0.8)), ("_2", (-1.1, 1.0)), ("_3", (0.3, 1.0))):
        terms += [Term(f"c_xy{s}", "color", -1.3, 1.3, usual), Term(f"c_z{s}", "color", -1.3, 1.3, (0.0, 1.0)), Term(f"n{s}", "color", 0.5, 500.0, (1.0, 60.0))]
    return tuple(terms)


BASELINE_MODELS = (
    BaselineModel("ggx_lambert", "GGX and Lambert", (_DIFFUSE, *_specular()), _ggx),
    BaselineModel("ward", "Ward 1992", (_DIFFUSE, *_specular()), _ward),
    BaselineModel("ashikhmin_shirley", "Ashikhmin and Shirley 2000", (_DIFFUSE, *_specular()), _ashikhmin_shirley),
    BaselineModel("cook_torrance", "Cook and Torrance 1982, two lobes", (_DIFFUSE, *_specular("_1", 0.03, 0.2), *_specular("_2", 0.2, 0.8)), _cook_torrance),
    BaselineModel("lafortune", "Lafortune et al. 1997, three lobes", _lafortune_terms(), _lafortune),
)
