# SPDX-License-Identifier: GPL-3.0-or-later
"""Other people's models: the values that their papers give, and what each of them breaks, as a record."""

from functools import cache

import numpy as np
import pytest

from lamina.reference_py.errors import LaminaError
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.models.baselines import BASELINES, cycles
from lamina.reference_py.models.baselines.cycles import Closure
from lamina.reference_py.models.baselines.energy import mean_fresnel
from lamina.reference_py.models.baselines.parts import dielectric, f82
from lamina.reference_py.optics.frame import spherical
from lamina.reference_py.optics.fresnel import fresnel_conductor, fresnel_dielectric
from lamina.reference_py.optics.quadrature import directional_albedo
from lamina.reference_py.registry import MODELS, make_model
from lamina.study import make_cycles_energies

NAMES = [baseline.name for baseline in BASELINES]
NORMAL = spherical(0.0, 0.0)
VIEWS = spherical(np.radians([0.0, 60.0, 85.0, 89.9]), 0.0)
RECIPROCAL = {"torrance_sparrow", "ashikhmin_shirley", "kelemen", "schlick", "lafortune"}


def layer(ior=1.5, alpha=0.0, **values):
    return {"kind": "dielectric", "ior": ior, "roughness": alpha**0.5, **values}


def stack(base, *layers):
    return Stack.from_dict({"layers": list(layers), "base": base})


def lambert(value):
    return {"kind": "lambert", "color": [value] * 3}


def silver(alpha):
    return {"kind": "conductor", "metal": "silver", "roughness": alpha**0.5}


STRESS = {
    "bare white": stack(lambert(1.0)),
    "coated white": stack(lambert(1.0), layer()),
    "rough coat": stack(lambert(1.0), layer(1.5, 0.4)),
    "rough, high index": stack(lambert(0.9), layer(4.0, 1.0)),
    "equal indices": stack(lambert(0.5), layer(1.0), layer(1.5), layer(1.5, 0.3)),
    "thinner under denser": stack(silver(0.2), layer(1.8, 0.1), layer(1.2, 0.3)),
    "opaque medium": stack(silver(0.1), layer(1.5, 0.1, tint=[0.0, 1.0, 0.5], thickness=1000.0)),
    "mirror": stack(silver(0.0), layer()),
    "narrow beckmann": stack({**silver(0.05), "distribution": "beckmann"}, layer(1.3, 0.05, distribution="beckmann")),
    "chalk": stack({"kind": "oren_nayar", "color": [1.0, 0.5, 0.0], "sigma_deg": 40.0}, layer(1.5, 0.2)),
    "eight layers": stack(silver(0.1), *(layer(1.2 + 0.1 * (i % 3), 0.1 * (i % 2)) for i in range(8))),
}

# Largest albedo over STRESS and VIEWS; energy is conserved where no number stands.
LARGEST_ALBEDO = {
    "torrance_sparrow": 1.95,
    "schlick": 5.95,
    "cycles_layer": 1.22,  # two Beckmann lobes at 89.9 degrees; Cycles 5.2 renders 1.219
}


def some_directions(count=150, seed=5):
    """Directions above the surface, half of them grazing down to 1e-7 of cosine."""
    rng = np.random.default_rng(seed)
    cos = np.concatenate([rng.random(count), 10.0 ** rng.uniform(-7.0, -1.0, count)])
    return spherical(np.arccos(cos), 2.0 * np.pi * rng.random(2 * count))


@cache
def stressed(name, case):
    """A model of a stress case and its albedo at VIEWS."""
    model = make_model(name, STRESS[case])
    return model, model.albedo(VIEWS)


