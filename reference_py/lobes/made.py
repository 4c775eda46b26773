# SPDX-License-Identifier: GPL-3.0-or-later
"""What a lobe set is to its users, what a method may be asked for, and what it makes."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ..material.place import Place
from ..material.qualities import DEFAULT_TOLERANCE
from ..material.stack import Stack
from .lobe import DiffuseLobe, GlossyLobe


class LobeSet(Protocol):
    """What Cycles is told about a stack: lobes that depend on the view alone."""

    @property
    def name(self) -> str:
        """The method whose lobes they are."""
        ...

    @property
    def is_live(self) -> bool:
        """Whether its shader computes with the values themselves, which tables hold."""
        ...

    @property
    def followed(self) -> tuple[Place, ...]:
        """Values that tables follow beside."""
        ...

    def with_values_of(self, stack: Stack) -> "LobeSet":
        """The same for a stack's own live values."""
        ...

    @property
    def lobe_count(self) -> int:
        """How many closures they are."""
        ...

    def lobes(self, cos_theta_o: np.ndarray, phi: np.ndarray | float = 0.0) -> list[GlossyLobe | DiffuseLobe]:
        """The lobes for views of cosine cos_theta_o (...) and azimuth phi (...); weights are (..., 3)."""
        ...


@dataclass(frozen=True)
class Options:
    """How a lobe set is to be made."""

    live: tuple[Place, ...] = ()
    """Values that a texture or an animation gives: shaders that hold values must not hold these."""
    tolerance: float = DEFAULT_TOLERANCE
    """Largest visible error that the method auto may choose, as a share of the light."""
    glossy: int | None = None
    """Most glossy lobes of a bake; None is the method's own."""
    progress: Callable[[float], None] | None = None
    """Gets the share done and may raise to cancel."""

    def report(self, share: float) -> None:
        """Tell `progress`, if there is one, the share done."""
        if self.progress is not None:
            self.progress(share)


@dataclass(frozen=True)
class Candidate:
    """One way to tell Cycles: closures, estimated cost in units of a plain glossy node's, errors as shares of the light.

    `albedo` is the worst view's, `soft_light` and `shape` are means over the views; all of the worst channel.
    """

    label: str
    closures: int
    cost: float
    albedo: float
    soft_light: float
    shape: float

    @property
    def visible(self) -> float:
        """The error that is seen, which the tolerance bounds: the larger of albedo's and soft light's."""
        return max(self.albedo, self.soft_light)

    def __str__(self) -> str:
        return f"{self.label}, error {100.0 * self.visible:.3g} %, cost {self.cost:.2g}x"


@dataclass(frozen=True)
class Choice:
    """What was chosen and its lobe set, what was tried, why as a sentence, and what stock nodes have."""

    chosen: Candidate
    lobe_set: LobeSet
    tried: tuple[Candidate, ...]
    reason: str
    stock: Candidate

    def shown(self, osl: bool) -> Candidate:
        """What shows with OSL, or in stock nodes."""
        return self.chosen if osl else self.stock


@dataclass(frozen=True)
class Made:
    """A lobe set, the stack that it is of, the name of the method that was asked for it, and why it is what it is."""

    method: str
    stack: Stack
    lobe_set: LobeSet
    reason: str = ""
    choice: Choice | None = None
    """What the method auto tried and chose; None of other methods, and of several patches."""
    stands_in: bool = False
    """Whether it is there until another is computed, so that a quick start counts for more than a quick render."""

    @property
    def lobe_count(self) -> int:
        """How many closures the lobes are."""
        return self.lobe_set.lobe_count

    def lobes(self, cos_theta_o: np.ndarray, phi: np.ndarray | float = 0.0) -> list[GlossyLobe | DiffuseLobe]:
        """The lobes for views of cosine cos_theta_o (...) and azimuth phi (...); weights are (..., 3)."""
        return self.lobe_set.lobes(cos_theta_o, phi)
