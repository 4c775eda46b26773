# SPDX-License-Identifier: GPL-3.0-or-later
"""What a conversion did: one line per parameter, and the error that remains."""

from dataclasses import dataclass

import numpy as np

from ..errors import Sentence
from ..material.schema import Parameter
from .materialx_image import Image

KEPT, APPROXIMATED, LOST = Sentence("kept"), Sentence("approximated"), Sentence("lost")
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
    """What became of one parameter: `fate` is one of FATES, `how` says the rest in words that a window can translate; the parameter is named as its file or node names it."""

    parameter: str
    value: object
    fate: Sentence
    how: Sentence

    @property
    def sentence(self) -> Sentence:
        """All of it in words."""
        return Sentence("{fate}: {parameter} {value}: {how}", fate=self.fate, parameter=self.parameter, value=shown(self.value), how=self.how)

    def __str__(self) -> str:
        return self.sentence


def noted(fate: Sentence, note: Sentence) -> Sentence:
    """A line of a report on what is no parameter, such as a link or an image."""
    return Sentence("{fate}: {note}", fate=fate, note=note)


def image_loss(given: str, image: Image, value, is_mean: bool) -> Loss:
    """What becomes of an image that is not linked, by the value that stands in, or None."""
    file = Sentence("image {file}", file=image.file)
    if is_mean:
        return Loss(given, file, APPROXIMATED, Sentence("its mean, {value}, stands in; a material in Blender gets the image", value=shown(value)))
    return Loss(given, file, LOST, Sentence("left out") if value is None else Sentence("{value} stands in", value=shown(value)))


def film_limited(parameter: Parameter, value: float) -> Sentence:
    """That a film's parameter is not as it was given, but in its range."""
    return Sentence("a film's is {allowed}; it is {value:g}", allowed=parameter.allowed, value=value)


def metal_or_not(is_metal: bool) -> Sentence:
    """What becomes of a base that is metal in part."""
    return Sentence("a base is metal or not; it is metal") if is_metal else Sentence("a base is metal or not; it is diffuse")


@dataclass(frozen=True, eq=False, repr=False)
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

    @property
    def sentence(self) -> Sentence:
        """All of it in words."""
        lost = Sentence(", {share:.1f} % of it light that is lost", share=100.0 * self.lost_light) if self.lost_light > 0.0 else ""
        told = Sentence(
            "mean albedo {mean}, off by {off:.1e} at most; worst albedo error {worst:.3f}, seen at {angle:.0f} degrees; "
            "difference in soft light {difference:.1f} %{lost}; color off by CIEDE2000 {color:.2f}",
            mean=shown(self.mean),
            off=np.max(np.abs(self.mean_error)),
            worst=self.worst,
            angle=self.worst_theta_deg,
            difference=100.0 * self.soft_light,
            lost=lost,
            color=self.color_difference,
        )
        return Sentence("without the thin film: {match}", match=told) if self.without_film else told

    def __str__(self) -> str:
        return self.sentence


@dataclass(frozen=True)
class Report:
    """Losses of every parameter, and how far the converted material is off."""

    losses: tuple[Loss, ...]
    match: Match

    def of(self, fate: str) -> tuple[Loss, ...]:
        """The losses of one of FATES."""
        return tuple(loss for loss in self.losses if loss.fate == fate)

    @property
    def summary(self) -> Sentence:
        """One line: how many parameters met which fate, and the error."""
        kept, approximated, lost = (len(self.of(fate)) for fate in FATES)
        return Sentence(
            "{kept} kept, {approximated} approximated, {lost} lost; {match}", kept=kept, approximated=approximated, lost=lost, match=self.match.sentence
        )

    def lines(self) -> list[Sentence]:
        """Lost ones first, then the approximated and the kept, then the error."""
        return [*(loss.sentence for fate in reversed(FATES) for loss in self.of(fate)), self.match.sentence]
