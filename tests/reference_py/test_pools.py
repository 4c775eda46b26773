# SPDX-License-Identifier: GPL-3.0-or-later
"""Pools: eight masks are at most eight closures, one patch alone is as it was, and the albedo stays."""

from dataclasses import replace

import numpy as np
import pytest
from support.pools import PAINTS
from support.stacks import stack

from lamina.reference_py.lobes.analytic.interface_tables import closure_energy
from lamina.reference_py.lobes.closure import lobe_energy
from lamina.reference_py.lobes.lobe import DiffuseLobe, GlossyLobe
from lamina.reference_py.lobes.methods import make_lobe_set
from lamina.reference_py.lobes.patch_lobes import merged
from lamina.reference_py.lobes.pools import MAX_CLOSURES, pooled
from lamina.reference_py.material.coverage import patches

VIEWS = np.cos(np.radians([5.0, 30.0, 55.0, 75.0]))
METALS = [{"kind": "conductor", "metal": m, "roughness": r} for m, r in zip(("gold", "copper", "iron", "silver"), (0.05, 0.9, 0.3, 0.6))] * 2
IRON = {"kind": "conductor", "metal": "iron", "roughness": 0.1}


@pytest.fixture(scope="module", params=["metals", "paints"])
def made(request):
    layers = [{**METALS[i], "roughness": METALS[i]["roughness"] + 0.08 * (i > 3)} for i in range(8)] if request.param == "metals" else PAINTS
    return layers, make_lobe_set(stack(*({**layer, "coverage": 0.5} for layer in layers), base=IRON), "auto")


def at(made, masks):
    """The lobe set at these masks, and its patches' own lobes, each with its share."""
    layers, whole = made
    parts = patches(stack(*({**layer, "coverage": mask} for layer, mask in zip(layers, masks)), base=IRON))
    mixed = replace(whole.lobe_set, parts=tuple((patch, part) for patch, (_, part) in zip(parts, whole.lobe_set.parts)))
    return mixed, [(patch.share, part.lobes(VIEWS)) for patch, (_, part) in zip(parts, whole.lobe_set.parts)]


def energy(lobes):
    return sum(lobe_energy(lobe, VIEWS) for lobe in lobes)


@pytest.mark.parametrize("masks", [(0.5,) * 8, (0.5, 0, 0, 0, 1, 1, 0.5, 1), (0, 0.5, 0, 0.5, 0, 0.5, 0, 0.5), (0.5, 0, 0, 0, 0, 0, 0.5, 1)])
def test_closures_are_few_and_the_albedo_stays(made, masks):
    mixed, parts = at(made, masks)
    lobes = mixed.lobes(VIEWS)
    expected = sum(share * energy(own) for share, own in parts if share > 0.0)
    assert len(lobes) <= MAX_CLOSURES < sum(map(len, (own for _, own in parts)))
    assert np.abs(energy(lobes) / expected - 1.0).max() < 0.003


@pytest.mark.parametrize("seen", range(0, 9, 2))
def test_a_patch_that_is_seen_alone_is_as_it_is_alone(made, seen):
    mixed, parts = at(made, [float(i == seen) for i in range(8)])
    alone, shown = (sorted(lobes, key=lambda lobe: np.mean(lobe.weight)) for lobes in (merged(parts[seen][1]), mixed.lobes(VIEWS)))
    for lobe, own in zip(shown, alone, strict=True):
        for name in ("weight", "alpha_x", "alpha_y", "tilt", "sigma_deg"):
            if hasattr(own, name):
                assert getattr(lobe, name) == pytest.approx(np.broadcast_to(getattr(own, name), np.shape(getattr(lobe, name))), rel=1e-9, abs=1e-12)


def test_unequal_lobes_keep_their_energy():
    """Without the closures' energies it is more than 4 % off at the worst view."""
    narrow, wide = (GlossyLobe("ggx", np.full((4, 3), 0.5), np.full(4, alpha), np.full(4, alpha)) for alpha in (0.05, 0.9))
    expected = energy([narrow, wide])
    assert energy([pooled([narrow, wide], VIEWS, closure_energy)]) == pytest.approx(expected, rel=0.01)
    assert np.abs(energy([pooled([narrow, wide], VIEWS, None)]) / expected - 1.0).max() > 0.04


def test_oren_nayar_keeps_its_energy():
    rough = [DiffuseLobe(np.full(3, 0.4), (1e-5,) * 3, sigma) for sigma in (5.0, 70.0)]
    assert energy([pooled(rough, VIEWS, closure_energy)]) == pytest.approx(energy(rough), rel=1e-3)
