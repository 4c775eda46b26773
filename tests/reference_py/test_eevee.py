# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables for EEVEE: its own energies times their weights are the lobe set's energies."""

import numpy as np
import pytest

from lamina.reference_py.lobes.closure import lobe_energy
from lamina.reference_py.lobes.eevee import eevee_albedo, eevee_tables
from lamina.reference_py.lobes.lobe import DiffuseLobe, GlossyLobe
from lamina.reference_py.lobes.tabulate import tabulate
from lamina.reference_py.lobes.view_table import DiffuseTable, GlossyTable, knot_cosines
from lamina.reference_py.optics.diffuse import oren_nayar_albedo

# What Blender 5.2.2 rendered of white Glossy nodes (GGX) in a white world lies 0 to 1.6 % below, as it keeps light in 11 bits (study chart eevee).
MIRROR = 1.0


def test_a_smooth_lobe_loses_nothing_and_a_rough_one_more_than_in_cycles():
    cosines = np.array([1.0, 0.5, 0.1])
    assert eevee_albedo(1e-3, cosines) == pytest.approx([MIRROR] * 3, abs=1e-3)
    rough = GlossyLobe("ggx", np.ones(3), 0.5, 0.5, 0.0)
    here, there = eevee_albedo(0.5, cosines), lobe_energy(rough, cosines)[:, 0]
    assert np.all(here < there) and np.all(here > 0.7 * there)


class _Lobes:
    def __init__(self, *lobes):
        self._lobes = lobes

    def lobes(self, cos_theta_o, phi=0.0):
        return list(self._lobes)


@pytest.mark.parametrize("frame", [None, 0.3], ids=["isotropic", "brushed"])
def test_what_eevee_makes_of_a_weight_is_the_energy_of_the_lobe(frame):
    color = np.array([0.9, 0.5, 0.2])
    lobe = GlossyLobe("beckmann", color, 0.5, 0.1 if frame is not None else 0.4, 0.0, None, frame)
    (table,) = eevee_tables(_Lobes(lobe), tabulate(_Lobes(lobe))).tables
    assert isinstance(table, GlossyTable) and table.distribution == "ggx" and np.all(table.shape[:, 0] == table.shape[:, 1])
    for phi in (0.3, 0.3 + np.pi / 2) if frame is not None else (0.0,):
        made = table.lobe(knot_cosines(), phi).weight * eevee_albedo(table.shape[:, 0], knot_cosines())[:, None]
        assert made == pytest.approx(lobe_energy(lobe, knot_cosines(), phi), rel=1e-3)


def test_a_rough_diffuse_lobe_is_a_plain_one_of_its_energy():
    lobe = DiffuseLobe(np.ones(3), np.array([0.8, 0.4, 0.2]), 25.0)
    (table,) = eevee_tables(_Lobes(lobe), tabulate(_Lobes(lobe))).tables
    assert isinstance(table, DiffuseTable)
    assert table.weight == pytest.approx(oren_nayar_albedo(knot_cosines(), lobe.color, 25.0), rel=1e-6)
