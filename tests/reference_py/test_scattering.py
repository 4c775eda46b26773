# SPDX-License-Identifier: GPL-3.0-or-later
"""Media that scatter: known answers of a slab, of both truths, of the artist's colors, and of bad input."""

import time

import numpy as np
import pytest

from lamina.reference_py.errors import LaminaError
from lamina.reference_py.lobes.lobe import GlossyLobe
from lamina.reference_py.lobes.methods import make_lobe_set, provisional
from lamina.reference_py.lobes.truth import truth_of
from lamina.reference_py.material.place import Place
from lamina.reference_py.material.schema import SCATTERING
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.optics.frame import spherical
from lamina.reference_py.optics.optical_stack import OpticalStack
from lamina.reference_py.optics.scattering import albedo_of_color
from lamina.reference_py.optics.slab import half_space_albedo, henyey_greenstein, slab
from lamina.reference_py.registry import make_model
from lamina.study.charts.scattering import ALBEDOS, half_space
from lamina.study.half_space import albedo, f, spherical_albedo

BLACK, WHITE = {"kind": "lambert", "color": [0, 0, 0]}, {"kind": "lambert", "color": [1, 1, 1]}
GREY, SILVER = {"kind": "lambert", "color": [0.5, 0.5, 0.5]}, {"kind": "conductor", "metal": "silver", "roughness": 0.0}
WO = spherical(np.radians([0.0, 40.0, 65.0, 85.0]), 0.0)


def medium(tau, single, g=0.0, **layer):
    return {"extinction": [tau] * 3, "scatter_albedo": [single] * 3, "scatter_g": g, **layer}


def stack(*layers, base=BLACK):
    return Stack.from_dict({"layers": [{"kind": "dielectric", **layer} for layer in layers], "base": base})


def quadrature(nodes=24):
    u, gauss = np.polynomial.legendre.leggauss(nodes)
    return np.cos(0.25 * np.pi * (u + 1.0)), 0.25 * np.pi * np.sin(0.25 * np.pi * (u + 1.0)) * gauss


# --- the slab ---


@pytest.mark.parametrize("g", [-0.99, -0.5, 0.0, 0.5, 0.9, 0.99])
@pytest.mark.parametrize("tau", [1e-6, 1.0, 1e3])
def test_a_slab_that_absorbs_nothing_keeps_all_light(tau, g):
    cosines, weights = quadrature()
    whole = slab(cosines, weights, tau, 1.0, g, 2, 48)
    assert (whole.reflection + whole.transmission)[0].sum(axis=-1) == pytest.approx(1.0, abs=1e-8)


def test_two_halves_are_the_whole():
    cosines, weights = quadrature()
    half, whole = (slab(cosines, weights, tau, 0.9, 0.7, 3, 48) for tau in (2.0, 4.0))
    r, t = half.reflection, half.transmission
    both = np.linalg.solve(np.eye(24) - r @ r, np.concatenate([r @ t, t], axis=-1))
    assert r + t @ both[..., :24] == pytest.approx(whole.reflection, abs=1e-12)
    assert t @ both[..., 24:] == pytest.approx(whole.transmission, abs=1e-12)


def test_one_event_is_most_of_a_thin_slab():
    cosines, weights = quadrature()
    thin = slab(cosines, weights, 1e-6, 0.8, 0.3, 4, 48)
    assert thin.reflected_once == pytest.approx(thin.reflection, rel=1e-3, abs=1e-9)
    assert thin.transmitted_once + np.diag(thin.passed) == pytest.approx(thin.transmission, rel=1e-3, abs=1e-9)


@pytest.mark.parametrize("single", ALBEDOS)
def test_a_half_space_has_chandrasekhars_answers(single):
    model = make_model("adding", half_space(single))
    assert model.albedo(WO)[:, 0] == pytest.approx(albedo(single, WO[:, 2]), rel=1e-4)
    wi = spherical(np.radians([20.0, 70.0, 50.0, 80.0]), 2.0)
    assert model.f(WO, wi)[:, 0] == pytest.approx(f(single, WO[:, 2], wi[:, 2]), rel=1e-4)
    assert half_space_albedo(single, 0.0) == pytest.approx(spherical_albedo(single), abs=1e-5)


