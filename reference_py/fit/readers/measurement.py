# SPDX-License-Identifier: GPL-3.0-or-later
"""Measured reflectance: pairs of directions with f, checked, and what was found on the way."""

from dataclasses import dataclass, replace
from functools import reduce

import numpy as np

from ...errors import LaminaError, Sentence, joined
from ...optics.colour import reflectance_to_rgb
from ...optics.frame import dot, half_vector

# Beyond this angle measurements are mostly stray light.
STEEPEST_DEG = 85.0
# The wavelengths in nm that bound the green channel, for data which have but three.
_GREEN_NM = (490.0, 590.0)
VISIBLE_NM = (380.0, 780.0)
_CELLS = (10, 5, 3)
# Bands of the steeper direction that what is left out is told by.
_BANDS_DEG = (0.0, 30.0, 60.0, 75.0, 85.0, 90.0)
# A zero is a shadow where the least of its neighbours is above this share of the median of all: a highlight ends in small values.
_LARGE, _NEIGHBOURS, _MOST_NEIGHBOURS, _CHUNK = 0.05, 5, 20_000, 200


@dataclass(frozen=True, eq=False, repr=False)
class Measurement:
    """`wi`, `wo` (n, 3) unit directions above the surface, `f` (n, c) in 1/sr without cosine; c is 3 (linear RGB) or 1.

    `found` are sentences for people: what the file holds, and what of it was left out.
    """

    wi: np.ndarray
    wo: np.ndarray
    f: np.ndarray
    source: str
    found: tuple[Sentence, ...] = ()

    @property
    def channels(self) -> int:
        """3 (linear RGB) or 1."""
        return self.f.shape[1]

    def subset(self, index: np.ndarray) -> "Measurement":
        """The rows that an index or mask picks."""
        return replace(self, wi=self.wi[index], wo=self.wo[index], f=self.f[index])


def checked(
    wi, wo, f, where: str, found: tuple[Sentence, ...] = (), wavelength_nm=None, only_nm: float | None = None, steepest_deg: float | None = None
) -> Measurement:
    """A measurement without what cannot be one: rows below the horizon, or not finite.

    `f` (n, c) has RGB or values at `wavelength_nm` (c,), which become RGB, or one value at `only_nm`. A channel that is
    negative beside others that outweigh it is a color outside Rec.709, or noise: it counts as 0. Rows that are left out are
    told by angle; those steeper than `steepest_deg` (85 unless given) too. Raises LaminaError where no row is left, most are
    bad, or all are black.
    """
    wi, wo, f = np.asarray(wi, float), np.asarray(wo, float), np.asarray(f, float)
    steepest_deg = STEEPEST_DEG if steepest_deg is None else steepest_deg
    notes = list(found)
    above = (wi[:, 2] > 0.0) & (wo[:, 2] > 0.0)
    if not above.any():
        raise LaminaError("{where}: all {pairs} directions are below the horizon; angles are from the normal, in degrees below 90", where=where, pairs=len(f))
    # channel after channel: tables have a million rows
    finite = reduce(np.logical_and, (np.isfinite(channel) for channel in f.T))
    total = f if finite.all() else np.where(finite[:, None], f, 0.0)
    least = reduce(np.minimum, total.T)
    positive = (reduce(np.add, total.T) > 0.0) | (least >= 0.0)
    good = above & finite & positive
    count = int(above.sum())
    for bad, what in ((above & ~finite, Sentence("not finite")), (above & finite & ~positive, Sentence("negative"))):
        if bad.any():
            told = {"bad": int(bad.sum()), "count": count, "what": what, "where": _by_angle(wi, wo, bad)}
            notes.append(Sentence("{bad} of {count} values above the horizon are {what} and left out: {where}", **told))
    if good.sum() <= 0.5 * count:
        raise LaminaError(
            "{where}: {bad} of {count} values above the horizon are negative or not finite; choose a file with mostly valid data (are its axes in order, and its numbers of the right byte order?)",
            where=where,
            bad=count - int(good.sum()),
            count=count,
        )
    if (~above).any():
        notes.append(Sentence("below the horizon and left out: {count}", count=int((~above).sum())))
    if (limited := good & (least < 0.0)).any():
        told = {"limited": int(limited.sum()), "count": count, "where": _by_angle(wi, wo, limited)}
        notes.append(Sentence("{limited} of {count} values have a channel below 0, outside Rec.709 or noise: it counts as 0: {where}", **told))
    if not good.all():
        f, wi, wo = f[good], wi[good], wo[good]
    f = np.maximum(f, 0.0)
    if np.max(f) <= 0.0:
        raise LaminaError("{where}: all {pairs} values are 0: a black measurement tells nothing", where=where, pairs=len(f))
    f, color_notes = _as_color(f, wavelength_nm, only_nm, where)
    steep = np.minimum(wi[:, 2], wo[:, 2]) < np.cos(np.radians(steepest_deg))
    if steep.all():
        raise LaminaError(
            "{where}: all directions are steeper than {steepest_deg:g} degrees, where no measurement is reliable", where=where, steepest_deg=steepest_deg
        )
    if steep.any():
        notes.append(Sentence("steeper than {steepest_deg:g} degrees and left out: {count}", steepest_deg=steepest_deg, count=int(steep.sum())))
    kept = ~steep
    return Measurement(wi[kept], wo[kept], f[kept], where, (*notes, *color_notes, _pairs(int(kept.sum()))))


