# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials of the RGL (EPFL) database in their adaptive parametrisation (Dupuy and Jakob 2018).

The light's direction is phi_i, theta_i; the facet normal's place in the visible normals' cumulative distribution of that
light is where the values stand. They are f cos(theta_o), divided by D / (4 sigma) where `jacobian` says so. Angles on
unit squares: u = sqrt(2 theta / pi), v = (phi + pi) / (2 pi), and for isotropic materials phi is that from the light.
"""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from ...errors import LaminaError, Sentence
from ...optics.frame import rotate_z
from .measurement import Measurement, checked, spread_pairs
from .tensor_file import read_tensors

_PAIRS = 20_000
_NEEDED = {"theta_i": 1, "phi_i": 1, "ndf": 2, "sigma": 2, "vndf": 4, "jacobian": 1}


def read(path: Path, wavelength_nm: float | None = None, steepest_deg: float | None = None) -> Measurement:
    """The material at 20,000 pairs of directions, spread over the hemispheres. Raises LaminaError."""
    material = Material.load(path)
    rng = np.random.default_rng(0)
    wi, wo = spread_pairs(_PAIRS, rng)
    turn = 2.0 * np.pi * rng.random(_PAIRS)
    wi, wo = rotate_z(wi, turn), rotate_z(wo, turn)
    kind = Sentence("isotropic") if material.is_isotropic else Sentence("anisotropic ({azimuths} azimuths; the fit is isotropic)", azimuths=len(material.phi_i))
    text = bytes(material.description).decode("utf-8", "replace").strip("\0 \n")
    found = (Sentence("RGL material {text!r}, {kind}, {angles} angles of incidence", text=text, kind=kind, angles=len(material.theta_i)),)
    return checked(wi, wo, material.f(wi, wo), str(path), found, material.wavelength_nm, wavelength_nm, steepest_deg)


@dataclass(frozen=True, eq=False, repr=False)
class Material:
    """The tables. `values` (phi_i, theta_i, channel, phi_m, theta_m); `wavelength_nm` (channel,), or None for RGB."""

    phi_i: np.ndarray
    theta_i: np.ndarray
    ndf: np.ndarray
    sigma: np.ndarray
    vndf: np.ndarray
    values: np.ndarray
    wavelength_nm: np.ndarray | None
    has_jacobian: bool
    description: np.ndarray

    @classmethod
    def load(cls, path: Path) -> "Material":
        """Read the tables of a file. Raises LaminaError on fields that are missing, do not match, or hold what they cannot."""
        fields = read_tensors(path)
        for name, dimensions in _NEEDED.items():
            if name not in fields or fields[name].ndim != dimensions:
                have = Sentence("{count} dimensions", count=fields[name].ndim) if name in fields else Sentence("none")
                raise LaminaError(
                    "{path}: field {name!r} must have {wanted}, it has {have}; the file holds {fields}",
                    path=path,
                    name=name,
                    wanted=_dimensions(dimensions),
                    have=have,
                    fields=", ".join(fields) or Sentence("nothing"),
                )
        for name in _NEEDED:
            if not np.isfinite(np.asarray(fields[name], float)).all():
                raise LaminaError("{path}: field {name!r} holds values that are not finite", path=path, name=name)
        name = "rgb" if "rgb" in fields else "spectra"
        wavelength = fields.get("wavelengths") if name == "spectra" else None
        channels = 3 if name == "rgb" else 0 if wavelength is None else len(wavelength)
        if name not in fields or not channels:
            raise LaminaError("{path}: neither 'rgb' nor 'spectra' with 'wavelengths'; the file holds {fields}", path=path, fields=", ".join(fields))
        phi_i, theta_i, values, vndf = fields["phi_i"], fields["theta_i"], fields[name], fields["vndf"]
        grid = (len(phi_i), len(theta_i))
        if values.ndim != 5 or values.shape[:3] != (*grid, channels) or vndf.shape[:2] != grid:
            raise LaminaError(
                "{path}: axes do not match: {name} {shape} and vndf {vndf_shape} must begin with {azimuths} azimuths and {angles} angles, {name} then with {channels} channels",
                path=path,
                name=name,
                shape=values.shape,
                vndf_shape=vndf.shape,
                azimuths=len(phi_i),
                angles=len(theta_i),
                channels=channels,
            )
        for axis in ("phi_i", "theta_i"):
            if np.any(np.diff(fields[axis]) <= 0.0):
                raise LaminaError("{path}: {axis} does not increase", path=path, axis=axis)
        if theta_i[-1] > 0.5 * np.pi + 1e-3 or theta_i[0] < 0.0:
            raise LaminaError("{path}: theta_i goes from {first:g} to {last:g}; choose radians from 0 to pi / 2", path=path, first=theta_i[0], last=theta_i[-1])
        if np.any(np.asarray(vndf) < 0.0):
            raise LaminaError("{path}: vndf, which is a density, has negative values", path=path)
        if min(vndf.shape[2:], default=0) < 2 or np.any(np.asarray(vndf).max(axis=(2, 3)) <= 0.0):
            raise LaminaError("{path}: vndf {vndf_shape} is empty or black for some angle of incidence", path=path, vndf_shape=vndf.shape)
        as_float = {key: np.asarray(fields[key], float) for key in ("phi_i", "theta_i", "ndf", "sigma", "vndf")}
        return cls(
            **as_float,
            values=np.asarray(values, float),
            has_jacobian=bool(fields["jacobian"][0]),
            wavelength_nm=None if wavelength is None else np.asarray(wavelength, float),
            description=fields.get("description", np.zeros(0, np.uint8)),
        )

    @property
    def is_isotropic(self) -> bool:
        """Whether phi counts from the light's: then the file has two azimuths of it at most."""
        return len(self.phi_i) <= 2

    def f(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        """f (n, channels) without cosine at directions (n, 3) above the surface."""
        if not self.is_isotropic:
            wi, wo = self._folded(wi, wo)
        wm = wi + wo
        wm = wm / np.linalg.norm(wm, axis=1, keepdims=True)
        theta_i, phi_i = _angles(wi)
        theta_m, phi_m = _angles(wm)
        u = np.sqrt(theta_m * (2.0 / np.pi))
        v = ((phi_m - phi_i if self.is_isotropic else phi_m) + np.pi) / (2.0 * np.pi) % 1.0
        corners = self._corners(phi_i, theta_i)
        s, t = self._place(u, v, corners)
        result = sum(w[:, None] * bilinear(self.values, s, t, a, b) for a, b, w in corners)
        if self.has_jacobian:
            ndf = bilinear(self.ndf[None, None, None], u, v)[:, 0]
            sigma = bilinear(self.sigma[None, None, None], np.sqrt(theta_i * (2.0 / np.pi)), (phi_i + np.pi) / (2.0 * np.pi))[:, 0]
            result = result * (ndf / (4.0 * np.maximum(sigma, 1e-12)))[:, None]
        return result / wo[:, 2:]

    def _folded(self, wi, wo):
        """Directions in the part of the azimuths that was measured, by the material's mirror symmetries."""
        parts = int(np.rint(2.0 * np.pi / (self.phi_i[-1] - self.phi_i[0])))
        if parts < 2:
            return wi, wo
        flip_y = np.where(wi[:, 1] > 0.0, -1.0, 1.0)
        flip_x = np.where(wi[:, 0] > 0.0, -1.0, 1.0) if parts == 4 else flip_y
        flips = np.stack([flip_x, flip_y, np.ones(len(wi))], axis=-1)
        return wi * flips, wo * flips

    def _corners(self, phi, theta):
        """(phi index, theta index, weight), each (n,), of the tables between which a light's direction lies."""
        a, share_a = _between(self.phi_i, phi)
        b, share_b = _between(self.theta_i, theta)
        a_next, b_next = np.minimum(a + 1, len(self.phi_i) - 1), np.minimum(b + 1, len(self.theta_i) - 1)
        return [
            (a, b, (1 - share_a) * (1 - share_b)),
            (a_next, b, share_a * (1 - share_b)),
            (a, b_next, (1 - share_a) * share_b),
            (a_next, b_next, share_a * share_b),
        ]

    @cached_property
    def _cumulative(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Densities of total 1, integral along theta up to each node, and of the rows' totals up to each row."""
        rows, columns = self.vndf.shape[2:]
        along = np.zeros_like(self.vndf)
        along[..., 1:] = np.cumsum(0.5 * (self.vndf[..., 1:] + self.vndf[..., :-1]), axis=-1) / (columns - 1)
        total = along[..., -1]
        down = np.zeros_like(total)
        down[..., 1:] = np.cumsum(0.5 * (total[..., 1:] + total[..., :-1]), axis=-1) / (rows - 1)
        whole = down[..., -1][..., None, None]
        return self.vndf / whole, along / whole, down / whole[..., 0]

    def _place(self, u, v, corners):
        """Where normals at (u, v) stand in the cumulative distribution: (s, t), rows first, then along the row."""
        density, along, down = self._cumulative
        rows, columns = density.shape[2:]
        x, y = np.clip(u, 0.0, 1.0) * (columns - 1), np.clip(v, 0.0, 1.0) * (rows - 1)
        i, j = np.minimum(x.astype(int), columns - 2), np.minimum(y.astype(int), rows - 2)
        x, y = x - i, y - j

        def mixed(table, *index):
            return sum(w * table[(a, b, *index)] for a, b, w in corners)

        def along_row(row):
            here, there = mixed(density, row, i), mixed(density, row, i + 1)
            return mixed(along, row, i) + (x * here + 0.5 * x * x * (there - here)) / (columns - 1)

        upper, lower = mixed(along, j, columns - 1), mixed(along, j + 1, columns - 1)
        t = mixed(down, j) + (y * upper + 0.5 * y * y * (lower - upper)) / (rows - 1)
        row_total = (1.0 - y) * upper + y * lower
        s = ((1.0 - y) * along_row(j) + y * along_row(j + 1)) / np.maximum(row_total, 1e-30)
        return np.clip(s, 0.0, 1.0), np.clip(t, 0.0, 1.0)


def _angles(w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """theta, precise at the pole, and phi."""
    return np.arctan2(np.hypot(w[:, 0], w[:, 1]), w[:, 2]), np.arctan2(w[:, 1], w[:, 0])


def _between(nodes, x):
    """Index of the node below x and how far x is to the next; the ends hold beyond."""
    if len(nodes) == 1:
        return np.zeros(len(x), int), np.zeros(len(x))
    i = np.clip(np.searchsorted(nodes, x, side="right") - 1, 0, len(nodes) - 2)
    return i, np.clip((x - nodes[i]) / (nodes[i + 1] - nodes[i]), 0.0, 1.0)


def bilinear(table: np.ndarray, u: np.ndarray, v: np.ndarray, a=0, b=0) -> np.ndarray:
    """(n, channels) of a table (A, B, channels, rows, columns) at u along the columns and v along the rows, both 0 to 1."""
    rows, columns = table.shape[-2:]
    x, y = np.clip(u, 0.0, 1.0) * (columns - 1), np.clip(v, 0.0, 1.0) * (rows - 1)
    i, j = np.minimum(x.astype(int), max(columns - 2, 0)), np.minimum(y.astype(int), max(rows - 2, 0))
    x, y = (x - i)[:, None], (y - j)[:, None]
    i1, j1 = np.minimum(i + 1, columns - 1), np.minimum(j + 1, rows - 1)
    top = table[a, b, :, j, i] * (1.0 - x) + table[a, b, :, j, i1] * x
    bottom = table[a, b, :, j1, i] * (1.0 - x) + table[a, b, :, j1, i1] * x
    return top * (1.0 - y) + bottom * y


def _dimensions(count: int) -> Sentence:
    return Sentence("1 dimension") if count == 1 else Sentence("{count} dimensions", count=count)