def test_chandrasekhars_figure():
    assert albedo(0.9, 1.0) == pytest.approx(0.41495, abs=1e-5)  # his H(1) at albedo .9 is 1.85


# --- both truths ---


def test_a_medium_of_no_depth_changes_nothing():
    clear, thin = (make_model("adding", stack({"roughness": 0.4, **layer}, base=GREY)) for layer in ({}, medium(1e-9, 0.9)))
    assert thin.albedo(WO) == pytest.approx(clear.albedo(WO), abs=1e-7)
    wi = spherical(np.radians(30.0), 1.0)
    assert thin.f(WO, wi) == pytest.approx(clear.f(WO, wi), abs=1e-7)


def test_albedo_0_is_a_tint():
    tint, dark = (make_model("adding", stack({"roughness": 0.4, **layer}, base=GREY)) for layer in ({"tint": [np.exp(-0.7)] * 3}, medium(0.7, 0.0)))
    assert dark.albedo(WO) == pytest.approx(tint.albedo(WO), abs=1e-12)


def test_a_tint_absorbs_on_top():
    apart = stack(medium(0.7, 0.9, tint=[0.5] * 3, thickness=2.0))
    tau, single = 1.4 - 2.0 * np.log(0.5), 0.9 * 1.4 / (1.4 - 2.0 * np.log(0.5))
    assert make_model("adding", apart).albedo(WO) == pytest.approx(make_model("adding", stack(medium(tau, single))).albedo(WO), abs=1e-12)


@pytest.mark.parametrize("model, options", [("adding", {}), ("position_free", {"walks": 500})])
def test_a_closed_white_stack_reflects_everything(model, options):
    white = stack(medium(0.5, 1.0, 0.3, ior=1.0), medium(3.0, 1.0, 0.5, roughness=0.5), base=WHITE)
    assert make_model(model, white, **options).albedo(WO) == pytest.approx(1.0, abs=1e-7)


@pytest.mark.parametrize("g", [-0.5, 0.0, 0.9])
def test_single_scattering_at_small_depth_is_in_closed_form(g):
    single = 0.9
    wo, wi = spherical(np.radians([10.0, 30.0, 60.0]), 0.0), spherical(np.radians([40.0, 20.0, 50.0]), np.radians([0.0, 120.0, 180.0]))

    def exact(tau):
        slant = tau * (1.0 / wo[:, 2] + 1.0 / wi[:, 2])
        return single * henyey_greenstein(-np.sum(wo * wi, axis=-1), g) * -np.expm1(-slant) / (wo[:, 2] + wi[:, 2])

    # what is scattered twice is some tau log(1 / tau) of it, more where one event hardly sends light
    assert make_model("adding", stack(medium(1e-4, single, g, ior=1.0))).f(wo, wi)[:, 0] == pytest.approx(exact(1e-4), rel=2e-3)
    value, stderr = make_model("position_free", stack(medium(0.005, single, g, ior=1.0)), walks=60_000).f_stderr(wo, wi)
    assert np.all(np.abs(value[:, 0] - exact(0.005)) < 4.0 * stderr[:, 0] + 0.08 * exact(0.005))
    assert np.all(stderr[:, 0] < 0.1 * exact(0.005))


@pytest.mark.parametrize("base", [SILVER, GREY], ids=["mirror", "grey"])
@pytest.mark.parametrize("layers", [[medium(0.3, 0.9, 0.8)], [medium(0.3, 0.9, 0.5, ior=1.0), {"ior": 1.8}], [{"ior": 3.0}, medium(0.5, 1.0, ior=1.0)]])
def test_light_that_mirrors_turn_back_after_the_last_event_is_found(layers, base):
    one = stack(*layers, base=base)
    theta, phi = np.radians([20.0, 40.0, 60.0]), np.radians([40.0, 100.0, 160.0])
    value, stderr = make_model("position_free", one, walks=20_000, seed=3).f_stderr(spherical(theta, 0.0), spherical(theta[::-1], phi))
    exact = make_model("adding", one).f(spherical(theta, 0.0), spherical(theta[::-1], phi))
    assert np.all(np.abs(value - exact) < 4.0 * stderr + 0.01 * exact)
    assert np.max(stderr / exact) < 0.1


