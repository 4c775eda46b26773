# SPDX-License-Identifier: GPL-3.0-or-later
"""Lobe sets of stacks with covered layers: the mixture of the lobe sets of the patches (`coverage`), in every tier.

Shares stay live in every shader, a baked one too, since patches are baked whole and mixed at shading time. What tables
over the view cannot hold (`unbaked`) makes a tier that bakes fall back to a live one.
"""

from collections.abc import Callable
from inspect import signature

from ...material.coverage import Patch, patches
from ...material.schema import THIN_FILM
from ...material.stack import Stack
from ..analytic import AnalyticLobes
from ..cache import ALWAYS_LIVE
from ..live_grid import LiveLobes
from ..patch_lobes import PatchLobes
from ..view_table import TableLobes
from .auto import AutoLobes, cost
from .not_bakeable import needs_live, unbaked, without_unbaked
from .with_features import featured_analytic

# What OptiX's pool holds, and what a shader may have unless its user asks for more.
MAX_CLOSURES = 8


def holds_values(lobe_set) -> bool:
    """Whether the shader of a lobe set holds a stack's values."""
    parts = [part for _, part in lobe_set.parts] if isinstance(lobe_set, PatchLobes) else [lobe_set]
    return any(isinstance(part.resolved, TableLobes | LiveLobes) for part in parts)


def tiers_of(lobe_set) -> set[str]:
    """The tiers that a lobe set is really told by."""
    parts = [part for _, part in lobe_set.parts] if isinstance(lobe_set, PatchLobes) else [lobe_set]
    return {part.resolved.tier for part in parts if not isinstance(part.resolved, TableLobes)}


def estimated_error(lobe_set) -> float | None:
    """The worst estimated error of what the tier auto chose, as a share of the light; None where nothing was estimated."""
    parts = [part for _, part in lobe_set.parts] if isinstance(lobe_set, PatchLobes) else [lobe_set]
    films = any(element.has(THIN_FILM) for element in (*lobe_set.stack.layers, lobe_set.stack.base))
    if films or not all(isinstance(part, AutoLobes) for part in parts):
        return None
    return max(part.choice.chosen.seen for part in parts)


def estimated_cost(lobe_set) -> float:
    """What a lobe set costs, in units of a plain glossy node's, see `choice.cost`; that of the dearest of its patches."""
    parts = [part for _, part in lobe_set.parts] if isinstance(lobe_set, PatchLobes) else [lobe_set]
    return max(part.choice.chosen.cost if isinstance(part, AutoLobes) else cost(part) for part in parts)


class PatchTier:
    """A tier that takes stacks with covered layers too. Made of the tier's lobe set class, and used in its place."""

    def __init__(self, lobe_set: type):
        self._lobe_set, self.tier = lobe_set, lobe_set.tier
        self._may_hold = "live" in signature(lobe_set).parameters

    def __call__(self, stack: Stack, progress: Callable[[float], None] | None = None, **options):
        """The lobe set of a stack, see the class. Raises LaminaError for too many covered layers."""
        parts = self._parts(stack, options)
        made = []
        for done, (patch, own) in enumerate(parts):
            if progress is not None:
                own["progress"] = lambda share, done=done: progress((done + share) / len(parts))
            made.append((patch, self._made(patch.stack, own)))
        return made[0][1] if len(made) == 1 else PatchLobes(stack, made)

    def _made(self, stack: Stack, options: dict):
        if not unbaked(stack) or (not self._may_hold and self._lobe_set is not AnalyticLobes):
            return self._lobe_set(stack, **options)
        if not self._may_hold:
            return featured_analytic(stack)
        # what is chosen for the plain stack, which has a truth that is quick to compute, is made of the whole one
        lobe_set = self._lobe_set(without_unbaked(stack), **options)
        live = featured_analytic if isinstance(lobe_set.resolved, AnalyticLobes) else type(lobe_set.resolved)
        lobe_set.stack, lobe_set.resolved = stack, live(stack)
        if any(element.has(THIN_FILM) for element in (*stack.layers, stack.base)):
            lobe_set.reason = f"{lobe_set.resolved.tier}, the one tier that knows thin films"
        elif self._lobe_set is AutoLobes:
            lobe_set.reason += f"; errors are those without {needs_live(stack)}"
        return lobe_set

    def key(self, stack: Stack, **options) -> str:
        """What the lobe set is remembered by; coverages do not matter."""
        return "\n".join(self._lobe_set.key(without_unbaked(patch.stack), **own) for patch, own in self._parts(stack, options))

    def is_known(self, stack: Stack, **options) -> bool:
        """Whether making the lobe set takes no time."""
        return all(self._lobe_set.is_known(without_unbaked(patch.stack), **own) for patch, own in self._parts(stack, options))

    def remember(self, key: str, stack: Stack, data) -> None:
        """Remember what the lobe set's `packed` gave in another process."""
        parts = patches(stack)
        for patch, own_key, own in zip(parts, key.split("\n"), data if len(parts) > 1 else [data]):
            self._lobe_set.remember(own_key, without_unbaked(patch.stack), own)

    def _parts(self, stack: Stack, options: dict) -> list[tuple[Patch, dict]]:
        if not self._may_hold:
            return [(patch, dict(options)) for patch in patches(stack)]
        default = signature(self._lobe_set).parameters["glossy"].default
        parts = patches(stack)
        glossy = min(options.get("glossy", default), glossy_of_each(len(parts)))
        return [(patch, {**_options_of(patch, options), "glossy": glossy}) for patch in parts]


def glossy_of_each(count: int) -> int:
    """How many glossy lobes the bakes of `count` patches may have each, so that with one diffuse lobe all are within MAX_CLOSURES.

    At least one, which is more than that for the eight patches of three covered layers.
    """
    return max(1, (MAX_CLOSURES - 1) // count)


def _options_of(patch: Patch, options: dict) -> dict:
    """A patch's own options: live values are named by its layers, and those that are always live need no name."""
    places = {index: place for place, index in enumerate(patch.layers)} | {-1: -1}
    live = tuple((places[index], name) for index, name in options.get("live", ()) if index in places and name not in ALWAYS_LIVE)
    return {**options, "live": live + unbaked(patch.stack)}
