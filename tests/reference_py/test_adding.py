# SPDX-License-Identifier: GPL-3.0-or-later
"""The deterministic truth: energy, reciprocity, closed forms, and agreement with the walk of `position_free`."""

import numpy as np
import pytest

from lamina.reference_py.errors import LaminaError
from lamina.reference_py.lobes.samples import truth_at
from lamina.reference_py.material import presets
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.models.adding import Adding, facets, operators
from lamina.reference_py.models.adding.assembly import Layers, Medium, add
from lamina.reference_py.models.adding.bounces import Microsurface, detail_of
from lamina.reference_py.models.adding.direction_grid import Grid
from lamina.reference_py.models.adding.effective_stack import EffectiveStack
from lamina.reference_py.models.adding.operators import Resolution, interface_operators
from lamina.reference_py.models.adding.two_events import two_reflections
from lamina.reference_py.models.position_free import PositionFree
from lamina.reference_py.optics.facet_reflectance import ConductorFacet, DielectricFacet
from lamina.reference_py.optics.frame import spherical
from lamina.reference_py.optics.fresnel import cos_theta_t, fresnel_dielectric
from lamina.reference_py.optics.microfacet import distribution
from lamina.reference_py.optics.optical_stack import OpticalStack, rough_surfaces
from lamina.reference_py.optics.quadrature import directional_albedo
from lamina.reference_py.registry import make_model
from lamina.study.suite import suite, suite_stack

VIEWS = spherical(np.radians([0.0, 25.0, 45.0, 60.0, 75.0, 85.0, 89.5]), 0.3)


def stack(base, *layers):
    return Stack.from_dict({"layers": [{"kind": "dielectric", **layer} for layer in layers], "base": base})


def coat(ior, alpha=0.0, **values):
    return {"ior": ior, "roughness": alpha**0.5, **values}


def lambert(value):
    return {"kind": "lambert", "color": [value] * 3}


def smooth_over_lambert(cos_o, n, rho, tau=0.0):
    """R(o) + T(o) rho T_d / (1 - rho R_d), with the diffuse integrals by a fine sum, independent of the grid."""
    u = (np.arange(400_000) + 0.5) / 400_000
    cos_inside = np.sqrt(u)  # u = cos^2 is uniform in projected solid angle
    r_inside = fresnel_dielectric(cos_inside, 1.0 / n)
    through = np.exp(-tau / cos_inside)
    t_d, r_d = np.mean((1.0 - r_inside) * through), np.mean(r_inside * through**2)
    r = fresnel_dielectric(cos_o, n)
    return r + (1.0 - r) * np.exp(-tau / cos_theta_t(cos_o, n)) * rho * t_d / (1.0 - rho * r_d)


@pytest.mark.parametrize("tau", [0.0, 0.5])
def test_smooth_coat_over_lambert_is_the_closed_form(tau):
    result = Adding(stack(lambert(0.5), coat(1.5, tint=[np.exp(-tau)] * 3))).albedo(VIEWS)
    expected = smooth_over_lambert(VIEWS[:, 2], 1.5, 0.5, tau)
    np.testing.assert_allclose(result, np.tile(expected[:, None], 3), rtol=1e-5)


def test_known_albedos():
    normal = spherical(0.0, 0.0)
    assert Adding(stack(lambert(0.5), coat(1.5))).albedo(normal)[0] == pytest.approx(0.316, abs=5e-4)
    rough = Adding(stack(lambert(0.8), coat(1.5, 0.4)), surface="single")
    assert rough.albedo(normal)[0] == pytest.approx(0.450, abs=1e-3)


@pytest.mark.parametrize("surface", ["multiple", "single"])
def test_base_lobe_below_a_smooth_coat(surface):
    """A white GGX metal; what the coat does not reflect directly is in the base lobe."""
    white = {"kind": "conductor", "eta": [0.01] * 3, "k": [20.0] * 3, "roughness": 0.1**0.5}
    wo = spherical(np.radians([0.0, 40.0, 60.0, 80.0]), 0.0)
    lobe = Adding(stack(white, coat(1.5)), surface=surface).albedo(wo)[:, 0] - fresnel_dielectric(wo[:, 2], 1.5)
    exact = np.array([0.960, 0.954, 0.911, 0.612])
    if surface == "multiple":
        np.testing.assert_allclose(lobe, exact, atol=1.5e-3)  # the metal is 99.96 % white
    else:  # each event on the metal loses some, and trapped light has many
        assert np.all((lobe < exact) & (lobe > 0.85 * exact))


