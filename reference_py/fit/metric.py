# SPDX-License-Identifier: GPL-3.0-or-later
"""How far a model is from a measurement: RMS of a compressed f cos, weighted with the light's cosine.

The default compresses as log(x / mean + 0.1): read as a relative error of what is above a tenth of the mean measured
f cos (of what is above .4, where a highlight makes the mean larger than 4). Chosen by `lamina chart fit` (fit_metric.csv), random stacks of one layer: by noise of 5 % of f, the median L1 error
that it leaves is like that with a floor of 0.01, a third below the cube root's and 2.5 times below that of no compression,
and parameters come nine times closer than without any. By additive noise of 2 % of the mean, a floor of 0.01 loses dark
stacks altogether (67 % off), this one is 4 % off at worst; none at all does best there (2 %), but gonioreflectometers err
in proportion.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ..errors import Sentence
from ..optics.error_measure import worst_share
from ..optics.frame import dot
from .readers.measurement import STEEPEST_DEG, Measurement, half_angles

FLOOR = 0.1
_COMPRESSED = {
    "log": lambda x: np.log(x + FLOOR),
    "log_low": lambda x: np.log(x + 0.1 * FLOOR),
    "cube_root": lambda x: 3.0 * np.cbrt(x),
    "linear": lambda x: x,
}
METRICS = tuple(_COMPRESSED)
# View or light angle, the larger one; edges in degrees.
BANDS_DEG = (0.0, 30.0, 50.0, 65.0, 75.0, STEEPEST_DEG)
# A mirror-like highlight makes the mean as large as you like; this keeps the floor at what white paint has (1 / pi), so
# that the color below is seen. The means of stacks of roughness .2 and more are below it.
_MOST_MEAN = 4.0
# f (1/sr) below this is dark, whatever else is in the data.
_DARK = 1e-3
# As many pairs tell how alike neighbours are.
_MOST_PAIRS = 1500


@dataclass(frozen=True, eq=False, repr=False)
class Metric:
    """Residuals against a measurement."""

    measurement: Measurement
    kind: str = "log"
    _weight: np.ndarray = field(init=False)
    _scale: np.ndarray = field(init=False)
    target: np.ndarray = field(init=False)
    """(n, c) the data, compressed."""

    def __post_init__(self):
        m = self.measurement
        weight = m.wi[:, 2:] / np.mean(m.wi[:, 2])
        object.__setattr__(self, "_weight", np.sqrt(weight))
        object.__setattr__(self, "_scale", m.wi[:, 2:] / min(float(np.mean(m.f * m.wi[:, 2:])), _MOST_MEAN))
        object.__setattr__(self, "target", self.compressed(m.f))

    @cached_property
    def neighbours(self) -> np.ndarray:
        """Index (k,) of the pair nearest to each of the first pairs, by half and difference angles."""
        m = self.measurement.subset(slice(_MOST_PAIRS))
        theta_h, theta_d, phi_d = half_angles(m.wi, m.wo)
        around = 0.5 * theta_h * np.exp(2.0j * phi_d)
        places = (np.sqrt(theta_h), theta_d, around.real, around.imag)
        distance = sum(np.square(place[:, None] - place) for place in places)
        np.fill_diagonal(distance, np.inf)
        return np.argmin(distance, axis=1)

    def compressed(self, f: np.ndarray) -> np.ndarray:
        """(n, c) of f (n, c), weighted: differences of it are residuals."""
        return self._weight * _COMPRESSED[self.kind](np.maximum(f, 0.0) * self._scale)

    def residual(self, f: np.ndarray) -> np.ndarray:
        """(n, c), model less data."""
        return self.compressed(f) - self.target

    def error(self, f: np.ndarray) -> float:
        """RMS residual."""
        return rms(self.residual(f))

    def bands(self, residual: np.ndarray) -> dict[Sentence, float]:
        """RMS of residuals (n, c) per band of the larger of view and light angle, in its highlight, and towards the light."""
        m, mean_square = self.measurement, np.mean(np.square(residual.T), axis=0)
        steepest = np.degrees(np.arccos(np.clip(np.minimum(m.wi[:, 2], m.wo[:, 2]), 0.0, 1.0)))
        masks = {
            Sentence("{low:g}-{high:g} deg", low=low, high=high): (steepest >= low) & (steepest < high + 1e-6 * (high == STEEPEST_DEG))
            for low, high in zip(BANDS_DEG, BANDS_DEG[1:])
        }
        wh = m.wi + m.wo
        cos_h = wh[:, 2] / np.sqrt(dot(wh, wh))
        masks[Sentence("near the mirror direction")] = cos_h > np.cos(np.radians(10.0))
        masks[Sentence("towards the light")] = dot(m.wi, m.wo) > np.cos(np.radians(20.0))
        return {name: float(np.sqrt(np.mean(mean_square[mask]))) for name, mask in masks.items() if mask.any()}

    def hidden(self, f: np.ndarray) -> tuple[float, float]:
        """What the floor hides beside a bright highlight: the share of values, below it and yet not dark, at which f is off
        by more than a factor of two, and the median factor there.
        """
        m = self.measurement
        dim = (m.f * self._scale < FLOOR) & (m.f > _DARK)
        factor = np.exp(np.abs(np.log((np.maximum(f, 0.0) + 0.1 * _DARK) / (m.f + 0.1 * _DARK))))
        off = dim & (factor > 2.0)
        return float(np.mean(off)), float(np.median(factor[off])) if off.any() else 1.0


def percent(error: float) -> Sentence:
    """An error for people; what is far below any model's accuracy is not spelled out."""
    return Sentence("{percent:.2g} %", percent=100.0 * error) if error >= 1e-4 else Sentence("below .01 %")


def rms(residual: np.ndarray) -> float:
    """Root of the mean square of residuals of any shape."""
    return float(np.sqrt(np.mean(np.square(residual))))


def shape_error(f: np.ndarray, truth: np.ndarray, cos_i: np.ndarray) -> float:
    """Cosine-weighted L1 of f (n, c) over that of the truth, the worst channel."""
    cos = cos_i[:, None]
    return float(worst_share(np.mean(np.abs(f - truth) * cos, axis=0), np.mean(truth * cos, axis=0)))
