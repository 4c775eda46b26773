# SPDX-License-Identifier: GPL-3.0-or-later
"""Tier `auto`: the cheapest way to tell Cycles about a stack whose error stays under a tolerance."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..stack import Stack
from .baking import MAX_GLOSSY, Baker
from .baking.memory import remembered, truth_of
from .judge import Errors, Judge, ball_cosines
from .lobe import DiffuseLobe, GlossyLobe
from .weidlich_wilkie import WeidlichWilkieNetwork

DEFAULT_TOLERANCE = 0.02


@dataclass(frozen=True)
class Candidate:
    """One way to tell Cycles, its errors, and its estimated cost in units of a plain glossy node's."""

    label: str
    network: object
    errors: Errors
    cost: float


@dataclass(frozen=True)
class Choice:
    """What was chosen, what was tried, and why as a sentence."""

    chosen: Candidate
    tried: tuple[Candidate, ...]
    reason: str


class AutoNetwork:
    """What `choose` chose for a stack with its default tolerance. Stacks of equal content share one choice in memory."""

    tier = "auto"

    def __init__(self, stack: Stack, progress: Callable[[float], None] | None = None):
        self.stack = stack
        self.choice = remembered(stack, ("auto",), lambda: choose(stack, truth_of(stack), progress=progress))
        self.resolved = self.choice.chosen.network

    @property
    def lobe_count(self) -> int:
        return self.resolved.lobe_count

    def lobes(self, cos_theta_o: np.ndarray) -> list[GlossyLobe | DiffuseLobe]:
        """The lobes for views of cosine cos_theta_o (...); weights are (..., 3)."""
        return self.resolved.lobes(cos_theta_o)


def choose(
    stack: Stack,
    truth,
    tolerance: float = DEFAULT_TOLERANCE,
    progress: Callable[[float], None] | None = None,
) -> Choice:
    """The cheapest candidate whose error over the pixels of a ball is at most `tolerance`, or the closest if none is.

    Candidates are tried from the cheapest; `progress` gets the share done and may raise to cancel.
    """
    report = progress or (lambda share: None)
    judge = Judge(stack, truth, ball_cosines())
    report(0.2)
    tried: list[Candidate] = []
    baker = Baker(stack, truth)
    makers = [("weidlich_wilkie", lambda: WeidlichWilkieNetwork(stack))]
    makers += [(f"baked, {k} glossy", lambda k=k: baker.bake(k).network) for k in range(1, MAX_GLOSSY + 1)]
    for done, (label, make) in enumerate(makers):
        network = make()
        tried.append(Candidate(label, network, judge.errors(network), cost(network)))
        report(0.2 + 0.8 * (done + 1) / len(makers))
        if tried[-1].errors.seen <= tolerance:
            break  # later ones cost more
    if tried[-1].errors.seen <= tolerance:
        chosen = tried[-1]
        reason = f"the cheapest whose error is at most {100.0 * tolerance:g} %"
    else:
        chosen = min(tried, key=lambda c: c.errors.seen)
        reason = f"the closest of {len(tried)}; none reaches {100.0 * tolerance:g} %"
    return Choice(chosen, tuple(tried), reason)


def cost(network) -> float:
    """An estimate of the CPU time of a frame-filling object over that of a plain glossy node, from its closures alone."""
    lobes = network.lobes(np.ones(1))
    diffuse = sum(isinstance(lobe, DiffuseLobe) for lobe in lobes)
    glossy = len(lobes) - diffuse
    return 0.85 + 0.28 * glossy + 0.1 * diffuse