def without_shadows(measurement: Measurement) -> Measurement:
    """What an instrument measured, without exact zeros among large neighbours, which are its own shadow: told by angle."""
    wi, wo = measurement.wi, measurement.wo
    shadow = _shadow(wi, wo, measurement.f)
    if not shadow.any():
        return measurement
    told = Sentence(
        "{count} values are exactly 0 among large ones, a shadow of the instrument, and left out: {where}",
        count=int(shadow.sum()),
        where=_by_angle(wi, wo, shadow),
    )
    kept = measurement.subset(~shadow)
    return replace(kept, found=(*measurement.found[:-1], told, _pairs(len(kept.f))))


def _pairs(count: int) -> Sentence:
    return Sentence("{count} pairs of directions", count=count)


def _by_angle(wi: np.ndarray, wo: np.ndarray, rows: np.ndarray) -> Sentence:
    """How many of the rows, and what share of all there, have their steeper direction in each band of angles."""
    steeper = np.degrees(np.arccos(np.clip(np.minimum(wi[:, 2], wo[:, 2]), -1.0, 1.0)))
    said = []
    for low, high in zip(_BANDS_DEG, _BANDS_DEG[1:]):
        band = (steeper >= low) & (steeper < high)
        if (band & rows).any():
            told = {"count": int((band & rows).sum()), "low": low, "high": high, "percent": 100.0 * np.mean(rows[band])}
            said.append(Sentence("{count} at {low:g} to {high:g} degrees ({percent:.2g} %)", **told))
    return joined(said)


