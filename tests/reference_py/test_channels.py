# SPDX-License-Identifier: GPL-3.0-or-later
"""Models on spectral stacks: any number of channels gives what each channel alone gives, or is refused in one line."""

from functools import cache

import numpy as np
import pytest

from lamina.reference_py.errors import LaminaError
from lamina.reference_py.lobes.methods import METHODS, make_lobe_set
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.models.adding import Adding
from lamina.reference_py.optics.colour import metal_index
from lamina.reference_py.optics.frame import spherical
from lamina.reference_py.optics.fresnel import fresnel_conductor
from lamina.reference_py.optics.optical_stack import USERS, OpticalStack
from lamina.reference_py.optics.spectral import gaussian_band, spectral_stack
from lamina.reference_py.registry import MODELS, make_model

CLOUDY = {"scatter_g": 0.3, "scatter_color": [0.6, 0.6, 0.6], "density": 0.5}
STACKS = {
    "glazed clay": {
        "layers": [{"kind": "dielectric", "ior": 1.5, "roughness": 0.4}, {"kind": "dielectric", "ior": 1.6, "roughness": 0.0}],
        "base": {"kind": "oren_nayar", "color": [0.8] * 3, "sigma_deg": 20.0},
    },
    "lacquered copper": {"layers": [{"kind": "dielectric", "ior": 1.5, "roughness": 0.0}], "base": {"kind": "conductor", "metal": "copper", "roughness": 0.4}},
    "mirror": {"layers": [{"kind": "dielectric", "ior": 1.5, "roughness": 0.0}], "base": {"kind": "conductor", "metal": "copper", "roughness": 0.0}},
    "bare": {"layers": [], "base": {"kind": "conductor", "metal": "gold", "roughness": 0.5}},
    "half covered": {"layers": [{"kind": "dielectric", "roughness": 0.4, "coverage": 0.5}], "base": {"kind": "lambert", "color": [0.5] * 3}},
}
OPTIONS = {"adding": {"nodes": 8, "modes": 8}, "position_free": {"walks": 200}}
SPECTRAL = [name for name in MODELS if USERS["model"][name].spectral]
WO = spherical(np.radians([20.0, 65.0]), [0.0, 1.0])
WI = spherical(np.radians([40.0, 50.0]), [3.0, 4.5])
NM = np.linspace(400.0, 700.0, 31)


@cache
def spectra(stack, channels):
    """`channels` wavelengths of a stack with an absorption band and a sloped base."""
    data = STACKS[stack]
    nm = NM[np.linspace(0, 30, channels).astype(int)] if channels > 1 else NM[15:16]
    return nm, lambda some: spectral_stack(
        Stack.from_dict(data),
        some,
        tints={0: np.exp(-gaussian_band(some, 450.0, 60.0, 1.5))} if data["layers"] else None,
        color=None if data["base"]["kind"] == "conductor" else 0.2 + (some - 400.0) / 500.0,
    )


@pytest.mark.slow
@pytest.mark.parametrize("channels", [1, 3, 31])
@pytest.mark.parametrize("stack", STACKS)
@pytest.mark.parametrize("name", SPECTRAL)
def test_many_channels_are_what_each_gives_alone(name, stack, channels):
    nm, make = spectra(stack, channels)
    options = OPTIONS.get(name, {})
    model = make_model(name, make(nm), **options)
    f, albedo = model.f(WO, WI), model.albedo(WO)
    assert f.shape == albedo.shape == (2, channels) and model.channels == channels
    some = sorted({0, channels // 2, channels - 1})
    alone = [make_model(name, make(nm[c : c + 1]), **options) for c in some]
    if model.stochastic:  # other walks: what is absorbed in one channel ends them in another
        for many, method, args in ((f, "f_stderr", (WO, WI)), (albedo, "albedo_stderr", (WO,))):
            figures = [getattr(one, method)(*args) for one in alone]
            error = np.hypot(getattr(model, method)(*args)[1][:, some], np.hstack([e for _, e in figures]))
            assert np.all(np.abs(many[:, some] - np.hstack([v for v, _ in figures])) <= 5.0 * error + 1e-9)
    else:
        assert f[:, some] == pytest.approx(np.hstack([one.f(WO, WI) for one in alone]), rel=1e-9, abs=1e-14)
        assert albedo[:, some] == pytest.approx(np.hstack([one.albedo(WO) for one in alone]), rel=1e-9, abs=1e-14)
    assert channels == 1 or np.ptp(albedo[0]) > 0.01


@pytest.mark.parametrize("channels", [1, 3, 7])
@pytest.mark.parametrize("name", [name for name in MODELS if name not in SPECTRAL])
def test_what_knows_rgb_alone_refuses_spectra_in_one_line(name, channels):
    nm, make = spectra("glazed clay", channels)
    with pytest.raises(LaminaError, match=rf"knows RGB alone, and this stack has {channels} spectral channels; choose model .*adding") as caught:
        make_model(name, make(nm))
    assert "\n" not in str(caught.value) and name not in str(caught.value).split("choose")[1]


@pytest.mark.parametrize("method", METHODS)
def test_shaders_refuse_spectra(method):
    nm, make = spectra("bare", 7)
    with pytest.raises(LaminaError, match=f"method {method} knows RGB alone"):
        make_lobe_set(make(nm), method)


def test_a_medium_that_scatters_is_spectral():
    cloudy = Stack.from_dict({"layers": [{"kind": "dielectric", **CLOUDY}], "base": {"kind": "lambert", "color": [0.5] * 3}})
    rgb, grey = Adding(cloudy, nodes=8, modes=8), Adding(spectral_stack(cloudy, NM[:5]), nodes=8, modes=8)
    assert grey.albedo(WO) == pytest.approx(np.repeat(rgb.albedo(WO)[:, :1], 5, axis=1), rel=1e-12)
    tinted = spectral_stack(cloudy, NM[:3], tints={0: [0.9, 0.5, 0.1]})
    walked, error = make_model("position_free", tinted, walks=4000).albedo_stderr(WO)
    assert np.all(np.abs(walked - Adding(tinted).albedo(WO)) < 5.0 * error)


def test_copper_is_copper_per_wavelength():
    bare = spectral_stack(Stack.from_dict({"base": {"kind": "conductor", "metal": "copper", "roughness": 0.0}}), NM)
    exact = fresnel_conductor(np.ones(1), *metal_index("copper", NM))
    for name in ("adding", "position_free"):
        assert make_model(name, bare, **OPTIONS[name]).albedo(spherical(0.0, 0.0)) == pytest.approx(exact, rel=1e-6)


@pytest.mark.parametrize("nm", [[], [500.0, 400.0], [400.0, np.nan], 500.0])
def test_wavelengths_that_do_not_increase_are_refused(nm):
    with pytest.raises(LaminaError, match="wavelengths must be a list that increases"):
        spectral_stack(Stack.from_dict({"base": {"kind": "lambert"}}), nm)


def test_films_and_unequal_channels_are_refused():
    film = Stack.from_dict({"layers": [{"kind": "dielectric", "film_thickness": 300.0}], "base": {"kind": "lambert"}})
    with pytest.raises(LaminaError, match="layer 0 has a thin film"):
        spectral_stack(film, NM)
    stack = Stack.from_dict({"layers": [{"kind": "dielectric"}], "base": {"kind": "lambert"}})
    mixed = Stack((stack.layers[0].with_values(tint=(0.5,) * 7),), stack.base)
    with pytest.raises(LaminaError, match="layer 0 has 7 channels and the base 3"):
        OpticalStack.of(mixed)
