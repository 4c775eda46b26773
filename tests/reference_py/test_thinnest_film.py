# SPDX-License-Identifier: GPL-3.0-or-later
"""From which thickness on a film is one, and what thin films do: nothing that is seen comes or goes at once."""

import numpy as np
import pytest
from support.stacks import coat, conductor, lambert, stack

from lamina.reference_py.network import WeidlichWilkieNetwork
from lamina.reference_py.network.lobe import DielectricCurve, FilmCurve
from lamina.reference_py.optics.fresnel import fresnel_dielectric
from lamina.reference_py.optics.material import film_of, interfaces

COSINES = np.cos(np.radians([0.0, 50.0, 75.0]))


def filmed(nm, ior=2.0):
    return stack(coat(0.2, film_thickness=nm, film_ior=ior), base=lambert(0.0))


def reflectance(nm):
    return interfaces(filmed(nm))[0].reflectance(COSINES)


@pytest.mark.parametrize("nm, there", [(0.0, False), (0.05, False), (0.1, False), (0.11, True), (1.0, True), (5.0, True), (19.0, True), (300.0, True)])
def test_a_tenth_of_a_nanometre_is_the_thinnest_film(nm, there):
    """Cycles' own threshold, for layers and metals alike, and for closures."""
    metal = stack(base={**conductor(0.2, 3.9, 0.2), "film_thickness": nm, "film_ior": 2.0})
    for element in (filmed(nm).layers[0], metal.base):
        film = film_of(element)
        assert (film is not None) == there
        assert film is None or (film.thickness_nm, film.ior) == (nm, 2.0)
    assert isinstance(WeidlichWilkieNetwork(filmed(nm)).lobes(COSINES)[0].fresnel, FilmCurve if there else DielectricCurve)


def test_a_film_comes_gradually():
    """From none to 60 nm, every quarter of a nanometre changes a reflectance by less than .15 % of the light."""
    values = np.stack([np.broadcast_to(reflectance(nm), (3, 3)) for nm in np.arange(0.0, 60.0, 0.25)])
    assert values[0] == pytest.approx(fresnel_dielectric(COSINES, 1.5)[:, None] * np.ones(3))
    assert np.abs(np.diff(values, axis=0)).max() < 1.5e-3
    # and at the threshold less than a screen shows
    assert reflectance(0.11) == pytest.approx(reflectance(0.09) * np.ones(3), abs=1e-4)


@pytest.mark.parametrize("nm", [5.0, 10.0, 15.0, 19.0])
def test_thin_films_reflect_as_airy_says(nm):
    """At the normal, green: the amplitudes of both sides with the phase between, in closed form at 545 nm. They add .003 to .035 to glass.

    Within .0002, as a channel is not one wavelength, and Cycles' table is linear in the thinnest films.
    """
    above, below = (1.0 - 2.0) / (1.0 + 2.0), (2.0 - 1.5) / (2.0 + 1.5)
    turn = np.exp(4j * np.pi * 2.0 * nm / 545.0)
    airy = abs((above + below * turn) / (1.0 + above * below * turn)) ** 2
    print(nm, airy, reflectance(nm)[0, 1])
    assert reflectance(nm)[0, 1] == pytest.approx(airy, abs=2.5e-4)
