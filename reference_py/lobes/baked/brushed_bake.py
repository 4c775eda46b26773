# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes of layers with brushed surfaces, on them or below: the lobes of `analytic` as tables, with energies that walks give over the rotation.

No deterministic truth knows an azimuth. But how an albedo turns with it is smooth: walks from all views at once fit the few
coefficients of E(cos, psi) / E(cos), psi being the azimuth from the brushing and E(cos) the albedo of the isotropic stack, which `adding` knows.
Towards the normal a harmonic of 2 k psi fades as sin^2k, as it has to.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ...material.place import places
from ...material.schema import SCATTERING, THIN_FILM
from ...material.stack import Stack
from ...models.position_free import BATCH, PositionFree
from ...optics.diffuse import oren_nayar_albedo
from ...optics.frame import spherical
from ...optics.quadrature import points
from ..analytic import AnalyticLobes
from ..analytic.brushed import BrushedLobes
from ..brushing import directions, has_brushing, isotropic
from ..closure import lobe_energy
from ..own_normals import has_own_normals
from ..tabulate import tables_of
from ..truth import truth_of
from ..view_table import AZIMUTHS, KNOTS, DiffuseTable, GlossyTable, OrenNayarTable, TableLobes, interpolate, knot_cosines

# Polynomials in the root of the cosine for each harmonic of the azimuth. So many batches of walks leave .3 % of an albedo.
_POLYNOMIALS = (8, 6, 4, 3)
_BATCHES, _SEED = 32, 1
# No table is scaled by more, nor by less than the inverse.
_MOST = 4.0
# Of an albedo: walks are compared with no less.
_LEAST = 1e-4


def is_brushed(stack: Stack) -> bool:
    """Whether tables hold the stack's brushed surfaces: one direction, on layers, below them or bare, without films, media that scatter or own normals.

    A bare brushed metal needs a bake only to follow live values (`is_bare_brushed`).
    """
    others = any(element.has(feature) for _, element in places(stack) for feature in (THIN_FILM, SCATTERING))
    return has_brushing(stack) and len(directions(stack)) == 1 and not others and not has_own_normals(stack)


def brushed(stack: Stack, progress: Callable[[float], None] | None = None) -> TableLobes:
    """The lobe set of a stack of which `is_brushed` is true."""
    axis = directions(stack).pop()
    return _carrying(tables_of(BrushedLobes(stack)), _energies(stack, axis, progress or (lambda share: None)), axis)


def level(stack: Stack) -> TableLobes:
    """The same for a stack without brushing, by whose shapes those of `brushed` are judged."""
    views = spherical(np.arccos(knot_cosines()), 0.0)
    return _carrying(tables_of(AnalyticLobes(stack)), truth_of(stack).albedo(views), None)


def _carrying(tables: list, wanted: np.ndarray, axis: float | None) -> TableLobes:
    """Tables whose energies together are `wanted`, (AZIMUTHS, KNOTS, 3) about an axis or, without one, (KNOTS, 3)."""
    tables, cosines = [plain(table) for table in tables], knot_cosines()
    # what a top that is not brushed reflects is exact
    exact = [isinstance(t, GlossyTable) and t.fresnel is not None and t.frame is None and t.axis is None for t in tables]

    def energy(which: bool, phi: float) -> np.ndarray:
        return sum((lobe_energy(t.lobe(cosines, phi), cosines, phi) for t, e in zip(tables, exact) if e == which), np.zeros((KNOTS, 3)))

    def around(which: bool) -> np.ndarray:
        return energy(which, 0.0) if axis is None else np.stack([energy(which, axis + psi) for psi in np.arccos(AZIMUTHS)])

    rest = np.maximum(wanted - around(True), 0.0)
    ratio = np.clip(rest / np.maximum(around(False), 1e-9), 1.0 / _MOST, _MOST)
    return TableLobes(tuple(t if e else replace(t, weight=t.weight * ratio, axis=axis) for t, e in zip(tables, exact)))


def plain(table):
    """An Oren-Nayar lobe as a Lambert lobe of its energy, which scripts with tables know."""
    if not isinstance(table, OrenNayarTable):
        return table
    return DiffuseTable(oren_nayar_albedo(knot_cosines(), table.weight, table.sigma_deg, table.power), table.axis, table.normal)


def _energies(stack: Stack, axis: float, report: Callable[[float], None]) -> np.ndarray:
    """Albedos (AZIMUTHS, KNOTS, 3) by walks."""
    level = truth_of(isotropic(stack)).albedo(spherical(np.arccos(knot_cosines()), 0.0))
    return level * ratios([stack], level[None], np.ones((1, 1)), AZIMUTHS, report)[0]


def ratios(stacks: Sequence[Stack], levels: np.ndarray, terms: np.ndarray, turned: np.ndarray, report: Callable[[float], None]) -> np.ndarray:
    """Albedos of brushed stacks over those without brushing, `levels` (n, KNOTS, 3), for cosines (a,) of azimuths from the brushing: (n, a, KNOTS, 3).

    Every coefficient is a sum of the columns of `terms` (n, m), each times a number that walks give. All are brushed along one axis.
    """
    cosines, levels = knot_cosines(), np.maximum(levels, _LEAST)
    axis, rng, count = directions(stacks[0]).pop(), np.random.default_rng(_SEED), round(_BATCHES * terms.shape[1] ** 0.5)
    order = np.concatenate([rng.permutation(len(stacks)) for _ in range(-(-count // len(stacks)))])[:count]
    models = {i: PositionFree(stacks[i]) for i in dict.fromkeys(order)}
    gram, right = 0.0, 0.0
    for done, i in enumerate(order):
        root, turn = ((place + shift) % 1.0 for place, shift in zip(points(BATCH), rng.random(2)))
        cos_o, psi = np.maximum(np.square(root), cosines[0]), 2.0 * np.pi * turn
        basis = _basis(root, psi)
        share = models[i].walked(spherical(np.arccos(cos_o), axis + psi), rng) / interpolate(levels[i], cos_o)
        gram = gram + np.kron(np.outer(terms[i], terms[i]), basis.T @ basis)
        right = right + np.kron(terms[i][:, None], basis.T @ share)
        report((done + 1) / count)
    coefficients = np.linalg.solve(gram, right).reshape(terms.shape[1], -1, 3)
    views = np.stack([_basis(np.sqrt(cosines), np.full(KNOTS, psi)) for psi in np.arccos(turned)])
    return np.einsum("nm,akb,mbc->nakc", terms, views, coefficients)


def _basis(root: np.ndarray, psi: np.ndarray) -> np.ndarray:
    """(n, functions) at roots of cosines (n,) and azimuths (n,) from the axis: of the first harmonics alone, none has a direction along the normal."""
    polynomials, sin2 = np.polynomial.legendre.legvander(2.0 * root - 1.0, max(_POLYNOMIALS) - 1), 1.0 - root**4
    return np.concatenate([polynomials[:, :count] * (sin2**k * np.cos(2.0 * k * psi))[:, None] for k, count in enumerate(_POLYNOMIALS)], axis=1)
