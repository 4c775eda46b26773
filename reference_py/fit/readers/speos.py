# SPDX-License-Identifier: GPL-3.0-or-later
"""BRDF files of Speos (OPTIS), as text: header, then a table theta by phi per angle of incidence and wavelength.

After "OPTIS - brdf surface file" come mode (0 is text), a comment, a description with its length, whether there is
reflection and transmission, whether values follow f (1) or the intensity f cos (0), counts and lists of incidences and
wavelengths; each table begins with its reflectance in percent, the counts of theta and phi, and the phi. Values have no
scale of their own: f is scaled so that its integral is the reflectance. The mirror direction is where the light is, at phi 0 or 180.
"""

from pathlib import Path

import numpy as np

from ...errors import LaminaError, Sentence
from ...optics.frame import spherical
from .measurement import Measurement, checked

MAGIC = "optis - brdf surface file"
_MOST_BYTES, _MOST_VALUES = 500_000_000, 50_000_000


def read(path: Path, wavelength_nm: float | None = None, steepest_deg: float | None = None) -> Measurement:
    """The measurement of a file. Raises LaminaError on another kind of file, a truncated one, or data of transmission."""
    if path.stat().st_size > _MOST_BYTES:
        raise LaminaError("{path}: {size} bytes are too large for a table; at most {most}", path=path, size=path.stat().st_size, most=_MOST_BYTES)
    text = path.read_text(encoding="latin-1")
    lines = text.splitlines()
    if not lines or not lines[0].strip().lower().startswith(MAGIC):
        raise LaminaError("{path}: no BRDF file of Speos: it does not start with 'OPTIS - brdf surface file'", path=path)
    if len(lines) < 5 or lines[1].strip() != "0":
        raise LaminaError("{path}: is binary, or truncated; export it from Speos as text", path=path)
    numbers = _Numbers(path, _after_description(path, lines))
    reflects, _transmits = numbers.counts(2)
    if not reflects:
        raise LaminaError("{path}: has transmission alone; only light that comes back can be fitted", path=path)
    (follows_f,) = numbers.counts(1)
    incidences, wavelengths = numbers.counts(2)
    theta_i, nm = numbers.take(incidences), numbers.take(wavelengths)
    tables, axes, mirrors = [], [], []
    for angle in theta_i:
        channels = []
        for _ in nm:
            reflectance, (rows, columns) = numbers.take(1)[0], numbers.counts(2)
            phi = numbers.take(columns)
            table = numbers.take(rows * (columns + 1)).reshape(rows, columns + 1)
            theta, values = table[:, 0], table[:, 1:]
            f = values if follows_f else values / np.maximum(np.cos(np.radians(theta)), 1e-6)[:, None]
            channels.append(_scaled(path, f, theta, phi, 0.01 * reflectance))
            if axes and channels[0].shape != channels[-1].shape:
                raise LaminaError("{path}: the tables of wavelengths differ in their angles", path=path)
        axes.append((angle, theta, phi))
        f = np.stack(channels, axis=-1)
        mirror = _mirror_phi(f.sum(axis=-1), theta, phi, angle)
        mirrors.append(mirror)
        tables.append(f.reshape(-1, len(nm)))
    wi, wo = [], []
    common = 180.0 if sum(m == 180.0 for m in mirrors) > len(mirrors) / 2 else 0.0
    for angle, theta, phi in axes:
        t, p = np.meshgrid(np.radians(theta), np.radians(phi), indexing="ij")
        wo.append(spherical(t.ravel(), p.ravel()))
        wi.append(np.broadcast_to(spherical(np.radians(angle), np.radians(180.0 - common)), wo[-1].shape))
    told = {"incidences": incidences, "wavelengths": wavelengths, "phi": common}
    found = (Sentence("Speos BRDF of {incidences} incidences and {wavelengths} wavelengths; the mirror direction is at phi {phi:g}", **told),)
    return checked(np.concatenate(wi), np.concatenate(wo), np.concatenate(tables), str(path), found, nm, wavelength_nm, steepest_deg)


def _after_description(path: Path, lines: list[str]) -> list[str]:
    """Words after the description, which is as many characters long as the line before it says."""
    try:
        left = int(lines[3])
    except ValueError:
        raise LaminaError("{path}: line 4 is {text!r}; choose the length of the description", path=path, text=lines[3][:40]) from None
    at = 4
    while left > 0 and at < len(lines):
        left -= len(lines[at]) + 1
        at += 1
    return " ".join(lines[at:]).split()


class _Numbers:
    """The numbers of a file, taken one after the other. Raises LaminaError where they end or are none."""

    def __init__(self, path: Path, words: list[str]):
        self._path, self._at = path, 0
        try:
            self._values = np.array(words, float)
        except ValueError:
            bad = next(word for word in words if not word.replace(".", "").replace("-", "").replace("+", "").replace("e", "").replace("E", "").isdigit())
            raise LaminaError("{path}: {text!r} is not a number", path=path, text=bad[:40]) from None

    def take(self, count: int) -> np.ndarray:
        """The next `count` numbers."""
        if count > _MOST_VALUES or self._at + count > len(self._values):
            raise LaminaError(
                "{path}: truncated: {count} numbers are announced, {left} follow", path=self._path, count=count, left=len(self._values) - self._at
            )
        self._at += count
        return self._values[self._at - count : self._at]

    def counts(self, count: int) -> list[int]:
        """The next numbers, which are whole and not negative."""
        found = self.take(count)
        if np.any(found < 0.0) or np.any(found != np.rint(found)):
            raise LaminaError("{path}: {found} are no counts", path=self._path, found=found.tolist())
        return [int(v) for v in found]


def _scaled(path: Path, f: np.ndarray, theta_deg: np.ndarray, phi_deg: np.ndarray, reflectance: float) -> np.ndarray:
    """f (theta, phi) with `reflectance` as its integral with the cosine over the hemisphere."""
    if len(theta_deg) < 2 or len(phi_deg) < 2:
        raise LaminaError("{path}: a table has {thetas} theta and {phis} phi; choose at least 2 of each", path=path, thetas=len(theta_deg), phis=len(phi_deg))
    theta, phi = np.radians(theta_deg), np.radians(phi_deg)
    weighted = f * (np.sin(theta) * np.maximum(np.cos(theta), 0.0))[:, None]
    along = np.sum(0.5 * (weighted[:, 1:] + weighted[:, :-1]) * np.diff(phi), axis=1)
    whole = np.sum(0.5 * (along[1:] + along[:-1]) * np.diff(theta)) * 2.0 * np.pi / (phi[-1] - phi[0])
    if not whole > 0.0:
        raise LaminaError("{path}: a table is black", path=path)
    return f * (reflectance / whole)


def _mirror_phi(f: np.ndarray, theta_deg: np.ndarray, phi_deg: np.ndarray, incidence_deg: float) -> float:
    """0 or 180: where the light is near to the angle of incidence."""
    row = int(np.argmin(np.abs(theta_deg - incidence_deg)))
    here, there = (f[row, int(np.argmin(np.abs(phi_deg - phi)))] for phi in (0.0, 180.0))
    return 180.0 if there > here else 0.0