WHITE = [
    (coat(1.5),),
    (coat(1.5, 0.003),),
    (coat(1.5, 1.0),),
    (coat(1.5, 0.3, distribution="beckmann"), coat(1.2, 0.05), coat(1.9)),
    (coat(1.5, 0.2), coat(1.0)),
    tuple(coat((1.5, 1.3)[i % 2], (0.0, 0.2)[i % 2]) for i in range(20)),
]


@pytest.mark.parametrize("layers", WHITE)
def test_a_white_lossless_stack_returns_everything(layers):
    assert np.abs(Adding(stack(lambert(1.0), *layers)).albedo(VIEWS) - 1.0).max() < 1e-6


def test_single_events_lose_energy_and_never_gain():
    for layers in WHITE:
        assert np.all(Adding(stack(lambert(1.0), *layers), surface="single").albedo(VIEWS) < 1.0 + 1e-3)


@pytest.mark.parametrize("name", ["gold_rough", "plastic_grey_0_4", "plastic_beckmann_1", "air_gap_rough", "three_rough"])
@pytest.mark.parametrize("surface", ["multiple", "single"])
def test_albedo_stays_physical_up_to_the_horizon(name, surface):
    """Grazing views to 90 degrees, whose rounded cosine is just above 0."""
    wo = spherical(np.radians([80.0, 89.0, 89.9, 89.999, 90.0]), 0.0)
    albedo = Adding(suite_stack(name), surface=surface).albedo(wo)
    assert np.all((albedo >= 0.0) & (albedo <= 1.0 + 1e-4))
    # the limit is slow: Heitz's masking of refraction falls as a small power of the cosine
    np.testing.assert_allclose(albedo[-1], albedo[-2], rtol=2e-2)


@pytest.mark.parametrize("alpha", [0.07, 0.3, 1.0])
@pytest.mark.parametrize("surface", ["multiple", "single"])
def test_a_lobe_has_the_energy_of_its_facets(alpha, surface):
    """Two quadratures of one event, over outgoing directions and over facet normals, up to grazing."""
    cos = np.cos(np.radians([0.0, 45.0, 80.0, 88.0, 89.5, 89.99]))
    lobe = operators._resolved_lobes([np.ones_like], cos, 1.0, alpha, "ggx", surface, Grid.shared((1.0, 1.5), 32), 1)[0]
    seen = facets.visible_facets(cos, alpha, "ggx", surface, 64, 128).reflected()[1]
    np.testing.assert_allclose(lobe[0].sum(axis=1), seen.sum(axis=1), rtol=4e-4)


@pytest.mark.parametrize("alpha", [0.0, 0.3])
def test_an_interface_between_equal_indices_vanishes(alpha):
    plain = Adding(stack(lambert(0.6), coat(1.5, 0.1)))
    inside = Adding(stack(lambert(0.6), coat(1.5, 0.1), coat(1.5, alpha)))
    above = Adding(stack(lambert(0.6), coat(1.0, alpha), coat(1.5, 0.1)))
    for model in (inside, above):
        np.testing.assert_allclose(model.albedo(VIEWS), plain.albedo(VIEWS), rtol=1e-12)
    np.testing.assert_allclose(Adding(stack(lambert(0.6), coat(1.0, alpha))).albedo(VIEWS), 0.6, rtol=1e-12)


def test_an_index_close_to_that_above_nearly_vanishes():
    near = Adding(stack(lambert(0.6), coat(1.001, 0.1))).albedo(VIEWS[:4])
    np.testing.assert_allclose(near, 0.6, rtol=2e-3)


def test_thickness_zero_and_huge():
    tinted = {"tint": [0.2, 0.5, 1.0]}
    clear = Adding(stack(lambert(0.8), coat(1.5, 0.2))).albedo(VIEWS)
    np.testing.assert_allclose(Adding(stack(lambert(0.8), coat(1.5, 0.2, thickness=0.0, **tinted))).albedo(VIEWS), clear)
    huge = Adding(stack(lambert(0.8), coat(1.5, 0.2, thickness=1000.0, **tinted))).albedo(VIEWS)
    black = Adding(stack(lambert(0.0), coat(1.5, 0.2))).albedo(VIEWS)
    np.testing.assert_allclose(huge[:, :2], black[:, :2], rtol=1e-9)
    np.testing.assert_allclose(huge[:, 2], clear[:, 2], rtol=1e-9)


