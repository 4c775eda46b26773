# SPDX-License-Identifier: GPL-3.0-or-later
"""Small synthetic files in every format of measurement that the fit reads."""

import struct

import numpy as np

from lamina.reference_py.fit.readers.measurement import directions_of
from lamina.reference_py.fit.readers.merl import SCALES
from lamina.reference_py.fit.readers.tensor_file import MAGIC
from lamina.reference_py.optics.frame import half_vector
from lamina.reference_py.optics.microfacet import GGX, distribution, smith_lambda

SIZES = (20, 20, 40)


def paint(wi, wo, alpha=0.3, color=(0.3, 0.2, 0.1)):
    """f (n, 3) of a lobe over a diffuse color."""
    wh = half_vector(wi, wo)
    lobe = 0.05 * distribution(wh[:, 2], alpha, GGX) / (4.0 * np.maximum(wi[:, 2] * wo[:, 2], 1e-3))
    lobe /= 1.0 + smith_lambda(wi[:, 2], alpha, GGX) + smith_lambda(wo[:, 2], alpha, GGX)
    return np.array(color) / np.pi + lobe[:, None]


def merl_values(f=paint, sizes=SIZES):
    """(3, h, d, p) scaled values; -1 below the horizon."""
    # written out apart from the reader: theta_h is spaced as the root of the angle
    h, d, p = np.meshgrid(*(np.arange(n) + 0.5 for n in sizes), indexing="ij")
    theta_h, theta_d, phi_d = (h / sizes[0]) ** 2 * np.pi / 2, d / sizes[1] * np.pi / 2, p / sizes[2] * np.pi
    wi, wo = directions_of(theta_h.ravel(), theta_d.ravel(), phi_d.ravel())
    above = (wi[:, 2] > 0.0) & (wo[:, 2] > 0.0)
    values = np.full((3, len(wi)), -1.0)
    values[:, above] = f(wi[above], wo[above]).T / SCALES[:, None]
    return values.reshape(3, *sizes)


def merl_bytes(values, order="<"):
    return struct.pack(f"{order}3i", *values.shape[1:]) + np.ascontiguousarray(values).astype(f"{order}f8").tobytes()


def tensor_bytes(fields):
    """A tensor file of arrays by name."""
    kinds = {"u1": 1, "f4": 10, "f8": 11}
    head = MAGIC + struct.pack("<2BI", 1, 0, len(fields))
    size = len(head) + sum(2 + len(n) + 11 + 8 * a.ndim for n, a in fields.items())
    body = b""
    for name, array in fields.items():
        head += struct.pack("<H", len(name)) + name.encode()
        head += struct.pack("<HBQ", array.ndim, kinds[array.dtype.str[1:]], size + len(body)) + struct.pack(f"<{array.ndim}Q", *array.shape)
        body += array.tobytes()
    return head + body


def rgl_fields(f=paint, thetas=9, cells=33, wavelength_nm=None, phis=(0.0,)):
    """A material whose normals are placed by a density of their own, not a flat one, so that the inversion matters."""
    theta_i = np.linspace(0.0, 0.49 * np.pi, thetas)
    u = np.linspace(0.0, 1.0, cells)
    density = np.exp(-3.0 * u)[None, :] * (1.0 + 0.5 * np.cos(2.0 * np.pi * u))[:, None]  # (phi_m, theta_m)
    vndf = np.broadcast_to(density, (len(phis), thetas, cells, cells)).astype("f4")
    # exact inverse of the separable density, on a fine grid
    fine = np.linspace(0.0, 1.0, 4001)
    along = _cumulative(np.interp(fine, u, np.exp(-3.0 * u)))
    across = _cumulative(np.interp(fine, u, 1.0 + 0.5 * np.cos(2.0 * np.pi * u)))
    theta_m = np.interp(u, along, fine) ** 2 * np.pi / 2
    phi_m = (2.0 * np.interp(u, across, fine) - 1.0) * np.pi
    channels = 3 if wavelength_nm is None else len(wavelength_nm)
    values = np.zeros((len(phis), thetas, channels, cells, cells))
    for a, phi_i in enumerate(phis):
        for b, theta in enumerate(theta_i):
            wi = np.array([np.sin(theta) * np.cos(phi_i), np.sin(theta) * np.sin(phi_i), np.cos(theta)])
            t, p = np.meshgrid(theta_m, phi_m + (phi_i if len(phis) <= 2 else 0.0))
            wm = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=-1).reshape(-1, 3)
            wo = 2.0 * (wm @ wi)[:, None] * wm - wi
            safe = np.where(wo[:, 2:] > 1e-3, wo, [0.0, 0.0, 1.0])
            value = f(np.broadcast_to(wi, wo.shape), safe) * wo[:, 2:]
            if wavelength_nm is not None:
                value = value[:, :1] * np.ones(channels)
            values[a, b] = np.where(wo[:, 2:] > 1e-3, value, 0.0).T.reshape(channels, cells, cells)
    fields = {
        "description": np.frombuffer(b"synthetic", "u1"),
        "jacobian": np.zeros(1, "u1"),
        "phi_i": np.array(phis, "f4"),
        "theta_i": theta_i.astype("f4"),
        "ndf": np.ones((2, 8), "f4"),
        "sigma": np.ones((2, 8), "f4"),
        "vndf": vndf,
    }
    if wavelength_nm is None:
        return {**fields, "rgb": values.astype("f4")}
    return {**fields, "wavelengths": np.array(wavelength_nm, "f4"), "spectra": values.astype("f4")}


def _cumulative(density):
    total = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]))])
    return total / total[-1]


def table_text(wi, wo, f, names=("r", "g", "b")):
    rows = ["theta_i,phi_i,theta_o,phi_o," + ",".join(names)]
    for i, o, value in zip(wi, wo, f):
        angles = [np.arccos(i[2]), np.arctan2(i[1], i[0]), np.arccos(o[2]), np.arctan2(o[1], o[0])]
        rows.append(",".join(f"{v:.9g}" for v in [*np.degrees(angles), *value]))
    return "\n".join(rows) + "\n"
