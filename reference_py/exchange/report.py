# SPDX-License-Identifier: GPL-3.0-or-later
"""What a conversion did: one line per parameter, and the error that remains."""

from dataclasses import dataclass

import numpy as np

from .materialx_graph import Image

KEPT, APPROXIMATED, LOST = "kept", "approximated", "lost"
FATES = (KEPT, APPROXIMATED, LOST)


def shown(value) -> str:
    """A number, a color or a word as short text."""
    if isinstance(value, str):
        return value
    if np.ndim(value):
        return " ".join(f"{v:.4g}" for v in value)
    return f"{value:.4g}"


@dataclass(frozen=True)
class Loss:
    """What became of one parameter: `fate` is one of FATES, `how` says the rest in words."""

    parameter: str
    value: object
    fate: str
    how: str

    def __str__(self) -> str:
        return f"{self.fate}: {self.parameter} {shown(self.value)}: {self.how}"


def image_loss(given: str, image: Image, value, is_mean: bool) -> Loss:
    """What becomes of an image that is not linked, by the value that stands in, or None."""
    if is_mean:
        return Loss(given, f"image {image.file}", APPROXIMATED, f"its mean, {shown(value)}, stands in; a material in Blender gets the image")
    return Loss(given, f"image {image.file}", LOST, "left out" if value is None else f"{shown(value)} stands in")


@dataclass(frozen=True)
class Match:
    """How far the converted material's albedo is from the original's, over views from the normal to grazing."""

    mean: np.ndarray
    """(3,) mean albedo of the original, weighted by the view's cosine."""
    mean_error: np.ndarray
    """(3,) that of the converted material less it."""
    worst: float
    """Largest difference of albedo, of any view and channel."""
    worst_theta_deg: float
    soft_light: float
    """Mean difference in uniform light, relative to the mean albedo: what is lost counts whole."""
    lost_light: float = 0.0
    """The part of it that is light which no stack sends out: transmitted, emitted, of a sheen."""
    color_difference: float = 0.0
    """CIEDE2000 of the two mean albedos."""
    without_film: bool = False
    """Whether these are figures of both materials without their thin film."""

    def __str__(self) -> str:
        off = np.max(np.abs(self.mean_error))
        bare = "without the thin film: " if self.without_film else ""
        return (
            f"{bare}mean albedo {shown(self.mean)}, off by {off:.1e} at most; worst albedo error {self.worst:.3f}, seen at "
            f"{self.worst_theta_deg:.0f} degrees; difference in soft light {100.0 * self.soft_light:.1f} %"
            + (f", {100.0 * self.lost_light:.1f} % of it light that is lost" if self.lost_light > 0.0 else "")
            + f"; color off by CIEDE2000 {self.color_difference:.2f}"
        )


@dataclass(frozen=True)
class Report:
    """Losses of every parameter, and how far the converted material is off."""

    losses: tuple[Loss, ...]
    match: Match

    def of(self, fate: str) -> tuple[Loss, ...]:
        """The losses of one of FATES."""
        return tuple(loss for loss in self.losses if loss.fate == fate)

    @property
    def summary(self) -> str:
        """One line: how many parameters met which fate, and the error."""
        counts = ", ".join(f"{len(self.of(fate))} {fate}" for fate in FATES)
        return f"{counts}; {self.match}"

    def lines(self) -> list[str]:
        """Lost ones first, then the approximated and the kept, then the error."""
        return [*(str(loss) for fate in reversed(FATES) for loss in self.of(fate)), str(self.match)]