def _parts():
    grid, resolution = Grid.shared((1.0, 1.3, 1.5, 1.8), 24), Resolution(2, 12, 24)
    return [
        interface_operators(DielectricFacet(above, below), alpha, "ggx", "multiple", grid, resolution).over_medium(
            Medium(operators.transmittance(grid, below, 0.1))
        )
        for above, below, alpha in ((1.0, 1.5, 0.2), (1.5, 1.3, 0.0), (1.3, 1.8, 0.5))
    ]


def test_adding_is_associative():
    a, b, c = _parts()
    left, right = add(add(a, b), c), add(a, add(b, c))
    for name in ("r_up", "t_down", "r_down", "t_up"):
        np.testing.assert_allclose(getattr(left, name), getattr(right, name), atol=1e-12)


def test_smooth_slab_is_the_sum_of_its_bounces():
    grid, resolution = Grid.shared((1.0, 1.5), 16), Resolution(1, 8, 8)
    front = interface_operators(DielectricFacet(1.0, 1.5), 0.0, "ggx", "multiple", grid, resolution)
    back = interface_operators(DielectricFacet(1.5, 1.0), 0.0, "ggx", "multiple", grid, resolution)
    slab: Layers = add(front, back)
    r = fresnel_dielectric(grid.cosines(1.0), 1.5)
    np.testing.assert_allclose(np.diagonal(slab.r_up[0]), 2.0 * r / (1.0 + r), rtol=1e-9)
    np.testing.assert_allclose(np.diagonal(slab.t_down[0]), (1.0 - r) / (1.0 + r), rtol=1e-9)


LAYER_CASES = [(coat(1.5),), (coat(1.5, 0.1),), (coat(1.5, 0.4), coat(1.8, 0.2)), (coat(1.7), coat(1.3, 0.6))]


@pytest.mark.parametrize("layers", LAYER_CASES)
@pytest.mark.parametrize("surface", ["multiple", "single"])
def test_layers_pass_the_same_diffuse_light_both_ways(layers, surface):
    """n^2 T_d from below equals T_d from above."""
    energies = Adding(stack(lambert(0.5), *layers), surface=surface).layer_energies()
    up, down = energies.diffuse_below[1], energies.diffuse_above[1]
    np.testing.assert_allclose(up * energies.n_below**2, down, rtol=2e-3)
    if surface == "multiple":
        np.testing.assert_allclose(sum(energies.diffuse_above), 1.0, rtol=1e-9)
        np.testing.assert_allclose(sum(energies.diffuse_below), 1.0, rtol=1e-9)


def test_layer_energies_give_the_albedo_over_lambert():
    layers = (coat(1.5, 0.3, tint=[0.9, 0.6, 0.2]), coat(1.7, 0.1))
    energies = Adding(stack(lambert(0.5), *layers)).layer_energies()
    r, t = energies.above(VIEWS[:, 2])
    r_d, t_d = energies.diffuse_below
    expected = r + t * 0.5 * t_d / (1.0 - 0.5 * r_d)
    np.testing.assert_allclose(Adding(stack(lambert(0.5), *layers)).albedo(VIEWS), expected, rtol=2e-3)


def test_a_dropped_n_squared_is_noticed(monkeypatch):
    """A deliberate fault: a Lambert base that forgets the index of the medium above it."""
    real = operators.lambert_rows
    monkeypatch.setattr(
        "lamina.reference_py.models.adding.effective_stack.lambert_rows",
        lambda color, n, count, grid, modes: real(color, n, count, grid, modes) * n * n,
    )
    wrong = Adding(stack(lambert(0.5), coat(1.5))).albedo(VIEWS)[:, 0]
    assert np.all(np.abs(wrong / smooth_over_lambert(VIEWS[:, 2], 1.5, 0.5) - 1.0) > 0.02)


FINE_CASES = ["gold_coat_0_3_metal_0_05", "lambert_1_5_0_3_over_1_8_0"]


