# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes materials in the RGL database's adaptive parametrisation (Dupuy and Jakob 2018), which `fit.readers.rgl` describes and reads.

Facet normals wm are placed by u = sqrt(2 theta_m / pi), v = (phi_m + pi) / (2 pi), and there by the cumulative distribution of the
visible normals of a light: rows t along v first, then s along u. The distribution of normals D is that which the retroreflection of a
surface of facets would tell, D(w) ~ 4 sigma(w) f(w, w) cos: so it has the narrow and the wide parts of every layer. Renderers sample by it
and by `luminance`; a value is f cos(theta_o) 4 sigma(wi) / D(wm), which is smooth where f is not.

fields: description, phi_i, theta_i, ndf (v, u), sigma (v, u), vndf (phi_i, theta_i, v, u), luminance (phi_i, theta_i, t, s),
jacobian 1, and the values: rgb (phi_i, theta_i, 3, t, s), or spectra (phi_i, theta_i, wavelengths, t, s) with wavelengths, which pbrt wants.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...atomic import replacing
from ...fit.readers.rgl import bilinear
from ...optics.colour import upsampled, xyz_to_rgb
from ...optics.frame import azimuth, reflect, spherical
from .tensor_file import tensor_bytes
from .truth import Progress, Truth, is_isotropic, require_finite

FORMAT = "RGL's table"
_STEEPEST_DEG = 89.5
# Of the density of normals, against its peak: nothing is out of reach.
_LEAST = 1e-6
_POWER_STEPS = 12
# Azimuths of the normals that an isotropic surface's area is summed over.
_AZIMUTHS = 65
# Walks are so many times as many for the retroreflection, of which there is little to compute.
_RETRO = 16
_NEAR_HORIZON = 1e-4


@dataclass(frozen=True)
class Sampling:
    """Counts of nodes: azimuths and angles of the light, normals (v, u), and places along t and s, which readers want alike."""

    phi_i: int
    theta_i: int
    normals: tuple[int, int]
    places: int


ISOTROPIC = Sampling(1, 24, (33, 256), 65)
WALKED = Sampling(1, 24, (33, 256), 41)
ANISOTROPIC = Sampling(25, 12, (65, 96), 28)


def require_holdable(stack) -> None:
    """Raise LaminaError for what such a table cannot hold."""
    require_finite(stack, FORMAT)


def fields(truth: Truth, description: str, progress: Progress | None = None, spectral: bool = False) -> dict[str, np.ndarray]:
    """The fields of a file by name."""
    isotropic = is_isotropic(truth.stack)
    sampling = (WALKED if truth.stochastic else ISOTROPIC) if isotropic else ANISOTROPIC
    phi_i = np.zeros(1) if isotropic else np.linspace(-np.pi, np.pi, sampling.phi_i)
    theta_i = np.radians(_STEEPEST_DEG) * np.sin(np.linspace(0.0, 0.5 * np.pi, sampling.theta_i))
    wi = spherical(theta_i, phi_i[:, None])
    normals = _Normals.of(truth, sampling.normals, isotropic)
    visible = normals.visible(wi, sampling.normals)
    values = _values(truth, normals, wi, _placed(visible, sampling.places), isotropic, progress)
    stored = {
        "phi_i": phi_i, "theta_i": theta_i, "ndf": normals.ndf, "sigma": normals.sigma, "vndf": visible,
        "luminance": _luminance(values), **_channels(values, spectral),
    }  # fmt: skip
    return {
        "description": np.frombuffer(description.encode(), np.uint8),
        "jacobian": np.ones(1, np.uint8),
        **{name: np.asarray(array, np.float32) for name, array in stored.items()},
    }


def _channels(values: np.ndarray, spectral: bool) -> dict[str, np.ndarray]:
    if not spectral:
        return {"rgb": np.moveaxis(values, -1, 2)}
    wavelength_nm, spectra = upsampled(values)
    return {"wavelengths": wavelength_nm, "spectra": np.moveaxis(spectra, -1, 2)}