def test_channels_of_different_depth_share_their_walks():
    one = stack({"extinction": [0.2, 2.0, 9.0], "scatter_albedo": [0.5, 0.9, 0.99], "scatter_g": 0.4, "roughness": 0.5}, base=GREY)
    value, stderr = make_model("position_free", one, walks=20_000).albedo_stderr(WO)
    assert np.all(np.abs(value - make_model("adding", one).albedo(WO)) < 4.0 * stderr)
    assert np.max(stderr) < 0.01


def test_both_are_fast_enough():
    """Beside the same without a medium, the least of several in turn: walks took 1.8 to 2.4 times as long, all of `adding` 14 to 18 times."""
    views = spherical(np.radians(np.linspace(0.0, 85.0, 64)), 0.0)

    def seconds(act, one):
        start = time.process_time()
        act(one)
        return time.process_time() - start

    def walk(one):
        make_model("position_free", one, walks=25_000).albedo(WO[0])

    def add(one):
        model = make_model("adding", one)
        model.albedo(views)
        model.f(views, views[::-1])

    for act, depth, most in ((walk, 1.0, 5.0), (add, 20.0, 40.0)):
        # each of another roughness, as a surface's operators are kept
        spent = [[seconds(act, stack(layer, base=GREY)) for layer in (medium(depth, 0.9, roughness=r), {"roughness": r})] for r in (0.45, 0.46, 0.47)]
        cloudy, clear = np.min(spent, axis=0)
        assert cloudy < most * clear, f"{cloudy / clear:.1f} times as long"


# --- as artists say it ---


@pytest.mark.parametrize("g", [-0.9, 0.0, 0.5, 0.9, 0.99])
def test_a_color_is_that_of_the_half_space(g):
    colors = (0.0, 0.01, 0.2, 0.5, 0.8, 0.95, 0.999, 1.0)
    singles = np.array(albedo_of_color(colors, g))
    assert singles[0] == 0.0 and singles[-1] == 1.0 and np.all(np.diff(singles) > 0.0)
    assert half_space_albedo(singles, g, nodes=96) == pytest.approx(colors, abs=1e-5)


def test_a_thick_layer_shows_its_color():
    colored = stack({"ior": 1.0, "scatter_color": [0.7, 0.4, 0.2], "density": 500.0, "scatter_g": 0.3})
    back, _ = make_model("adding", colored).layer_energies().diffuse_above
    assert back == pytest.approx([0.7, 0.4, 0.2], abs=1e-4)


def test_no_density_is_a_clear_layer():
    clear, none = (stack({"roughness": 0.3, **layer}, base=GREY) for layer in ({}, {"scatter_color": [0.5] * 3, "density": 0.0}))
    assert OpticalStack.of(none).interfaces[0].scattering is None
    assert np.array_equal(make_model("adding", none).albedo(WO), make_model("adding", clear).albedo(WO))


# --- the schema and those who do not know it ---


def test_a_medium_is_given_in_one_of_two_ways():
    one = stack({"scatter_color": [0.5] * 3, "density": 2.0})
    assert one.layers[0].has(SCATTERING) and one.layers[0]["scatter_g"] == 0.0 and "extinction" not in one.layers[0]
    assert stack({"scatter_g": 0.5}).layers[0]["density"] == 1.0
    assert not stack({}).layers[0].has(SCATTERING)
    assert Stack.from_json(one.to_json()) == one