@pytest.mark.parametrize("name", FINE_CASES)
def test_doubling_the_grid_changes_albedo_by_less_than_a_thousandth(name):
    coarse, fine = Adding(suite_stack(name)), Adding(suite_stack(name), nodes=64)
    np.testing.assert_allclose(coarse.albedo(VIEWS), fine.albedo(VIEWS), rtol=1e-3)


METAL = {"kind": "conductor", "eta": [0.3, 1.3, 1.6], "k": [5.9, 3.6, 3.1]}
QUADRATURE_CASES = [
    *(stack(lambert(0.5), coat(1.5, alpha)) for alpha in (0.02, 0.3, 1.0)),
    # a rough surface faces the root that radiance has at the critical angle of the mirror above
    *(stack({**METAL, "roughness": alpha**0.5}, coat(1.5)) for alpha in (0.04, 0.3, 1.0)),
    stack(lambert(0.0), coat(1.5), coat(3.0, 0.5)),
]


@pytest.mark.parametrize("material", QUADRATURE_CASES)
@pytest.mark.parametrize("surface", ["multiple", "single"])
def test_doubling_grid_and_facets_together_changes_little(material, surface, monkeypatch):
    coarse = Adding(material, surface=surface).albedo(VIEWS)
    monkeypatch.setattr("lamina.reference_py.models.adding.adding_model.ENERGY", Resolution(1, 32, 72))
    np.testing.assert_allclose(coarse, Adding(material, surface=surface, nodes=64).albedo(VIEWS), rtol=1e-3)


SHAPES = ["oren_nayar_clay", "gold_rough", "plastic_grey_0_4", "gold_coat_0_metal_0_1", "lambert_1_5_0_3_over_1_8_0"]


@pytest.mark.parametrize("name", SHAPES)
def test_f_is_reciprocal(name):
    rng = np.random.default_rng(5)
    wo, wi = (spherical(np.arccos(rng.uniform(0.1, 1.0, 60)), rng.uniform(0.0, 6.3, 60)) for _ in range(2))
    model = Adding(suite_stack(name))
    np.testing.assert_allclose(model.f(wo, wi), model.f(wi, wo), rtol=1e-6)


@pytest.mark.parametrize("name", ["gold_rough", "plastic_grey_0_4", "beckmann_over_ggx"])
def test_f_integrates_to_the_albedo(name):
    """Stacks with a rough top: no mirror-like part."""
    wo = spherical(np.radians(40.0), 0.0)
    x, w = np.polynomial.legendre.leggauss(64)
    theta, phi = 0.25 * np.pi * (x + 1.0), np.pi * (np.arange(96) + 0.5) / 96
    weights = (w * 0.25 * np.pi * np.sin(theta) * np.cos(theta) * 2.0 * np.pi / 96)[:, None, None]
    model = Adding(suite_stack(name))
    integral = np.sum(model.f(wo, spherical(theta[:, None], phi)) * weights, axis=(0, 1))
    np.testing.assert_allclose(integral, model.albedo(wo), rtol=5e-3)


def test_f_of_bases_and_below_the_horizon():
    wo, wi = spherical(0.5, 0.2), spherical([0.3, 1.0, 2.0], 2.0)
    f = Adding(stack(lambert(0.4))).f(wo, wi)
    np.testing.assert_allclose(f[:2], 0.4 / np.pi, rtol=1e-9)
    assert np.all(f[2] == 0.0) and np.all(Adding(stack(lambert(0.4))).albedo(wi[2]) == 0.0)


@pytest.mark.parametrize("name", ["plastic_grey_0_4", "copper_1_5_0_5_over_1_33_0_1", "lacquer_gold", "eight_layers"])
@pytest.mark.parametrize("surface", ["multiple", "single"])
def test_albedo_agrees_with_the_walk(name, surface):
    wo = spherical(np.radians([20.0, 70.0]), 0.0)
    walk, stderr = PositionFree(suite_stack(name), surface=surface, walks=30_000).albedo_stderr(wo)
    assert np.all(np.abs(Adding(suite_stack(name), surface=surface).albedo(wo) - walk) < 4.0 * stderr + 1e-4)


