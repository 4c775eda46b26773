# SPDX-License-Identifier: GPL-3.0-or-later
"""Directions and conventions of the whole reference.

- Local frame: z is the surface normal. `wo` points to the viewer, `wi` to the light; both leave the surface.
- Arrays: directions are (..., 3) float64 and broadcast over the leading axes; colours have RGB as last axis.
- `f` is the BRDF in 1/sr and excludes the cosine. `albedo(wo)` is its cosine-weighted integral over wi.
- Angles are in radians; degrees appear only in user interfaces and in names that end in `_deg`.
- Layer 0 is the top. `eta` is relative, n_below / n_above; absolute indices are called `ior` or `n_...`.

What every model does with its input is `per_direction` and `sampled`: directions are unit vectors to within 1e-6, others are refused in one
line; a direction with a NaN gives NaN (and a sample that is not valid); no directions give an empty result; random numbers come
from a seed or a generator. NaN among a stack's values is refused (`OpticalStack.of`).
"""

from collections.abc import Callable
from functools import wraps
from inspect import signature

import numpy as np

from ..errors import LaminaError

UNIT_TOLERANCE = 1e-6
DOWN = np.array([0.0, 0.0, -1.0])
"""Where samples go that are not valid and have no direction of their own."""


def normalize(v: np.ndarray) -> np.ndarray:
    """Unit vectors along the last axis; a null vector stays null."""
    length = np.sqrt(dot(v, v))[..., None]
    return v / np.where(length > 0.0, length, 1.0)


def azimuth(w: np.ndarray) -> np.ndarray:
    """Angle (...) in radians of directions (..., 3) from x; 0 along z."""
    return np.arctan2(w[..., 1], w[..., 0])


def spherical(theta, phi) -> np.ndarray:
    """Unit directions (..., 3) from polar angle theta (from z) and azimuth phi, in radians."""
    theta, phi = np.broadcast_arrays(np.asarray(theta, float), np.asarray(phi, float))
    sin_theta = np.sin(theta)
    return np.stack([sin_theta * np.cos(phi), sin_theta * np.sin(phi), np.cos(theta)], axis=-1)


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Dot product (...) of vectors (..., 3). A sum over so short an axis takes eight times as long."""
    return a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2]


def reflect(w: np.ndarray, wm: np.ndarray) -> np.ndarray:
    """Mirror direction of w about the facet normal wm; both leave the surface."""
    return 2.0 * dot(w, wm)[..., None] * wm - w


def rotate_z(w: np.ndarray, angle) -> np.ndarray:
    """Directions w turned about z by angles (...) in radians, from x towards y."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * w[..., 0] - s * w[..., 1], s * w[..., 0] + c * w[..., 1], w[..., 2]], axis=-1)