def test_all_baselines_are_registered_under_their_names():
    assert NAMES == [
        "torrance_sparrow",
        "cycles_layer",
        "principled_coat",
        "belcour",
        "openpbr_coat",
        "kelemen",
        "ashikhmin_shirley",
        "schlick",
        "lafortune",
    ]
    assert all(MODELS[name].name == name and MODELS[name].stochastic is False for name in NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_unknown_options_are_named(name):
    with pytest.raises(LaminaError, match=f"model {name}: unknown option 'colour'"):
        make_model(name, STRESS["bare white"], colour="red")


def test_unknown_choices_are_named_with_the_choices():
    with pytest.raises(LaminaError, match="unknown fit 'red_paint'; choose blue_paint"):
        make_model("lafortune", STRESS["bare white"], fit="red_paint")


@pytest.mark.parametrize("case", STRESS)
@pytest.mark.parametrize("name", NAMES)
def test_f_and_albedo_are_finite_and_not_negative(name, case):
    model, albedo = stressed(name, case)
    wo = some_directions()
    wi = some_directions(seed=6)
    for value in (model.f(wo, wi), model.f(wo, wo), model.f(wo, wo * np.array([-1.0, -1.0, 1.0])), albedo):
        assert value.shape[-1] == 3 and np.all(np.isfinite(value)) and np.all(value >= 0.0)
    below = wi * np.array([1.0, 1.0, -1.0])
    assert not model.f(wo, below).any() and not model.f(below, wo).any() and not model.albedo(below[:3]).any()


@pytest.mark.parametrize("name", NAMES)
def test_energy_is_conserved_or_its_excess_on_record(name):
    largest = max(stressed(name, case)[1].max() for case in STRESS)
    print(f"{name}: largest albedo {largest:.4f}")
    recorded = LARGEST_ALBEDO.get(name)
    if recorded is None:
        assert largest <= 1.0 + 2e-3
    else:
        assert 1.0 + 2e-3 < largest <= recorded


@pytest.mark.parametrize("name", NAMES)
def test_reciprocity_is_as_each_model_claims(name):
    gap = 0.0
    for case in ("rough coat", "thinner under denser", "chalk"):
        model, _ = stressed(name, case)
        wo, wi = some_directions(), some_directions(seed=6)
        there, back = model.f(wo, wi), model.f(wi, wo)
        gap = max(gap, np.max(np.abs(there - back) / np.maximum(np.maximum(there, back), 1e-12)))
    assert (gap < 1e-9) if name in RECIPROCAL else (gap > 0.05)


@pytest.mark.parametrize("name", NAMES)
def test_albedo_is_the_integral_of_f(name):
    """Gauss-Legendre over the polar angle, midpoints over the azimuth, against the model's own quadrature."""
    model, _ = stressed(name, "rough coat")
    x, w = np.polynomial.legendre.leggauss(96)
    theta, phi = (x + 1.0) * np.pi / 4.0, (np.arange(96) + 0.5) * np.pi / 96
    wi = spherical(theta[:, None], phi)
    wo = spherical(np.radians(50.0), 0.0)
    weight = w * np.pi / 4.0 * np.sin(theta) * np.cos(theta) * 2.0 * np.pi / len(phi)
    total = np.sum(model.f(wo, wi) * weight[:, None, None], axis=(0, 1))
    np.testing.assert_allclose(model.albedo(wo), total, rtol=1e-3)


@pytest.mark.parametrize("case", [case for case in STRESS if "beckmann" not in case])
def test_principled_albedo_by_its_closures_is_the_integral_of_its_f(case):
    model = make_model("principled_coat", STRESS[case])
    wo = spherical(np.radians([0.0, 30.0, 60.0, 80.0]), 0.0)
    whole = directional_albedo(model.f, wo, model._widths(), count=65536) + model._specular_albedo(wo[:, 2])
    np.testing.assert_allclose(model.albedo(wo), whole, atol=4e-4)


@pytest.mark.parametrize(
    "name, expected",
    [
        ("torrance_sparrow", 0.52),
        ("cycles_layer", 0.52),
        ("principled_coat", 0.52),
        ("kelemen", 0.52),
        ("belcour", 0.3161),
        ("openpbr_coat", 0.3161),
        ("ashikhmin_shirley", 0.5050),
        ("schlick", 0.5200),
    ],
)
def test_smooth_coat_over_grey_at_normal_view(name, expected):
    """Without internal reflection it is F0 + (1 - F0) / 2 = .52; the truth is .316."""
    model = make_model(name, stack(lambert(0.5), layer()))
    np.testing.assert_allclose(model.albedo(NORMAL), expected, atol=5e-4)


@pytest.mark.parametrize("name", ["belcour", "openpbr_coat"])
def test_an_interfaced_lambertian_is_exact_where_it_should_be(name):
    case = stack(lambert(0.5), layer())
    np.testing.assert_allclose(make_model(name, case).albedo(VIEWS), make_model("adding", case).albedo(VIEWS), atol=5e-4)


def test_openpbr_without_darkening_is_plain_albedo_scaling():
    model = make_model("openpbr_coat", stack(lambert(0.5), layer()), darkening="off")
    np.testing.assert_allclose(model.albedo(NORMAL), 0.52, atol=5e-4)


def test_openpbr_roughens_the_base_by_twice_the_coat():
    model = make_model("openpbr_coat", stack(silver(0.09), layer(1.5, 0.2)))
    assert model._widths()[1][1] == pytest.approx(np.sqrt(0.09**2 + 2.0 * 0.2**2))


def test_belcour_adds_smooth_stacks_exactly():
    """Without roughness his energies are the closed form of all orders between two mirrors."""
    tint = np.array([0.9, 0.6, 0.3])
    cos = np.cos(np.radians([0.0, 50.0, 80.0]))
    inside = np.sqrt(1.0 - (1.0 - cos**2) / 1.5**2)
    top = fresnel_dielectric(cos, 1.5)[:, None]
    eta, k = np.array([0.2, 0.9, 1.1]), np.array([3.9, 2.4, 2.1])
    below = fresnel_conductor(inside[:, None], eta / 1.5, k / 1.5) * tint ** (2.0 / inside[:, None])
    exact = top + (1.0 - top) ** 2 * below / (1.0 - top * below)
    metal = {"kind": "conductor", "eta": list(eta), "k": list(k), "roughness": 0.0}
    model = make_model("belcour", stack(metal, layer(1.5, 0.0, tint=list(tint))))
    np.testing.assert_allclose(model.albedo(spherical(np.arccos(cos), 0.0)), exact, rtol=2e-3)


def test_belcour_leaves_a_bare_metal_as_it_is():
    case = stack(silver(0.3))
    [(weight, alpha)] = make_model("belcour", case).lobes(np.array([1.0, 0.5]))
    np.testing.assert_allclose(alpha, 0.3, rtol=1e-3)
    single = make_model("torrance_sparrow", case).albedo(spherical(np.arccos([1.0, 0.5]), 0.0))
    np.testing.assert_allclose(weight, single, rtol=2e-3)


def test_belcour_scales_variance_by_the_refraction():
    """Under a smooth coat a narrow lobe's slope variance grows by the Jacobian n cos_t / cos."""
    model = make_model("belcour", stack(silver(0.05), layer(1.5)))
    (_, mirror), (_, alpha) = model.lobes(np.array([1.0]))
    assert mirror[0] == 0.0
    power = np.array([0.05, alpha[0]]) ** 1.1
    ratio = (power / (1.0 - power))[1] / (power / (1.0 - power))[0]
    assert 1.5 <= ratio < 1.6  # the rest comes from further bounces


@pytest.mark.parametrize(
    "top, base, theta_deg, weights, albedo, peak, truth, true_peak",
    [
        (0.3, 0.05, 60.0, 0.836, 0.642, 1.55, 0.729, 2.21),
        (0.6, 0.1, 0.0, 0.842, 0.690, 0.511, 0.789, 0.687),
    ],
)
def test_belcour_below_a_rough_interface_is_off_by_what_its_docstring_says(top, base, theta_deg, weights, albedo, peak, truth, true_peak):
    """The weights hold more than the truth, f gives less than it, and at the mirror direction it is too low."""
    case = stack({"kind": "conductor", "metal": "aluminium", "roughness": base**0.5}, layer(1.5, top))
    belcour, adding = make_model("belcour", case), make_model("adding", case)
    wo, wi = spherical(np.radians(theta_deg), 0.0), spherical(np.radians(theta_deg), np.pi)
    green = (
        sum(weight[1] for weight, _ in belcour.lobes(wo[2])),
        belcour.albedo(wo)[1],
        belcour.f(wo, wi)[1],
        adding.albedo(wo)[1],
        adding.f(wo, wi)[1],
    )
    np.testing.assert_allclose(green, (weights, albedo, peak, truth, true_peak), rtol=0.01)


def test_kelemen_fills_a_white_coat_up_to_one():
    for case in ("coated white", "rough coat"):
        np.testing.assert_allclose(stressed("kelemen", case)[1], 1.0, atol=2e-3)


def test_formulas_at_normal_incidence():
    """f of each paper's formula with all directions on the normal, by hand."""
    alpha, f0 = 0.3, 0.04
    coated = stack(lambert(0.5), layer(1.5, alpha))
    peak = 1.0 / (np.pi * alpha**2) / 4.0
    n = 2.0 / alpha**2 - 2.0
    expected = {
        "torrance_sparrow": f0 * peak + (1.0 - f0) * 0.5 / np.pi,
        "schlick": f0 * peak + (1.0 - f0) * 0.5 / np.pi,
        "ashikhmin_shirley": f0 * (n + 1.0) / (8.0 * np.pi) + 28.0 * 0.5 / (23.0 * np.pi) * (1.0 - f0) * (31.0 / 32.0) ** 2,
        "lafortune": np.array([0.3094, 0.39667, 0.70837]) / np.pi + np.array([0.008508, 0.008612, 0.022901]),
    }
    for name, value in expected.items():
        np.testing.assert_allclose(make_model(name, coated).f(NORMAL, NORMAL), value, rtol=2e-3, err_msg=name)


def test_lafortune_ignores_the_stack():
    wo, wi = some_directions(20), some_directions(20, seed=6)
    values = [make_model("lafortune", STRESS[case]).f(wo, wi) for case in ("bare white", "mirror")]
    np.testing.assert_array_equal(*values)


@pytest.mark.parametrize("name", ["torrance_sparrow", "cycles_layer", "principled_coat", "openpbr_coat", "kelemen", "belcour"])
def test_an_interface_between_equal_indices_vanishes(name):
    """Not so for the two models whose Fresnel curve is Schlick's: it rises to 1 even from 0."""
    bare, coated = stack(lambert(0.5)), stack(lambert(0.5), layer(1.0))
    np.testing.assert_allclose(make_model(name, coated).albedo(VIEWS), make_model(name, bare).albedo(VIEWS), atol=2e-4)


@pytest.mark.parametrize("name", ["torrance_sparrow", "cycles_layer", "ashikhmin_shirley", "kelemen", "schlick"])
def test_absorption_is_a_round_trip_of_the_tint(name):
    tint = [0.9, 0.5, 0.2]
    clear, tinted = (make_model(name, stack(lambert(0.5), layer(1.5, 0.0, tint=t))) for t in ([1.0] * 3, tint))
    wo, wi = spherical(0.7, 0.0), spherical(0.4, 2.0)
    np.testing.assert_allclose(tinted.f(wo, wi) / clear.f(wo, wi), np.square(tint), rtol=1e-6)


def test_absorption_of_coats_grows_with_the_path_inside():
    tint = np.array([0.9, 0.5, 0.2])
    path_o, path_i = (1.0 / np.sqrt(1.0 - np.sin(theta) ** 2 / 1.5**2) for theta in (0.7, 0.4))
    paths = {"principled_coat": 2.0 * path_o, "openpbr_coat": path_o + path_i, "belcour": None}
    wo, wi = spherical(0.7, 0.0), spherical(0.4, 2.0)
    for name, path in paths.items():
        values = [make_model(name, stack(lambert(0.5), layer(1.5, 0.0, tint=list(t)))).f(wo, wi) for t in (np.ones(3), tint)]
        if path is None:  # its internal reflections pass the medium again: darker than the direct path
            assert np.all(values[1] < values[0] * tint ** (path_o + path_i))
        else:
            np.testing.assert_allclose(values[1] / values[0], tint**path, rtol=1e-6, err_msg=name)


def test_energy_compensation_is_that_of_the_lost_light():
    """A lossless GGX lobe keeps .877, .592 and .307 at normal view for alpha .3, .6 and 1 (rendered in Blender 5.0)."""
    for alpha, kept in ((0.3, 0.877), (0.6, 0.592), (1.0, 0.307)):
        lossless = Closure(alpha, "multi_ggx", dielectric(1.5), np.ones(1))
        assert 1.0 / lossless.gain(np.ones(1))[0, 0] == pytest.approx(kept, abs=2e-3)


def test_mean_fresnel_and_f82_have_their_closed_forms():
    # Egan and Hilgeman's integral at n = 1.5, and the moments 1/21 and 1/126 of (1 - c)^5 and c (1 - c)^6
    assert mean_fresnel(dielectric(1.5))[0] == pytest.approx(0.0918, abs=1e-4)
    f0, edge = np.array([0.9, 0.5, 0.2]), np.array([0.8, 0.5, 0.5])
    curve = f82(f0, edge)
    np.testing.assert_allclose(curve(np.ones(())), f0)
    np.testing.assert_allclose(curve(np.full((), 1.0 / 7.0)), edge)
    drop = (f0 + (1.0 - f0) * (6.0 / 7.0) ** 5 - edge) * 7.0 / (6.0 / 7.0) ** 6
    np.testing.assert_allclose(mean_fresnel(curve), f0 + (1.0 - f0) / 21.0 - drop / 126.0, rtol=1e-6)


def test_tables_of_cycles_hold_their_integrals():
    """Those of the file at nodes of every axis, and read between two of them."""
    tables, even, few = cycles.tables(), make_cycles_energies.nodes(32), make_cycles_energies.nodes(16)
    for i in (0, 7, 20, 31):
        np.testing.assert_allclose(tables["energy"][i], make_cycles_energies.energy(even, even[i] ** 2), atol=1e-8)
        assert tables["mean"][i] == pytest.approx(make_cycles_energies.mean_energy(even[i] ** 2), abs=1e-8)
    for i, depth in ((0, 3), (5, 15), (15, 0), (9, 8)):
        np.testing.assert_allclose(tables["rise"][i, depth], make_cycles_energies.rise(few, few[i] ** 2, few[depth]), atol=1e-8)
    lossless = Closure(0.3, "multi_ggx", dielectric(1.5), np.ones(1))
    kept = make_cycles_energies.energy(np.array([0.7]), 0.3)
    assert lossless.gain(np.array([0.7])) * kept == pytest.approx(1.0, abs=2e-3)
