# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes of a bare metal over its live values: what is reflected once is a closure with the metal's own curve, what is reflected more often a lobe as wide and a Lambert lobe with a ramp."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import reduce

import numpy as np

from ...material.place import Place
from ...material.stack import Stack
from ...optics.bases import ConductorBase
from ...optics.interface import Microfacets
from ...optics.optical_stack import OpticalStack
from ..closure import lobe_f, unit_energy
from ..diffuse_ramp import RAMP_COSINES, ramp_f, ramp_of
from ..live_grid import LiveLobes
from ..lobe import ConductorCurve, GlossyLobe
from ..samples import Views, truth_at, view_of
from ..view_table import KNOTS, DiffuseTable, GlossyTable, TableLobes, interpolate, knot_cosines
from .base_ramp import with_ramp
from .fit_lobes import non_negative
from .grid_energies import stacks_of, told
from .live import axes_of, bake_live, computed_of
from .make_grid import grid_of
from .side_by_side import groups, in_groups

# Directions of an energy, as rings and places on each: six times as many move it by 8e-4 of the light at most.
_RULE = (64, 16)
# Points of each strategy at a view.
_POINTS = 96
# An f below this share of the albedo counts as if it were that.
_FLOOR_OF_ALBEDO = 0.001


def is_bare_metal(stack: Stack, live: tuple[Place, ...]) -> bool:
    """Whether a stack over live values is a rough metal alone, neither filmed nor brushed."""
    base = OpticalStack.of(stack).base
    is_plain = not stack.layers and isinstance(base, ConductorBase) and base.film is None and base.facets.anisotropic is None
    return is_plain and (Place(None, "roughness") in live or not base.is_specular)


def bake_metal(stack: Stack, live: tuple[Place, ...], glossy: int, report: Callable[[float], None]) -> LiveLobes:
    """The lobes of a bare metal over live values of its own, and what stock nodes have in their place, of so many glossy lobes.

    `report` gets the share done and may raise to cancel.
    """
    axes = axes_of(stack, live)
    assert axes is not None, "see follows"

    def at(coordinates: Sequence[float]) -> Stack:
        return reduce(lambda here, part: part[0].at(here, part[1]), zip(axes, coordinates), stack)

    knots = [axis.knots.knots[axis.before :] for axis in axes]
    places = list(np.ndindex(*map(len, knots)))
    stacks, nodes = [at([float(values[i]) for values, i in zip(knots, node)]) for node in places], {}
    for members, truth in groups(stacks):
        seen = truth_at(truth, knot_cosines(), [Microfacets.of(stacks[members[0]].base).alpha], _POINTS)
        nodes |= {places[i]: _tables(stacks[i], replace(seen, f=f)) for i, f in zip(members, np.split(seen.f, len(members), axis=-1))}
        report(0.2 * len(nodes) / len(places))
    sampled = [computed_of(axis, axes) for axis in axes]
    size = tuple(scale.count for scale in sampled)

    def energies(truth, count: int) -> list[np.ndarray]:
        once = unit_energy(_once(truth.stack), knot_cosines(), rule=_RULE)
        albedo = truth.albedo(np.stack([view_of(c) for c in knot_cosines()]))
        return np.split(np.stack([albedo, np.maximum(albedo - once, 0.0)]), count, axis=-1)

    albedos, more_often = np.moveaxis(np.array(in_groups(stacks_of(sampled, at), energies)), 1, 0).reshape(2, *size, KNOTS, 3)
    found, coefficients = told(axes, sampled, {"fitted": more_often})
    report(0.4)
    stock = bake_live(stack, live, glossy, lambda share: report(0.4 + 0.6 * share), albedos)
    return replace(with_ramp(grid_of(stack, axes, nodes, found, coefficients)), stock=stock)


def _once(stack: Stack) -> GlossyLobe:
    """What is reflected once."""
    alpha = np.full(KNOTS, Microfacets.of(stack.base).alpha)
    return GlossyLobe(stack.base["distribution"], np.ones(3), alpha, alpha, fresnel=ConductorCurve.of(stack.base))


def _tables(stack: Stack, seen: Views) -> TableLobes:
    """The lobes of constant values, each of its own energy, of what is seen at the knots of the view."""
    once = _once(stack)
    wo, cos_i = seen.wo[:, None], seen.wi[..., 2]
    shape = np.stack([once.alpha_x, once.alpha_y, np.zeros(KNOTS)], axis=-1)
    known, wide = (GlossyTable(once.distribution, np.ones((KNOTS, 3)), shape, curve) for curve in (once.fresnel, None))
    first, column = (lobe_f(table.lobe(seen.cos_theta_o[:, None]), wo, seen.wi) for table in (known, wide))
    goal = seen.f - first
    # what was reflected often goes as it comes: by turns with the weights its light was tried, and in some nodes found an end far from its neighbours'
    left = np.maximum(np.sum(seen.share[..., None] * goal, axis=1), 0.0)
    columns = np.stack([column, ramp_f(ramp_of(interpolate(left, RAMP_COSINES)), cos_i)])
    measure = seen.share[..., None] / np.maximum(seen.f, _FLOOR_OF_ALBEDO * np.sum(seen.share[..., None] * seen.f, axis=1)[:, None])
    gram, moments = np.einsum("avqc,bvqc->vcab", measure * columns, columns), np.einsum("avqc,vqc->vca", measure * columns, goal)
    weight = non_negative(gram, moments)
    return TableLobes((known, GlossyTable(once.distribution, weight[..., 0], shape), DiffuseTable(weight[..., 1])))
