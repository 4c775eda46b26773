# SPDX-License-Identifier: GPL-3.0-or-later
"""Lobes of many patches as few closures: where a surface has more than MAX_CLOSURES, lobes of about one width are pooled.

A pool is one lobe of its members' weights together, as wide, tilted and rough as they are in the mean by weight. Which lobes
share a pool does not depend on live values, and no two of one patch do: so where masks are 0 or 1, and one patch is seen,
all is as it is alone. Between, colors stay, and energy to what tests/reference_py/test_pools.py allows. Tables and bare Oren-Nayar
share pools; lobes with a Fresnel curve, with a normal of their own, and those of live tiers have their closures to themselves,
as their widths are not known before.
"""

from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import Any

import numpy as np

from ..material.coverage import Patch
from ..material.schema import NORMAL
from ..optics.diffuse import oren_nayar_albedo
from .live_grid import LiveLobes
from .live_tables import LiveTables
from .lobe import DiffuseLobe, GlossyLobe
from .view_table import TableLobes

# What OptiX's pool of closures holds, and what a shader may have unless its user asks for more.
MAX_CLOSURES = 8
# Of stock nodes, of which Cycles takes 64.
MAX_NODE_CLOSURES = 32
_ONE_VIEW = np.full(1, 0.7)
_OREN_NAYAR = "oren_nayar"

Pool = tuple[str, int]
"""The distribution, or that it is Oren-Nayar, and a number."""


Energy = Callable[[np.ndarray, np.ndarray, str], np.ndarray]
"""Energy (...) of a glossy closure of weight 1, for cosines and alphas (...) and a distribution."""


def pools_of(parts: Sequence[tuple[Patch, Any]], most: int = MAX_CLOSURES) -> Mapping[tuple[int, int], Pool]:
    """The pool of each lobe that shares one, by the numbers of its patch and of the lobe; nothing where there are at most `most`.

    `parts` are those of a `PatchLobes`.
    """
    alone: set[Hashable] = set()
    rough: list[tuple[int, int, int]] = []
    glossy: dict[str, dict[int, list[tuple[float, int]]]] = {}
    for number, (patch, part) in enumerate(parts):
        lobe_set = getattr(part, "lobe_set", part)
        for i, lobe in enumerate(lobe_set.lobes(_ONE_VIEW)):
            if not _may_share(patch, lobe_set, lobe):
                alone.add(_identity(patch, number, i, lobe))
            elif isinstance(lobe, DiffuseLobe):
                rough.append((number, i, int(np.mean(lobe.color) > 0.5)))
            else:
                glossy.setdefault(lobe.distribution, {}).setdefault(number, []).append((_width(lobe_set, i), i))
    count = sum(len(own) for lobes in glossy.values() for own in lobes.values())
    if len(alone) + len(rough) + count <= most:
        return {}
    found: dict[tuple[int, int], Pool] = {(number, i): (_OREN_NAYAR, which) for number, i, which in rough}
    left = most - len(alone) - len(set(found.values())) - len(glossy)
    for distribution, lobes in glossy.items():
        members = sum(map(len, lobes.values()))
        fewest = max(map(len, lobes.values()))
        room = max(1 + max(left, 0) * members // max(count, 1), fewest)
        for place, pool in _by_width(lobes, room).items():
            found[place] = (distribution, pool)
    return found


def _may_share(patch: Patch, lobe_set, lobe) -> bool:
    if any(element.has(NORMAL) for element in (*patch.stack.layers, patch.stack.base)):
        return False
    if isinstance(lobe, DiffuseLobe):
        return lobe.color is not None and not isinstance(lobe_set, TableLobes) and not patch.layers
    return isinstance(lobe_set, TableLobes | LiveLobes | LiveTables) and lobe.fresnel is None and lobe.frame is None


def _identity(patch: Patch, number: int, i: int, lobe) -> Hashable:
    """Equal for lobes of patches that are one closure anyway: Lambert, and the top of the same layer."""
    if isinstance(lobe, DiffuseLobe):
        return "diffuse" if lobe.color is None and lobe.ramp is None else (number, i)
    return ("top", patch.layers[0]) if lobe.fresnel is not None and i == 0 and patch.layers else (number, i)


def _width(lobe_set, i: int) -> float:
    """How wide a lobe is, as roughness, in the mean over views and live values: a needle is far from what is twice as wide."""
    if isinstance(lobe_set, LiveLobes | LiveTables):
        lobes = lobe_set.grid if isinstance(lobe_set, LiveLobes) else lobe_set.tables
        return float(np.mean(lobes[i].shape[..., :2]))
    return float(np.mean(np.sqrt(lobe_set.tables[i].shape[:, :2])))


def _by_width(lobes: Mapping[int, list[tuple[float, int]]], room: int) -> dict[tuple[int, int], int]:
    """Pools, at most `room`, divided at the widest gaps; of a patch's lobes that fall into one, the wider ones step on."""
    widths = np.array(sorted(width for own in lobes.values() for width, _ in own))
    bounds = np.sort(widths[1:][np.argsort(-np.diff(widths), kind="stable")[: room - 1]]) if room > 1 else np.zeros(0)
    found = {}
    for number, own in lobes.items():
        taken: list[int] = []
        for left, (width, i) in zip(range(len(own), 0, -1), sorted(own)):
            pool = max(int(np.searchsorted(bounds, width, side="right")), taken[-1] + 1 if taken else 0)
            taken.append(min(pool, room - left))
            found[number, i] = taken[-1]
    return found


def pooled(members: Sequence[GlossyLobe | DiffuseLobe], cos_theta_o: np.ndarray, energy: Energy | None) -> GlossyLobe | DiffuseLobe:
    """The one lobe of a pool's members at views of cosine cos_theta_o (...); without `energy`, that of closures of weight 1, glossy weights are summed as they are."""
    weights = [np.asarray(lobe.weight) for lobe in members]
    energies = [np.mean(weight, axis=-1) for weight in weights]
    total = np.maximum(sum(energies), 1e-20)

    def mean(values):
        return sum(own * np.asarray(value) for own, value in zip(energies, values)) / total

    first = members[0]
    if isinstance(first, DiffuseLobe):
        # the weights of a bare base do not depend on the view
        sigma_deg = float(np.mean(mean([lobe.sigma_deg for lobe in members])))
        cos_o, color = np.asarray(cos_theta_o, float), np.array(first.color)
        reflected = sum(weight * oren_nayar_albedo(cos_o, color, lobe.sigma_deg, lobe.power) for weight, lobe in zip(weights, members))
        return DiffuseLobe(reflected / oren_nayar_albedo(cos_o, color, sigma_deg, first.power), first.color, sigma_deg, first.power)
    alpha_x, alpha_y = mean([lobe.alpha_x for lobe in members]), mean([lobe.alpha_y for lobe in members])
    tilt = np.arctan(mean([np.tan(lobe.tilt) for lobe in members]))
    weight = sum(weights)
    if energy is not None:
        weight = sum(w * _unit(energy, lobe.alpha_x, lobe.alpha_y, cos_theta_o, first.distribution) for w, lobe in zip(weights, members))
        weight = weight / _unit(energy, alpha_x, alpha_y, cos_theta_o, first.distribution)
    return GlossyLobe(first.distribution, weight, alpha_x, alpha_y, tilt)


def _unit(energy: Energy, alpha_x, alpha_y, cos_theta_o, distribution: str) -> np.ndarray:
    """The energy (..., 1) of a closure of weight 1."""
    return np.maximum(energy(cos_theta_o, np.sqrt(np.asarray(alpha_x) * alpha_y), distribution)[..., None], 1e-3)
