# SPDX-License-Identifier: GPL-3.0-or-later
"""Scattering by one rough interface: once, as most renderers do, or until the light leaves it.

    scattered = scatter_dielectric(w, eta, alpha, distribution, rng, surface="multiple")
    scattered.direction  (n, 3)  direction of travel after the interface; z < 0 means transmitted
    scattered.weight     (n,)    energy carried: 1 for "multiple", which loses none; "single" loses some

`w` (n, 3) points back to where the light came from, on the upper side of the interface (w_z > 0), and
eta = n_beyond / n_here. Light from below an interface is the same call in the negated frame: w = -w_below,
1 / eta, and negate the direction again.

- "multiple": the random walk on a Smith microsurface of Heitz16. The result does not depend on the distribution
  of heights, so the walk carries log(C1(height)), the logarithm of the share of surface below it, alone.
- "single": Walter07 with separable masking G1 G1; what a facet sends to the wrong side is lost.

Both need alpha > 0 and eta != 1; an alpha is a number, or (alpha_x, alpha_y). `target` asks besides for the energy per solid angle, BSDF times cosine, that
each w sends to one direction: exact for "single", an unbiased estimate for "multiple".
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..errors import LaminaError
from .directions import components, take, vectors
from .frame import dot
from .fresnel import cos_theta_t, fresnel_dielectric
from .microfacet import facet_distribution
from .sampling import projected_area, sample_visible_normals
from .thin_film import FilmInterface

SURFACES = ("multiple", "single")


@dataclass(frozen=True, eq=False, repr=False)
class Scattered:
    """What `scatter_dielectric` and `scatter_conductor` return."""

    direction: np.ndarray
    """(n, 3), in the frame of w."""
    weight: np.ndarray
    """(n,), for conductors (n, channels), for films (n, 3)."""
    toward: np.ndarray | None = None
    """BSDF times cosine in 1/sr at `target`, shaped like `weight`; None without a target."""


def scatter_dielectric(
    w: np.ndarray,
    eta: float,
    alpha,
    distribution: str,
    rng: np.random.Generator,
    surface: str = "multiple",
    target: np.ndarray | None = None,
    film: FilmInterface | None = None,
    from_above: bool = True,
    both: bool = False,
) -> Scattered:
    """Reflect or refract light that comes from w (n, 3), w_z > 0; see the module's docstring.

    `target` (n, 3) must lie on one side of the interface for all n. With a `film`, met from above or from below, weights
    are (n, 3): a facet reflects with the channels' mean as chance. With `both`, which knows neither, results have 2 n rows: the first
    facet of each w reflects its share for certain, and in the second half of the rows refracts the rest. Raises LaminaError on an unknown `surface`.
    """
    _check(surface)
    if surface == "single":
        return _dielectric_once(w, eta, alpha, distribution, rng, target, film, from_above, both)
    return _dielectric_walk(w, eta, alpha, distribution, rng, target, film, from_above, both)


def scatter_conductor(
    w: np.ndarray,
    fresnel: Callable[[np.ndarray], np.ndarray],
    alpha,
    distribution: str,
    rng: np.random.Generator,
    surface: str = "multiple",
    target: np.ndarray | None = None,
) -> Scattered:
    """Reflect light that comes from w (n, 3), w_z > 0; `fresnel` maps cosines (n,) to reflectances (n, channels).

    Raises LaminaError on an unknown `surface`.
    """
    _check(surface)
    if surface == "single":
        return _conductor_once(w, fresnel, alpha, distribution, rng, target)
    return _conductor_walk(w, fresnel, alpha, distribution, rng, target)


def scattering_density(
    w: np.ndarray, o: np.ndarray, eta: float | None, alpha, distribution: str, film: FilmInterface | None = None, from_above: bool = True
) -> np.ndarray:
    """Density (n,) in 1/sr of the direction o after one scattering event, before masking; eta None for a conductor.

    It is the exact density of "single" samples, lost ones included. All o lie on one side.
    """
    return _mean(_scattered(w, o, eta, alpha, distribution, film, from_above))


def _mean(values: np.ndarray) -> np.ndarray:
    return values if values.ndim == 1 else values.mean(axis=1)


def _scattered(w, o, eta, alpha, distribution, film=None, from_above=True) -> np.ndarray:
    """The density of `scattering_density`, with a film per channel, (n, 3)."""
    area = projected_area(w, alpha, distribution)
    if eta is None:
        return _facets_reflecting(w, o, area, alpha, distribution)[1]
    if o[0, 2] < 0.0:
        return _refracted(w, o, area, eta, alpha, distribution, film, from_above)
    return _reflected(w, o, area, eta, alpha, distribution, film, from_above)


def masking(o: np.ndarray, alpha, distribution: str) -> np.ndarray:
    """Smith G1 (n,) of directions on either side, from the exact projected area."""
    outward = vectors(o[:, 0], o[:, 1], np.abs(o[:, 2]))
    return outward[:, 2] / projected_area(outward, alpha, distribution)


def _check(surface: str) -> None:
    if surface not in SURFACES:
        raise LaminaError(f"unknown surface {surface!r}; choose {', '.join(SURFACES)}")


def fresnel_and_refraction(cos: np.ndarray, eta) -> tuple[np.ndarray, np.ndarray]:
    """Reflectance (n,) at cos > 0 and cosine (n,) beyond the interface, 0 under total internal reflection.

    The formula of `fresnel_dielectric` for a walk's inner loop, which knows that eta != 1 and wants both.
    """
    cos_t = np.sqrt(np.maximum(1.0 - (1.0 - cos * cos) / (eta * eta), 0.0))
    near, far = eta * cos_t, eta * cos
    r_s = (cos - near) / (cos + near)
    r_p = (far - cos_t) / (far + cos_t)
    # cos_t = 0 makes both quotients 1: total reflection needs no case of its own
    return 0.5 * (r_s * r_s + r_p * r_p), cos_t


def _bend(w, wm, cos, cos_t, eta, reflected) -> np.ndarray:
    """Where light from w goes: the mirror direction about wm, or the refracted one."""
    along = np.where(reflected, -1.0, -1.0 / eta)
    normal = np.where(reflected, 2.0 * cos, cos / eta - cos_t)
    return vectors(*(along * a + normal * m for a, m in zip(components(w), components(wm))))


def _cosine(w, wm) -> np.ndarray:
    return w[:, 0] * wm[:, 0] + w[:, 1] * wm[:, 1] + w[:, 2] * wm[:, 2]


def _facets_reflecting(w, o, area, alpha, distribution):
    """Facet cosine and density of mirror directions, D_w(wh) / (4 cos), for every reflecting facet (Heitz16)."""
    h = w + o
    length = np.sqrt(np.maximum(dot(h, h), 1e-30))
    return 0.5 * length, 0.25 * facet_distribution(h / length[:, None], alpha, distribution) / area


def _reflected(w, o, area, eta, alpha, distribution, film=None, from_above=True) -> np.ndarray:
    cos, spread = _facets_reflecting(w, o, area, alpha, distribution)
    if film is not None:
        return film.reflectance(cos, cos_theta_t(cos, eta), from_above) * spread[:, None]
    return fresnel_dielectric(cos, eta) * spread


def _refracted(w, o, area, eta, alpha, distribution, film=None, from_above=True) -> np.ndarray:
    """Density of refracted directions with the Jacobian of Walter07, eq. 17."""
    h = -(w + eta * o)
    length2 = np.maximum(dot(h, h), 1e-30)
    h = h / (np.sqrt(length2) * np.where(h[:, 2] < 0.0, -1.0, 1.0))[:, None]
    cos, cos_o = dot(w, h), -dot(o, h)
    facing = (cos > 0.0) & (cos_o > 0.0)
    visible = np.where(facing, cos * cos_o, 0.0) * facet_distribution(h, alpha, distribution) / area
    density = visible * refraction_jacobian(eta, length2)
    if film is not None:
        return (1.0 - film.reflectance(cos, cos_theta_t(cos, eta), from_above)) * density[:, None]
    return (1.0 - fresnel_dielectric(cos, eta)) * density


def split(reflectance: np.ndarray, *columns: np.ndarray) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
    """(reflected, weights, columns), each of 2 n rows: all n reflect their share, then all n let the rest pass."""
    reflected = np.repeat([True, False], len(reflectance))
    return reflected, np.concatenate([reflectance, 1.0 - reflectance]), [np.concatenate([c.T, c.T], axis=-1).T for c in columns]


def chosen(reflectance, cos, cos_t, film, from_above, rng):
    """Which facets reflect, and the weights (n, 3) of that choice; None without a film, where all are 1."""
    if film is None:
        return rng.random(len(cos)) < reflectance, None
    channels = film.reflectance(cos, cos_t, from_above)
    chance = channels.mean(axis=1)
    reflected = rng.random(len(cos)) < chance
    share = np.where(reflected, chance, 1.0 - chance)[:, None]
    return reflected, np.where(reflected[:, None], channels, 1.0 - channels) / np.maximum(share, 1e-300)


def refraction_jacobian(eta: float, length2: np.ndarray) -> np.ndarray:
    """d(wh) / d(o) over the cosine of o and wh: eta^2 / |w + eta o|^2 (Walter07, eq. 17)."""
    return eta * eta / length2


def _dielectric_once(w, eta, alpha, distribution, rng, target, film, from_above, both) -> Scattered:
    wm = sample_visible_normals(w, alpha, distribution, rng)
    cos = _cosine(w, wm)
    reflectance, cos_t = fresnel_and_refraction(cos, eta)
    if both:
        reflected, share, (w, wm, cos, cos_t) = split(reflectance, w, wm, cos, cos_t)
    else:
        reflected, choice = chosen(reflectance, cos, cos_t, film, from_above, rng)
    o = _bend(w, wm, cos, cos_t, eta, reflected)
    weight = np.where((o[:, 2] > 0.0) == reflected, masking(o, alpha, distribution), 0.0)
    if both:
        weight = weight * share
    elif choice is not None:
        weight = weight[:, None] * choice
    toward = None
    if target is not None:
        toward = (_scattered(w, target, eta, alpha, distribution, film, from_above).T * masking(target, alpha, distribution)).T
    return Scattered(o, weight, toward)


def _conductor_once(w, fresnel, alpha, distribution, rng, target) -> Scattered:
    wm = sample_visible_normals(w, alpha, distribution, rng)
    cos = _cosine(w, wm)
    o = _bend(w, wm, cos, 0.0, 1.0, True)
    weight = np.where(o[:, 2] > 0.0, masking(o, alpha, distribution), 0.0)[:, None] * fresnel(cos)
    toward = None
    if target is not None:
        cos, spread = _facets_reflecting(w, target, projected_area(w, alpha, distribution), alpha, distribution)
        toward = (spread * masking(target, alpha, distribution))[:, None] * fresnel(cos)
    return Scattered(o, weight, toward)


def _dielectric_walk(w, eta, alpha, distribution, rng, target, film, from_above, both) -> Scattered:
    """Random walk of Heitz16 in the frame of the side where the ray is: crossing a facet negates it."""
    n = 2 * len(w) if both else len(w)
    weight = np.broadcast_to(1.0, n)
    out = np.empty((3, n)).T
    ray, outside = np.arange(len(w)), np.ones(len(w), bool)
    log_below = np.zeros(len(w))
    eta_here = eta
    throughput = None if film is None else np.ones((n, 3))
    estimate = None if target is None else _Estimate(target, alpha, distribution, (n,) if film is None else (n, 3))
    while True:
        area = projected_area(w, alpha, distribution)
        log_below = _advance(log_below, w, area, rng)
        leaves = log_below >= 0.0
        gone = np.flatnonzero(leaves)
        if len(gone):
            out[ray[gone]] = take(w, gone) * np.where(outside[gone], -1.0, 1.0)[:, None]
            if len(gone) == len(ray):
                break
            stay = np.flatnonzero(~leaves)
            w, ray, outside = take(w, stay), ray[stay], outside[stay]
            log_below, area = log_below[stay], area[stay]
            eta_here = np.where(outside, eta, 1.0 / eta)
        if estimate is not None:
            estimate.add_dielectric(w, area, ray, outside, log_below, eta, throughput, film, from_above)
        wm = sample_visible_normals(w, alpha, distribution, rng)
        cos = _cosine(w, wm)
        reflectance, cos_t = fresnel_and_refraction(cos, eta_here)
        if both:
            reflected, weight, (w, wm, cos, cos_t, log_below, outside) = split(reflectance, w, wm, cos, cos_t, log_below, outside)
            ray, both = np.arange(n), False
        else:
            reflected, choice = chosen(reflectance, cos, cos_t, film, outside == from_above, rng)
        if throughput is not None:
            throughput[ray] *= choice
        o = _bend(w, wm, cos, cos_t, eta_here, reflected)
        # Light goes along o; w of the next event is -o, and crossing negates it once more.
        w = (o.T * np.where(reflected, -1.0, 1.0)).T
        log_below = np.where(reflected, log_below, _log_above(log_below))
        outside = outside == reflected
        eta_here = np.where(outside, eta, 1.0 / eta)
    return Scattered(out, weight if throughput is None else throughput, None if estimate is None else estimate.total)


def _conductor_walk(w, fresnel, alpha, distribution, rng, target) -> Scattered:
    n, channels = len(w), fresnel(np.ones(1)).shape[-1]
    out, weight = np.empty((3, n)).T, np.empty((channels, n)).T
    ray, throughput, log_below = np.arange(n), np.ones((channels, n)).T, np.zeros(n)
    estimate = None if target is None else _Estimate(target, alpha, distribution, (n, channels))
    while True:
        area = projected_area(w, alpha, distribution)
        log_below = _advance(log_below, w, area, rng)
        leaves = log_below >= 0.0
        gone = np.flatnonzero(leaves)
        if len(gone):
            out[ray[gone]] = -take(w, gone)
            weight[ray[gone]] = throughput[gone]
            if len(gone) == len(ray):
                break
            stay = np.flatnonzero(~leaves)
            w, throughput = take(w, stay), take(throughput, stay)
            ray, log_below, area = ray[stay], log_below[stay], area[stay]
        if estimate is not None:
            estimate.add_conductor(w, area, ray, log_below, throughput, fresnel)
        wm = sample_visible_normals(w, alpha, distribution, rng)
        cos = _cosine(w, wm)
        throughput = throughput * fresnel(cos)
        w = -_bend(w, wm, cos, 0.0, 1.0, True)
    return Scattered(out, weight, None if estimate is None else estimate.total)


def _advance(log_below, w, area, rng) -> np.ndarray:
    """log(C1) where a ray that travels along -w meets the surface next (Heitz16); >= 0 if it leaves."""
    with np.errstate(divide="ignore", over="ignore"):  # straight up the area is 0: it leaves
        return log_below - rng.standard_exponential(len(w)) * (w[:, 2] / area)


def _log_above(log_below: np.ndarray) -> np.ndarray:
    """log(1 - C) of log(C): the height as seen from the other side of the surface."""
    with np.errstate(divide="ignore"):
        return np.log(-np.expm1(np.minimum(log_below, 0.0)))


class _Estimate:
    """Next event estimation inside the microsurface: energy that each facet sends out to the target (Heitz16)."""

    def __init__(self, target: np.ndarray, alpha, distribution: str, shape: tuple[int, ...]):
        self.target, self.alpha, self.distribution = target, alpha, distribution
        self.is_above = bool(target[0, 2] > 0.0)
        self.lambda_target = 1.0 / masking(target, alpha, distribution) - 1.0
        self.total = np.zeros(shape)

    def add_dielectric(self, w, area, ray, outside, log_below, eta, throughput, film, from_above) -> None:
        for is_outside in (True, False):
            index = np.flatnonzero(outside == is_outside)
            if not len(index):
                continue
            to = take(self.target, ray[index]) * (1.0 if is_outside else -1.0)
            eta_here = eta if is_outside else 1.0 / eta
            same_side = is_outside == self.is_above
            spread = _reflected if same_side else _refracted
            height = log_below[index] if same_side else _log_above(log_below[index])
            value = spread(take(w, index), to, area[index], eta_here, self.alpha, self.distribution, film, is_outside == from_above)
            if throughput is not None:
                value = value * throughput[ray[index]]
            self.total[ray[index]] += (value.T * self._escape(ray[index], height)).T

    def add_conductor(self, w, area, ray, log_below, throughput, fresnel) -> None:
        cos, spread = _facets_reflecting(w, take(self.target, ray), area, self.alpha, self.distribution)
        value = throughput * fresnel(cos) * (spread * self._escape(ray, log_below))[:, None]
        self.total[ray] += value

    def _escape(self, ray, log_height) -> np.ndarray:
        """Probability C1^Lambda of leaving towards the target without meeting the surface again (Heitz16)."""
        return np.exp(log_height * np.maximum(self.lambda_target[ray], 1e-300))