def test_f_agrees_with_the_walk():
    name = "gold_coat_0_metal_0_1"
    wo, wi = spherical(0.7, 0.0), spherical(np.radians([[10.0], [40.0], [65.0]]), np.radians([60.0, 180.0]))
    wo = np.broadcast_to(wo, wi.shape)
    walk, stderr = PositionFree(suite_stack(name), walks=4000).f_stderr(wo, wi)
    assert np.all(np.abs(Adding(suite_stack(name)).f(wo, wi) - walk) < 4.0 * stderr + 0.03 * walk + 1e-3 * walk.max())


# (stack, theta_o, theta_i, azimuth in degrees): twice on a narrow surface; once through one and a mirror below it
NARROW_CASES = [
    ("aluminium_beckmann", 60.0, 80.0, 90.0),
    ("plastic_black", 60.0, 80.0, 90.0),
    ("titanium_coat_0_1_metal_0", 20.0, 35.0, 175.0),
]


@pytest.mark.parametrize("name, theta_o, theta_i, azimuth", NARROW_CASES)
def test_f_of_narrow_lobes_agrees_with_the_walk_far_from_their_peak(name, theta_o, theta_i, azimuth):
    wo, wi = spherical(np.radians(theta_o), 0.0), spherical(np.radians(theta_i), np.radians(azimuth))
    material = suite_stack(name)
    model = Adding(material)
    walk, stderr = PositionFree(material, walks=20_000).f_stderr(wo, wi)
    peak = model.f(spherical(np.radians(60.0), 0.0), spherical(np.radians([60.0, 80.0]), np.radians(175.0))).max()
    assert np.all(np.abs(model.f(wo, wi) - walk) < 4.0 * stderr + 0.035 * (walk + 0.02 * peak))


@pytest.mark.parametrize("alpha", [0.2, 0.6])
@pytest.mark.parametrize("eta", [1.5, 1 / 1.5])
def test_the_shape_of_further_events_changes_no_energy(alpha, eta):
    """Both sides share the leftover alike, whether the shape or the energy alone is solved for."""
    cos = np.cos(np.radians([10.0, 60.0, 80.0]))
    surface = Microsurface(alpha, "ggx", DielectricFacet(1.0, eta))
    energy, shape = (surface.shares(cos, detail_of(modes))[0][:, 0, :, 0] for modes in (1, 16))
    np.testing.assert_allclose(energy, shape, atol=4e-3)
    np.testing.assert_allclose(shape.sum(axis=0), 1.0, rtol=1e-9)


def test_f_takes_more_nodes_where_a_narrow_lobe_lies_below_a_rough_surface():
    """Refraction at a slope of alpha turns s by half of it, twice; the mirror below adds nothing."""
    narrow = EffectiveStack.of(OpticalStack.of(suite_stack("titanium_coat_0_1_metal_0"))).narrowest_lobe()
    assert narrow == pytest.approx(np.sqrt(2.0) * 0.5 * 0.1, rel=1e-4)
    wide = EffectiveStack.of(OpticalStack.of(stack({**METAL, "roughness": 0.2**0.5}, coat(1.5, 0.1)))).narrowest_lobe()
    assert wide == pytest.approx(np.hypot(narrow, 2.0 * 1.5 * 0.2), rel=1e-4)
    assert EffectiveStack.of(OpticalStack.of(stack(lambert(0.5), coat(1.5, 0.01)))).narrowest_lobe() == np.inf
    # f of a smooth coat over a narrow metal is a formula
    assert EffectiveStack.of(OpticalStack.of(stack({**METAL, "roughness": 0.02**0.5}, coat(1.5)))).narrowest_lobe() == np.inf


def test_the_suite_is_large_and_valid():
    assert len(suite()) >= 60
    assert any(len(s.layers) == 20 for s in suite().values()) and any(not s.layers for s in suite().values())
    with pytest.raises(LaminaError, match="unknown suite stack 'no'; choose lambert_grey"):
        suite_stack("no")


