# SPDX-License-Identifier: GPL-3.0-or-later
"""Networks of stacks with covered layers: the mixture of the networks of the patches (`coverage`), in every tier.

Shares stay live in every shader, a baked one too, since patches are baked whole and mixed at shading time. What tables
over the view cannot hold (`unbaked`) makes a tier that bakes fall back to a live one.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from inspect import signature

import numpy as np

from ..coverage import Patch, patches
from ..schema import THIN_FILM
from ..stack import Stack
from .analytic import AnalyticNetwork
from .choice import AutoNetwork
from .cost import cost
from .featured import featured_analytic
from .grid import GridNetwork
from .lobe import DiffuseLobe, GlossyLobe, SchlickCurve
from .memory import ALWAYS_LIVE
from .table import TableNetwork
from .unbaked import needs_live, unbaked, without_unbaked

# What OptiX's pool holds, and what a shader may have unless its user asks for more.
MAX_CLOSURES = 8


class PatchNetwork:
    """The networks of a stack's patches; lobes that differ in their weight alone are one."""

    def __init__(self, stack: Stack, parts: Sequence[tuple[Patch, object]]):
        self.stack, self.parts = stack, tuple(parts)

    @property
    def tier(self) -> str:
        return self.parts[0][1].tier

    @property
    def resolved(self) -> "PatchNetwork":
        return self

    @property
    def reason(self) -> str:
        """Why the parts are what they are, each reason once."""
        return "; ".join(dict.fromkeys(network.reason for _, network in self.parts))

    @property
    def lobe_count(self) -> int:
        return len(self.lobes(np.ones(1)))

    def lobes(self, cos_theta_o: np.ndarray, phi: np.ndarray | float = 0.0) -> list[GlossyLobe | DiffuseLobe]:
        """The lobes for views of cosine cos_theta_o (...) and azimuth phi (...); weights are (..., 3)."""
        scaled = [
            replace(lobe, weight=patch.share * np.asarray(lobe.weight))
            for patch, network in self.parts
            if patch.share > 0.0
            for lobe in network.lobes(cos_theta_o, phi)
        ]
        return merged(scaled)

    def packed(self) -> list:
        """The parts as JSON's types, for `PatchTier.remember`."""
        return [network.packed() for _, network in self.parts]


def merged(lobes: Sequence[GlossyLobe | DiffuseLobe]) -> list[GlossyLobe | DiffuseLobe]:
    """The lobes with weights of equal ones summed, in order of their first."""
    result: list[GlossyLobe | DiffuseLobe] = []
    for lobe in lobes:
        for i, other in enumerate(result):
            if _is_same(lobe, other):
                result[i] = replace(other, weight=other.weight + lobe.weight)
                break
        else:
            result.append(lobe)
    return result


def _is_same(a, b) -> bool:
    """Whether two lobes differ in their weight alone."""
    if type(a) is not type(b):
        return False
    if isinstance(a, DiffuseLobe):
        return (a.sigma_deg, a.power) == (b.sigma_deg, b.power) and (a.color is None) == (b.color is None) and np.all(np.equal(a.color, b.color))
    if (a.distribution, a.frame) != (b.distribution, b.frame) or type(a.fresnel) is not type(b.fresnel) or isinstance(a.fresnel, SchlickCurve):
        return False
    shapes = ((a.alpha_x, b.alpha_x), (a.alpha_y, b.alpha_y), (a.tilt, b.tilt))
    return a.fresnel == b.fresnel and all(np.all(np.asarray(x) == np.asarray(y)) for x, y in shapes)


def holds_values(network) -> bool:
    """Whether the shader of a network holds a stack's values."""
    parts = [part for _, part in network.parts] if isinstance(network, PatchNetwork) else [network]
    return any(isinstance(part.resolved, TableNetwork | GridNetwork) for part in parts)


def tiers_of(network) -> set[str]:
    """The tiers that a network is really told by."""
    parts = [part for _, part in network.parts] if isinstance(network, PatchNetwork) else [network]
    return {part.resolved.tier for part in parts if not isinstance(part.resolved, TableNetwork)}


def estimated_error(network) -> float | None:
    """The worst estimated error of what the tier auto chose, as a share of the light; None where nothing was estimated."""
    parts = [part for _, part in network.parts] if isinstance(network, PatchNetwork) else [network]
    films = any(element.has(THIN_FILM) for element in (*network.stack.layers, network.stack.base))
    if films or not all(isinstance(part, AutoNetwork) for part in parts):
        return None
    return max(part.choice.chosen.seen for part in parts)


def estimated_cost(network) -> float:
    """What a network costs, in units of a plain glossy node's, see `cost.cost`; that of the dearest of its patches."""
    parts = [part for _, part in network.parts] if isinstance(network, PatchNetwork) else [network]
    return max(part.choice.chosen.cost if isinstance(part, AutoNetwork) else cost(part) for part in parts)


class PatchTier:
    """A tier that takes stacks with covered layers too. Made of the tier's network class, and used in its place."""

    def __init__(self, network: type):
        self._network, self.tier = network, network.tier
        self._may_hold = "live" in signature(network).parameters

    def __call__(self, stack: Stack, progress: Callable[[float], None] | None = None, **options):
        """The network of a stack, see the class. Raises LaminaError for too many covered layers."""
        parts = self._parts(stack, options)
        made = []
        for done, (patch, own) in enumerate(parts):
            if progress is not None:
                own["progress"] = lambda share, done=done: progress((done + share) / len(parts))
            made.append((patch, self._made(patch.stack, own)))
        return made[0][1] if len(made) == 1 else PatchNetwork(stack, made)

    def _made(self, stack: Stack, options: dict):
        if not unbaked(stack) or (not self._may_hold and self._network is not AnalyticNetwork):
            return self._network(stack, **options)
        if not self._may_hold:
            return featured_analytic(stack)
        # what is chosen for the plain stack, which has a truth that is quick to compute, is made of the whole one
        network = self._network(without_unbaked(stack), **options)
        live = featured_analytic if isinstance(network.resolved, AnalyticNetwork) else type(network.resolved)
        network.stack, network.resolved = stack, live(stack)
        if any(element.has(THIN_FILM) for element in (*stack.layers, stack.base)):
            network.reason = f"{network.resolved.tier}, the one tier that knows thin films"
        elif self._network is AutoNetwork:
            network.reason += f"; errors are those without {needs_live(stack)}"
        return network

    def key(self, stack: Stack, **options) -> str:
        """What the network is remembered by; coverages do not matter."""
        return "\n".join(self._network.key(without_unbaked(patch.stack), **own) for patch, own in self._parts(stack, options))

    def is_known(self, stack: Stack, **options) -> bool:
        """Whether making the network takes no time."""
        return all(self._network.is_known(without_unbaked(patch.stack), **own) for patch, own in self._parts(stack, options))

    def remember(self, key: str, stack: Stack, data) -> None:
        """Remember what the network's `packed` gave in another process."""
        parts = patches(stack)
        for patch, own_key, own in zip(parts, key.split("\n"), data if len(parts) > 1 else [data]):
            self._network.remember(own_key, without_unbaked(patch.stack), own)

    def _parts(self, stack: Stack, options: dict) -> list[tuple[Patch, dict]]:
        if not self._may_hold:
            return [(patch, dict(options)) for patch in patches(stack)]
        default = signature(self._network).parameters["glossy"].default
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
