# SPDX-License-Identifier: GPL-3.0-or-later
"""What a lobe set is to its users, what a method may be asked for, and what it makes."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ..material.place import Place
from ..material.stack import Stack
from .lobe import DiffuseLobe, GlossyLobe

DEFAULT_TOLERANCE = 0.02


class LobeSet(Protocol):
    """What Cycles is told about a stack: lobes that depend on the view alone."""

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
class Made:
    """A lobe set, the stack that it is of, the name of the method that was asked for it, and why it is what it is."""

    method: str
    stack: Stack
    lobe_set: LobeSet
    reason: str = ""
    choice: object = None
    """What the method auto tried and chose (`auto.Choice`); None of other methods, and of several patches."""

    @property
    def lobe_count(self) -> int:
        """How many closures the lobes are."""
        return self.lobe_set.lobe_count

    def lobes(self, cos_theta_o: np.ndarray, phi: np.ndarray | float = 0.0) -> list[GlossyLobe | DiffuseLobe]:
        """The lobes for views of cosine cos_theta_o (...) and azimuth phi (...); weights are (..., 3)."""
        return self.lobe_set.lobes(cos_theta_o, phi)