def _shadow(wi: np.ndarray, wo: np.ndarray, f: np.ndarray) -> np.ndarray:
    """Rows that are exactly 0 while those next to them, by half and difference angle, are not small."""
    black = reduce(np.maximum, f.T) == 0.0
    if not black.any():
        return black
    theta_h, theta_d, phi_d = half_angles(wi, wo)
    place = np.stack([theta_h, theta_d, phi_d * np.sin(theta_d)], axis=-1)
    bright = np.flatnonzero(~black)
    bright = bright[:: max(1, len(bright) // _MOST_NEIGHBOURS)]
    level = np.median(np.max(f[bright], axis=1))
    dark = np.flatnonzero(black)
    result = np.zeros(len(f), bool)
    for start in range(0, len(dark), _CHUNK):
        rows = dark[start : start + _CHUNK]
        distance = np.sum(np.square(place[rows, None] - place[None, bright]), axis=-1)
        nearest = np.argpartition(distance, min(_NEIGHBOURS, len(bright)) - 1, axis=1)[:, :_NEIGHBOURS]
        result[rows] = np.min(np.max(f[bright[nearest]], axis=-1), axis=1) > _LARGE * level
    return result


def _as_color(f, wavelength_nm, only_nm, where) -> tuple[np.ndarray, tuple[Sentence, ...]]:
    if wavelength_nm is None and only_nm is None:
        if f.shape[1] > 1 and np.all(f == f[:, :1]):
            return f[:, :1], (Sentence("all colors are alike: fitted as grey"),)
        return f, ()
    if wavelength_nm is None:
        low, high = _GREEN_NM
        if not VISIBLE_NM[0] <= only_nm <= VISIBLE_NM[1]:
            raise LaminaError(
                "{where}: wavelength {only_nm:g} nm of RGB data; choose {least:g} to {most:g}",
                where=where,
                only_nm=only_nm,
                least=VISIBLE_NM[0],
                most=VISIBLE_NM[1],
            )
        channel = 2 if only_nm < low else 1 if only_nm <= high else 0
        name = (Sentence("red"), Sentence("green"), Sentence("blue"))[channel]
        return f[:, channel : channel + 1], (Sentence("the {channel} channel stands for {only_nm:g} nm", channel=name, only_nm=only_nm),)
    nm = np.asarray(wavelength_nm, float)
    if only_nm is None and len(nm) == 1:
        return f, (Sentence("one wavelength, {nm:g} nm: fitted as grey", nm=nm[0]),)
    if only_nm is None and (nm[-1] < VISIBLE_NM[0] or nm[0] > VISIBLE_NM[1]):
        raise LaminaError(
            "{where}: wavelengths {first:g} to {last:g} nm have no color; choose one of them with --wavelength", where=where, first=nm[0], last=nm[-1]
        )
    if only_nm is None:
        rgb = reflectance_to_rgb(f, nm)
        lost = np.mean(rgb.min(axis=1) < 0.0)
        notes = (Sentence("{count} wavelengths, {first:g} to {last:g} nm, made linear RGB", count=len(nm), first=nm[0], last=nm[-1]),)
        if lost > 0.0:
            notes += (Sentence("{percent:.1f} % of the colors are outside Rec.709 and were limited", percent=100 * lost),)
        return np.maximum(rgb, 0.0), notes
    if not nm[0] <= only_nm <= nm[-1]:
        raise LaminaError(
            "{where}: wavelength {only_nm:g} nm is not in the data; choose {first:g} to {last:g}", where=where, only_nm=only_nm, first=nm[0], last=nm[-1]
        )
    upper = min(int(np.searchsorted(nm, only_nm)), len(nm) - 1)
    lower = max(upper - 1, 0)
    share = 0.0 if upper == lower else (only_nm - nm[lower]) / (nm[upper] - nm[lower])
    return (f[:, lower] * (1.0 - share) + f[:, upper] * share)[:, None], (Sentence("at {only_nm:g} nm of {count} wavelengths", only_nm=only_nm, count=len(nm)),)


def half_angles(wi: np.ndarray, wo: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(theta_h, theta_d, phi_d), each (n,) in radians, of Rusinkiewicz 1998; phi_d in 0 to pi, as reciprocity allows."""
    wh = half_vector(wi, wo)
    (x, y, z), (hx, hy, hz) = wi.T, wh.T
    theta_d = np.arccos(np.clip(dot(wi, wh), -1.0, 1.0))
    sin_h = np.hypot(hx, hy)
    # the half vector's meridian; x of the world where it is the normal
    safe = np.where(sin_h > 1e-9, sin_h, np.inf)
    cos_a, sin_a = np.where(sin_h > 1e-9, hx / safe, 1.0), hy / safe
    phi_d = np.arctan2(y * cos_a - x * sin_a, hz * (x * cos_a + y * sin_a) - sin_h * z) % np.pi
    return np.arctan2(sin_h, hz), theta_d, phi_d


def subsample(measurement: Measurement, count: int, rng: np.random.Generator) -> Measurement:
    """At most `count` rows, spread evenly over sqrt(theta_h), theta_d and phi_d, so that a highlight gets its share."""
    if len(measurement.f) <= count:
        return measurement
    theta_h, theta_d, phi_d = half_angles(measurement.wi, measurement.wo)
    places = (np.sqrt(theta_h / (0.5 * np.pi)), theta_d / (0.5 * np.pi), phi_d / np.pi)
    cell = np.ravel_multi_index([np.minimum((p * n).astype(int), n - 1) for p, n in zip(places, _CELLS)], _CELLS).astype(np.uint8)
    order = rng.permutation(len(cell))
    order = order[np.argsort(cell[order], kind="stable")]
    filled = np.bincount(cell)
    turn = np.arange(len(order)) - np.repeat(np.cumsum(filled) - filled, filled)  # the how-manieth of its cell each row is
    tie = rng.random(len(order))
    # turns that hold enough: the others need no order
    most = 1 + int(np.searchsorted(np.cumsum(np.bincount(turn)), count))
    early = np.flatnonzero(turn < most)
    chosen = order[early[np.lexsort((tie[early], turn[early]))[:count]]]
    return measurement.subset(np.sort(chosen))


def spread_pairs(count: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """wi, wo (count, 3), random and even over sqrt(theta_h), theta_d and phi_d, both above the horizon by 5 degrees."""
    wi, wo = np.zeros((0, 3)), np.zeros((0, 3))
    while len(wi) < count:
        u = rng.random((2 * count, 3))
        pair = directions_of(np.square(u[:, 0]) * 0.5 * np.pi, u[:, 1] * 0.5 * np.pi, u[:, 2] * np.pi)
        fine = np.minimum(pair[0][:, 2], pair[1][:, 2]) > np.cos(np.radians(STEEPEST_DEG))
        wi, wo = np.concatenate([wi, pair[0][fine]]), np.concatenate([wo, pair[1][fine]])
    return wi[:count], wo[:count]


def directions_of(theta_h: np.ndarray, theta_d: np.ndarray, phi_d: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """wi, wo (..., 3) of half and difference angles (...) in radians, the half vector in the plane y = 0."""
    x, y, z = np.sin(theta_d) * np.cos(phi_d), np.sin(theta_d) * np.sin(phi_d), np.cos(theta_d)
    cos_h, sin_h = np.cos(theta_h), np.sin(theta_h)
    wi, wo = (np.empty((*np.broadcast_shapes(np.shape(x), np.shape(cos_h)), 3)) for _ in range(2))
    wi[..., 0], wi[..., 1], wi[..., 2] = cos_h * x + sin_h * z, y, cos_h * z - sin_h * x
    wo[..., 0], wo[..., 1], wo[..., 2] = sin_h * z - cos_h * x, -y, cos_h * z + sin_h * x
    return wi, wo