@pytest.mark.parametrize(
    "layer, message",
    [
        ({"density": -1.0, "scatter_color": [0.5] * 3}, "density is -1; choose 0 to 1000"),
        ({"density": 1e9, "scatter_color": [0.5] * 3}, "density is 1e.09; choose 0 to 1000"),
        ({"density": 1.0}, "go together; scatter_color is missing"),
        ({"density": 1.0, "scatter_color": [1.1, 1, 1]}, r"scatter_color\[0\] is 1.1; choose 0 to 1"),
        (medium(1.0, 0.9, 1.0), "scatter_g is 1; choose -0.99 to 0.99"),
        (medium(float("nan"), 0.9), r"extinction\[0\] is nan"),
        ({**medium(1.0, 0.9), "density": 1.0}, r"exclude each other; choose scatter_color\+density or extinction\+scatter_albedo"),
    ],
)
def test_bad_values_are_named(layer, message):
    with pytest.raises(LaminaError, match=message):
        stack(layer)


def test_who_does_not_know_it_names_who_does():
    one = stack(medium(1.0, 0.9))
    for name in ("weidlich_wilkie", "schlick", "cycles_layer"):
        with pytest.raises(LaminaError, match=f"model {name} knows no scattering, which layer 0 has; choose .*adding"):
            make_model(name, one)
    with pytest.raises(LaminaError, match="method analytic knows no scattering, which layer 0 has; choose .*baked"):
        make_lobe_set(one, "analytic")
    with pytest.raises(LaminaError, match="a medium that scatters cannot be had together with the anisotropy of Dielectric"):
        make_lobe_set(stack(medium(1.0, 0.9, anisotropy=0.5)), "baked")
    with pytest.raises(LaminaError, match="no quality follows the scatter g of Dielectric"):
        make_lobe_set(stack({"density": 1.0, "scatter_color": [0.5] * 3}), "auto", live=(Place(0, "scatter_g"),))
    with pytest.raises(LaminaError, match="position_free: layer 0 has the optical depth 1000 and the albedo 1, .*choose adding"):
        make_model("position_free", stack(medium(1000.0, 1.0)))


def test_twenty_layers_that_scatter():
    one = stack(*[medium(0.3, 0.95, 0.5, ior=1.3 + 0.2 * (i % 2)) for i in range(20)], base=GREY)
    value, stderr = make_model("position_free", one, walks=5000).albedo_stderr(WO)
    assert np.all(np.abs(value - make_model("adding", one).albedo(WO)) < 4.0 * stderr)


# --- bakes ---


@pytest.mark.parametrize("layer", [medium(2.0, 0.95, 0.5, roughness=0.5), medium(0.5, 0.9, 0.9)], ids=["rough", "smooth"])
def test_a_bake_has_the_energy(layer):
    one = stack(layer, base=SILVER)
    made = make_lobe_set(one, "baked")
    truth = truth_of(one).albedo(WO[:3])
    baked = make_model("closure_model", one, method="baked").albedo(WO[:3])
    assert baked == pytest.approx(truth, rel=0.01)
    assert made.lobe_set.lobe_count <= 3 and provisional(one).lobe_set.lobe_count <= 2


def test_no_lobe_of_a_bake_stands_between_two_points_of_the_truth():
    """Light that a medium sends back under a smooth surface once got a needle of alpha .006 at three knots: a ring on a ball."""
    one = stack({"scatter_color": [0.75, 0.85, 0.9], "density": 1.0, "scatter_g": -0.8}, base={"kind": "lambert", "color": [0.45, 0.12, 0.06]})
    width = np.sqrt(1.0 - 0.8)
    cosines = np.cos(np.radians(np.linspace(0.0, 75.0, 31)))
    for lobe in make_lobe_set(one, "auto").lobe_set.lobes(cosines):
        if isinstance(lobe, GlossyLobe) and np.any(lobe.alpha_x > 0.0):
            carries = np.max(lobe.weight, axis=-1) > 0.01
            assert np.all(np.minimum(lobe.alpha_x, lobe.alpha_y)[carries] > 0.3 * width)