def write(stored: dict[str, np.ndarray], path: Path) -> None:
    """Write `fields`, whole or not at all. Raises LaminaError."""
    with replacing(path) as temporary:
        temporary.write_bytes(tensor_bytes(stored))


@dataclass(frozen=True, eq=False, repr=False)
class _Normals:
    """`ndf` and `sigma` (v, u); two rows that are alike where they know no azimuth."""

    ndf: np.ndarray
    sigma: np.ndarray

    @classmethod
    def of(cls, truth: Truth, counts: tuple[int, int], isotropic: bool) -> "_Normals":
        """Those of the retroreflection: D = 4 sigma f cos is solved with sigma, the projected area of D, by iteration."""
        rows, columns = counts
        # half a turn is the whole surface: an ellipse is one of two axes
        half = spherical(*_angles(np.linspace(0.0, 1.0, columns), (np.zeros(1) if isotropic else np.linspace(0.0, 0.5, rows // 2 + 1))[:, None] + 0.5))
        flat = half.reshape(-1, 3)
        seen = np.repeat(
            np.where(flat[:, 2:] < _NEAR_HORIZON, spherical(np.radians(_STEEPEST_DEG), azimuth(flat)), flat), _RETRO if truth.stochastic else 1, axis=0
        )
        f = _luminance(truth.f(seen, seen)).reshape(len(flat), -1).mean(axis=1)
        retro = 4.0 * f * flat[:, 2]
        area = _projected_areas(half, _AZIMUTHS if isotropic else rows)
        ndf, sigma = np.maximum(retro, _LEAST * retro.max()), np.ones(len(flat))
        for _ in range(_POWER_STEPS):
            sigma = area @ ndf
            ndf, sigma = ndf / sigma[0], sigma / sigma[0]
            ndf = np.maximum(sigma * retro, _LEAST * np.max(sigma * retro))
        sigma = area @ ndf
        return cls(*(_whole(values.reshape(half.shape[:2]) / sigma[0], isotropic) for values in (ndf, sigma)))

    def density(self, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        """D (...) in 1/sr as the file's readers interpolate it."""
        return _at(self.ndf, u, v)

    def area(self, wi: np.ndarray) -> np.ndarray:
        """Sigma (...) of lights (..., 3), as they do."""
        return _at(self.sigma, np.sqrt(np.arccos(wi[..., 2]) * (2.0 / np.pi)), (azimuth(wi) + np.pi) / (2.0 * np.pi))

    def visible(self, wi: np.ndarray, counts: tuple[int, int]) -> np.ndarray:
        """Density (phi_i, theta_i, v, u) of the normals that lights (phi_i, theta_i, 3) see, per area of (u, v)."""
        v, u = np.meshgrid(*(np.linspace(0.0, 1.0, n) for n in counts), indexing="ij")
        theta, phi = _angles(u, v)
        seen = np.maximum(np.einsum("abk,vuk->abvu", wi, spherical(theta, phi)), 0.0)
        return seen * (self.density(u, v) * _solid_angle(u, theta)) / self.area(wi)[..., None, None]


def _values(truth: Truth, normals: _Normals, wi, at, isotropic: bool, progress) -> np.ndarray:
    """The table (phi_i, theta_i, t, s, 3) at normals (u, v), each (phi_i, theta_i, t, s)."""
    rows = at[0].shape[2]
    if isotropic:  # the other half of the azimuths is alike
        at = tuple(values[:, :, : rows // 2 + 1] for values in at)
    wi = np.broadcast_to(wi[:, :, None, None], (*at[0].shape, 3))
    wo = reflect(wi, spherical(*_angles(*at)))
    above = wo[..., 2] > _NEAR_HORIZON
    values = np.zeros(wo.shape)
    scale = 4.0 * normals.area(wi[above]) / normals.density(at[0][above], at[1][above]) * wo[above][:, 2]
    values[above] = truth.f(wo[above], wi[above], progress) * scale[:, None]
    return np.concatenate([values, values[:, :, : rows // 2][:, :, ::-1]], axis=2) if isotropic else values


def _placed(visible: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """(u, v), each (phi_i, theta_i, t, s), of the nodes in the cumulative distribution of a density (phi_i, theta_i, v, u)."""
    share = np.clip(np.linspace(0.0, 1.0, count), _LEAST, 1.0 - _LEAST)
    v = _inverse(0.5 * (visible[..., 1:] + visible[..., :-1]).sum(axis=-1), share)
    y = v * (visible.shape[2] - 1)
    below = np.minimum(y.astype(int), visible.shape[2] - 2)
    y = (y - below)[..., None]
    row = np.take_along_axis(visible, below[..., None], axis=2) * (1.0 - y) + np.take_along_axis(visible, below[..., None] + 1, axis=2) * y
    u = _inverse(row, share)
    return u, np.broadcast_to(v[..., None], u.shape)


def _inverse(density: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Where (..., k) on [0, 1] the integral of a density (..., n), linear between even nodes, is these shares (k,) of the whole."""
    cumulative = np.zeros_like(density)
    cumulative[..., 1:] = np.cumsum(0.5 * (density[..., 1:] + density[..., :-1]), axis=-1)
    wanted = share * cumulative[..., -1:]
    below = np.minimum(np.sum(cumulative[..., None, :] <= wanted[..., None], axis=-1) - 1, density.shape[-1] - 2)
    low, high = np.take_along_axis(density, below, axis=-1), np.take_along_axis(density, below + 1, axis=-1)
    left = wanted - np.take_along_axis(cumulative, below, axis=-1)
    step = 2.0 * left / np.maximum(low + np.sqrt(np.maximum(low * low + 2.0 * (high - low) * left, 0.0)), 1e-300)
    return (below + np.minimum(step, 1.0)) / (density.shape[-1] - 1)


def _projected_areas(half: np.ndarray, rows: int) -> np.ndarray:
    """(n, n) from D at directions `half` (azimuths, thetas, 3) to the projected area of all normals towards each of them."""
    columns = half.shape[1]
    u, v = np.linspace(0.0, 1.0, columns), np.linspace(0.0, 1.0, rows)
    theta, phi = _angles(u, v[:, None])
    weights = _solid_angle(u, theta) * _trapezoid(columns) * _trapezoid(rows)[:, None]
    areas = np.maximum(half.reshape(-1, 3) @ spherical(theta, phi).reshape(-1, 3).T, 0.0) * weights.ravel()
    areas = areas.reshape(-1, rows, columns)
    if len(half) == 1:
        return areas.sum(axis=1)
    folded = areas[:, : rows // 2 + 1].copy()
    folded[:, 1:] += areas[:, rows // 2 + 1 :]
    return folded.reshape(len(areas), -1)


def _whole(values: np.ndarray, isotropic: bool) -> np.ndarray:
    """Rows of a whole turn from those of half a turn."""
    return np.repeat(values, 2, axis=0) if isotropic else np.concatenate([values, values[1:]])


def _angles(u, v) -> tuple[np.ndarray, np.ndarray]:
    """theta and phi of places on the unit square."""
    return np.square(u) * 0.5 * np.pi, (2.0 * v - 1.0) * np.pi


def _solid_angle(u, theta):
    """Of normals, per area of (u, v)."""
    return 2.0 * np.pi**2 * u * np.sin(theta)


def _trapezoid(count: int) -> np.ndarray:
    weights = np.full(count, 1.0 / (count - 1))
    weights[[0, -1]] *= 0.5
    return weights


def _at(table: np.ndarray, u, v) -> np.ndarray:
    u, v = np.broadcast_arrays(u, v)
    return bilinear(table[None, None, None], u.ravel(), v.ravel())[:, 0].reshape(u.shape)


def _luminance(rgb: np.ndarray) -> np.ndarray:
    return rgb @ np.linalg.inv(xyz_to_rgb(np.eye(3)))[:, 1]