def test_log_gamma_is_that_of_the_standard_library():
    from math import lgamma

    x = np.array([1.0, 1.5, 2.0, 3.7, 50.0, 1e4])
    np.testing.assert_allclose(facets.log_gamma(x), [lgamma(v) for v in x], rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize(
    "options, message",
    [
        ({"surface": "rough"}, "unknown surface 'rough'; choose multiple, single"),
        ({"modes": 0}, "modes is 0; choose a whole number from 1 to 512"),
        ({"walks": 3}, "unknown option 'walks'; choose surface, nodes, modes"),
    ],
)
def test_bad_options_name_the_choices(options, message):
    with pytest.raises(LaminaError, match=message):
        make_model("adding", stack(lambert(0.5)), **options)


@pytest.mark.parametrize("name", ["plastic_black", "rising_index"])
@pytest.mark.parametrize("theta_deg", [0.0, 1.0])
def test_f_holds_the_albedo_along_the_normal(name, theta_deg):
    """There azimuth has no meaning, and noise of the modes would add up."""
    stack = suite_stack(name)
    wo, model = spherical(np.radians([theta_deg]), 0.0), Adding(stack)
    assert directional_albedo(model.f, wo, rough_surfaces(stack)) == pytest.approx(model.albedo(wo), rel=0.01)


def test_a_narrow_coat_does_not_ring():
    """A varnish of alpha .002: what meets several of its facets was a spike at grazing that reached everywhere."""
    stack = presets.load("metallic_car_paint")
    wo, wi = spherical(np.radians(60.0), 0.0), spherical(np.radians([40.0, 62.0, 75.0]), np.pi)
    wo = np.broadcast_to(wo, wi.shape)
    value, stderr = PositionFree(stack, walks=6000, seed=1).f_stderr(wo, wi)
    assert np.all(np.abs(Adding(stack).f(wo, wi) - value) <= 4.0 * stderr + 0.01 * value)


def test_narrow_lobes_are_named_to_who_reads_f():
    assert "position_free" in Adding(suite_stack("narrow_over_narrow")).f_note
    assert Adding(suite_stack("narrow_over_narrow"), nodes=96, modes=256).f_note is None
    assert Adding(suite_stack("plastic_grey_0_4")).f_note is None


def test_a_wide_lobe_has_no_stripes_in_azimuth():
    """Too few azimuths of its quadrature aliased the highest modes."""
    wi = spherical(np.radians(20.0), np.radians(np.arange(60.0, 80.0)))
    wo = np.broadcast_to(spherical(np.radians(20.0), 0.0), wi.shape)
    f = Adding(presets.load("metallic_car_paint")).f(wo, wi)[:, 1]
    assert np.all(np.abs(np.diff(f, 2)) < 1e-3 * f[1:-1])


@pytest.mark.parametrize("roughness", [0.285, 0.3, 0.35])
def test_light_that_no_second_facet_meets_has_no_shape(roughness):
    """At these angles a second event of a Beckmann surface has less than 1e-5 of the light, which is less than is solved for."""
    metal = stack({"kind": "conductor", "metal": "copper", "distribution": "beckmann", "roughness": roughness})
    wi = spherical(np.radians(np.arange(0.0, 46.0, 3.0)), np.pi)
    wo = np.broadcast_to(spherical(np.radians(30.0), 0.0), wi.shape)
    np.testing.assert_allclose(Adding(metal).f(wo, wi), make_model("weidlich_wilkie", metal).f(wo, wi), rtol=1e-3, atol=1e-3)
    grazing = np.cos(np.radians([20.0, 45.0, 80.0]))
    assert np.all(np.abs(Microsurface(roughness**2, "beckmann", ConductorFacet(1.0, 0.2, 3.0)).shares(grazing, detail_of(64))[0]) <= 1.0)


# What of all light a draft puts elsewhere, up to 60 degrees and beyond: measured, with a third more.
DRAFTS = {"metallic_car_paint": (0.001, 0.0002), "frosted_metal": (0.0023, 0.0035), "clean_copper": (0.0011, 0.0084), "frosted_paint": (0.0046, 0.0039)}


@pytest.mark.parametrize("name", DRAFTS)
def test_a_draft_has_the_energies_and_nearly_the_shape(name):
    material = presets.load(name)
    full, draft = Adding(material), Adding(material, draft=1)
    cosines = np.cos(np.radians([0.0, 40.0, 60.0, 75.0, 80.0]))
    views = truth_at(full, cosines, [alpha for _, alpha in rough_surfaces(material)], 100)
    albedo = full.albedo(views.wo)
    np.testing.assert_allclose(draft.albedo(views.wo), albedo, rtol=1e-12)
    elsewhere = np.sum(views.share[..., None] * np.abs(draft.f(np.broadcast_to(views.wo[:, None], views.wi.shape), views.wi) - views.f), axis=1) / albedo
    print(f"{name}: up to 60 degrees {100 * np.max(elsewhere[:3]):.2f} %, beyond {100 * np.max(elsewhere[3:]):.2f} %")
    near, beyond = DRAFTS[name]
    assert np.max(elsewhere[:3]) < near and np.max(elsewhere[3:]) < beyond


def test_a_draft_takes_the_resolution_that_is_given():
    material, wi = presets.load("metallic_car_paint"), spherical(np.radians(50.0), np.radians([0.0, 90.0, 170.0]))
    wo = np.broadcast_to(spherical(0.6, 0.0), wi.shape)
    truth = Adding(material).f(wo, wi)
    coarse, blurred, good = (np.max(np.abs(Adding(material, nodes=n, modes=m, draft=1).f(wo, wi) / truth - 1.0)) for n, m in ((8, 24), (24, 4), (24, 24)))
    assert coarse > 0.05 and blurred > 0.5 and good < 2e-4


# In and beside the lobe: far from it few walks carry most of the light.
GRAZING_PAIRS = [(83.0, 79.0, 177.0), (86.0, 85.0, 177.0), (76.0, 75.0, 177.0)]


@pytest.mark.parametrize("material", [stack({"kind": "conductor", "metal": "silver", "roughness": 0.3}), stack(lambert(0.0), coat(1.5, 0.09))])
def test_f_of_two_grazing_directions_agrees_with_the_walk(material):
    """Modes and moments put what meets two facets elsewhere: 12 % at the first of these, 30 % at the second."""
    theta_o, theta_i, azimuth = np.radians(GRAZING_PAIRS).T
    wo, wi = spherical(theta_o, 0.0), spherical(theta_i, azimuth)
    walk, stderr = PositionFree(material, walks=6000, seed=1).f_stderr(wo, wi)
    assert np.all(np.abs(Adding(material).f(wo, wi) - walk) < 4.0 * stderr + 0.01 * walk)


@pytest.mark.parametrize("alpha", [0.25, 0.5, 1.0])
def test_two_reflections_are_the_integral_over_the_direction_between_them(alpha):
    """By drawing that direction evenly from the sphere, for white facets."""
    lobe = two_reflections(alpha, "ggx", (ConductorFacet(1.0, 1e-9, 1e9),))
    wo, wi = spherical(np.radians(60.0), 0.0), spherical(np.radians(80.0), np.radians(110.0))
    n = 400_000
    z = np.linspace(-wo[2], wi[2], 2 * n + 1)[1::2]
    phi = 2.0 * np.pi * (np.arange(n) * (0.5 * (5**0.5 - 1.0)) % 1.0)
    w = np.stack([np.sqrt(1.0 - z * z) * np.cos(phi), np.sqrt(1.0 - z * z) * np.sin(phi), z], axis=-1)
    first, second = w + wo, wi - w
    density = [distribution(h[:, 2] / np.linalg.norm(h, axis=-1), alpha, "ggx") for h in (first, second)]
    lambdas = facets_lambda(np.abs(z), alpha), facets_lambda(wo[2], alpha), facets_lambda(wi[2], alpha)
    free = np.abs(z) * (1.0 + lambdas[0] + np.where(z > 0.0, *lambdas[1:]))
    exact = 2.0 * np.pi * (wo[2] + wi[2]) * np.mean(density[0] * density[1] / free) / (16.0 * wo[2] * wi[2] * (1.0 + lambdas[1] + lambdas[2]))
    found = lobe(wo[2:], wi[2:], np.array([-np.cos(np.radians(110.0))]))
    assert found[0, 0] == pytest.approx(float(exact), rel=0.02)


@pytest.mark.parametrize("alpha", [0.1, 0.15, 0.2])
def test_gaussian_facets_turn_no_light_back_twice(alpha):
    """Rounding of the table's Fourier transforms, to whose logarithm a cubic was fitted, had f of 188 there, where the lobe itself has 9."""
    rng, n = np.random.default_rng(1), 200_000
    lobe = two_reflections(alpha, "beckmann", (ConductorFacet(1.0, 1e-9, 1e9),))
    back = lobe(rng.uniform(1e-3, 1.0, n), rng.uniform(1e-3, 1.0, n), np.cos(rng.uniform(0.5 * np.pi, np.pi, n)))
    assert np.max(back) < 1e-6


def facets_lambda(cos, alpha):
    return facets.smith_lambda(cos, alpha, "ggx")


def test_lobes_between_the_grid_s_own_directions_are_those_of_any_directions():
    """The first are computed for one half of the pairs alone."""
    grid = Grid.shared((1.0, 1.5), 12)
    cos = grid.cosines(1.5)
    lobe = (1.5, 0.3, "beckmann", "multiple", grid, 5)
    curves = [lambda c: fresnel_dielectric(c, 1.0 / 1.5), np.ones_like]
    own, any_ = operators._resolved_lobes(curves, cos, *lobe), operators._resolved_lobes(curves, cos[:-1], *lobe)
    np.testing.assert_allclose(np.array(own)[:, :, :-1], any_, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("top", [{}, {"extinction": [0.3] * 3, "scatter_albedo": [0.9] * 3, "scatter_g": 0.8}])
def test_modes_that_rough_layers_blur_away_are_left_out_and_not_missed(top, monkeypatch):
    deep = stack(
        {"kind": "conductor", "metal": "silver", "roughness": 0.3}, coat(1.6, 0.2, **top), *(coat((1.2, 1.7)[i % 2], (0.5, 0.6, 0.0, 0.7)[i]) for i in range(4))
    )
    wo, wi = spherical(np.radians([10.0, 60.0, 80.0]), 0.0), spherical(np.radians([20.0, 55.0, 70.0]), np.radians([180.0, 170.0, 60.0]))
    fewer = Adding(deep, nodes=12, modes=48)
    f, seen = fewer.f(wo, wi), [len(operators.r_up) for operators in fewer._by_depth(0)[0]]
    monkeypatch.setattr("lamina.reference_py.models.adding.depth._UNSEEN", 0.0)
    every = Adding(deep, nodes=12, modes=48)
    np.testing.assert_allclose(f, every.f(wo, wi), rtol=1e-6)
    assert [len(operators.r_up) for operators in every._by_depth(0)[0]] == [48] * 5
    assert seen == sorted(seen, reverse=True) and seen[0] == 48 and (seen[-1] == 48) == bool(top)


@pytest.mark.parametrize("alpha", [0.05, 0.4])
def test_between_two_edges_facets_do_not_reflect_totally(alpha):
    cos, eta = np.array([-0.6, -0.1, 0.2, 0.5, 0.8]), 1.0 / 1.5
    sin, length = np.sqrt(1.0 - cos * cos), np.hypot(alpha * np.sqrt(1.0 - cos * cos), cos)
    cap = facets._StretchedCap((alpha * sin / length)[:, None, None], (cos / length)[:, None, None], alpha)
    low, critical = -np.arctan2(cap.vz, cap.vx), np.sqrt(1.0 - eta * eta) / length[:, None, None]
    across = cap.transmitting_across(low, critical)
    a = across * np.linspace(0.0, 0.999, 7)[:, None]
    edges = cap.transmitting_along(a, across, np.broadcast_to(low, a.shape), critical)

    def cosine(b):
        """Between the direction and the facet."""
        x, y, z = cap.normal(a, b)
        return (sin[:, None, None] * alpha * x + cos[:, None, None] * z) / np.sqrt(np.square(alpha * x) + np.square(alpha * y) + z * z)

    least = np.sqrt(1.0 - eta * eta)
    assert np.all(cosine(0.5 * (edges[0] + edges[1])) > least)
    for edge in edges:
        inside = (edge > low + 1e-9) & (edge < 0.5 * np.pi - 1e-9)
        assert np.any(inside) and np.allclose(cosine(edge)[inside], least, atol=1e-9)


def test_many_views_of_few_pairs_are_one_view_after_the_other():
    rng = np.random.default_rng(0)
    theta_o, theta_i, phi = 1.5 * rng.random(300), 1.5 * rng.random(300), 6.0 * rng.random(300)
    theta_o[:3] = 0.0
    wo, wi = spherical(theta_o, 0.0), spherical(theta_i, phi)
    model = Adding(stack({"kind": "conductor", "metal": "gold", "roughness": 0.4}, coat(1.5, 0.1)), nodes=12, modes=20)
    single = np.concatenate([model.f(o, i) for o, i in zip(wo[:, None], wi[:, None])])
    np.testing.assert_allclose(model.f(wo, wi), single, rtol=1e-9)