def half_vector(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """Unit half vector; the normal where it is undefined (wi = -wo, both on the horizon)."""
    h = np.asarray(wi, float) + np.asarray(wo, float)
    length = np.sqrt(dot(h, h))[..., None]
    opposite = length <= 1e-12
    if not np.any(opposite):
        return h / length
    return np.where(opposite, np.array([0.0, 0.0, 1.0]), h / np.where(opposite, 1.0, length))


def per_direction(*trailing: Callable[..., tuple[int, ...]]) -> Callable:
    """Decorates a model's method of `wo`, or of `wo` and `wi`, (..., 3): it gets rows (n, 3), n > 0, of unit vectors without NaN.

    `trailing` gives, for each array that the method returns, the axes (of the model) that come after those of the directions.
    """

    def decorate(method: Callable) -> Callable:
        def call(self, named: dict, options: dict):
            shape, rows, known = _rows(named)
            if known is not None:
                rows = [w[known] for w in rows]
            if not len(rows[0]):
                results = [np.full((len(known), *axes(self)), np.nan) if known is not None else np.empty((0, *axes(self))) for axes in trailing]
            else:
                results = method(self, *rows, **options)
                results = [results] if len(trailing) == 1 else results
                results = [_spread(known, values) for values in results]
            results = [values.reshape(shape + values.shape[1:]) for values in results]
            return results[0] if len(trailing) == 1 else tuple(results)

        if "wi" in signature(method).parameters:
            return wraps(method)(lambda self, wo, wi, **options: call(self, {"wo": wo, "wi": wi}, options))
        return wraps(method)(lambda self, wo, **options: call(self, {"wo": wo}, options))

    return decorate


def color_axis(model) -> tuple[int, ...]:
    """The axis of channels, for `per_direction`."""
    return (model.channels,)


def no_axis(model) -> tuple[int, ...]:
    """None: one number for each direction, for `per_direction`."""
    return ()


def sampled(method: Callable) -> Callable:
    """Decorates a model's `sample(wo, rng)`: it gets rows as in `per_direction` and a generator, and returns wi (n, 3) and valid (n,)."""

    @wraps(method)
    def sample(self, wo, rng):
        rng = generator(rng)
        shape, (rows,), known = _rows({"wo": wo})
        if known is not None:
            rows = rows[known]
        wi, valid = method(self, rows, rng) if len(rows) else (np.empty((0, 3)), np.empty(0, bool))
        if known is not None:
            wi, some = _spread(known, wi), valid
            valid = np.zeros(len(known), bool)
            valid[known] = some
        return wi.reshape((*shape, 3)), valid.reshape(shape)

    return sample


def generator(rng) -> np.random.Generator:
    """The generator that a seed, a whole number from 0, stands for; a generator itself. Raises LaminaError for anything else."""
    if isinstance(rng, np.random.Generator):
        return rng
    if isinstance(rng, bool) or not isinstance(rng, (int, np.integer)) or rng < 0:
        raise LaminaError(f"rng is {rng!r}; choose a seed, a whole number from 0, or a numpy.random.Generator")
    return np.random.default_rng(int(rng))


def _rows(named: dict) -> tuple[tuple[int, ...], list[np.ndarray], np.ndarray | None]:
    """Leading shape and rows (n, 3) of directions that broadcast, and which have no NaN, (n,); None where all have none."""
    arrays = [_directions(name, w) for name, w in named.items()]
    try:
        shape = np.broadcast_shapes(*(w.shape for w, _ in arrays))
    except ValueError:
        raise LaminaError(f"directions {' and '.join(f'{n} {w.shape}' for n, (w, _) in zip(named, arrays))} do not broadcast") from None
    rows = [np.broadcast_to(w, shape).reshape(-1, 3) for w, _ in arrays]
    if all(known is None for _, known in arrays):
        return shape[:-1], rows, None
    return shape[:-1], rows, ~np.any(np.isnan(rows), axis=(0, 2))


def _directions(name: str, w) -> tuple[np.ndarray, np.ndarray | None]:
    try:
        w = np.asarray(w, float)
    except (TypeError, ValueError):
        raise LaminaError(f"{name} is {str(w)[:40]!r}; choose directions, (..., 3) numbers") from None
    if w.shape[-1:] != (3,):
        raise LaminaError(f"{name} has shape {w.shape}; directions have three numbers on the last axis")
    with np.errstate(over="ignore"):
        length = np.sqrt(np.einsum("...i,...i->...", w, w))
    off = np.abs(length - 1.0) > UNIT_TOLERANCE
    if np.any(off):
        raise LaminaError(
            f"{name} has a direction of length {float(length[off].flat[0]):.7g}; choose unit vectors, to within {UNIT_TOLERANCE:g} (frame.normalize)"
        )
    unknown = np.isnan(length)
    return w, ~unknown if np.any(unknown) else None


def _spread(known: np.ndarray | None, values: np.ndarray) -> np.ndarray:
    """Rows at those that are known, NaN elsewhere."""
    if known is None:
        return values
    out = np.full((len(known), *values.shape[1:]), np.nan)
    out[known] = values
    return out
