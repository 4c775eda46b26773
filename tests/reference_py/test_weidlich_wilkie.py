# SPDX-License-Identifier: GPL-3.0-or-later
import numpy as np
import pytest
from support.stacks import coat, conductor, lambert, stack, view

from lamina.reference_py.errors import LaminaError
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.models.weidlich_wilkie import OPTIONS, WeidlichWilkie
from lamina.reference_py.models.weidlich_wilkie_repaired import WeidlichWilkieRepaired
from lamina.reference_py.optics.blinn import blinn_exponent
from lamina.reference_py.optics.frame import dot, half_vector, spherical
from lamina.reference_py.optics.fresnel import fresnel_conductor, fresnel_dielectric
from lamina.reference_py.optics.microfacet import distribution, masking_g2
from lamina.reference_py.optics.quadrature import directional_albedo
from lamina.reference_py.registry import make_model
from lamina.study.suite import suite

MODELS = (WeidlichWilkie, WeidlichWilkieRepaired)
BLACK = {"kind": "lambert", "color": [0.0] * 3}


def directions(n, seed):
    rng = np.random.default_rng(seed)
    return spherical(np.arccos(rng.random(n)), 2.0 * np.pi * rng.random(n))


# A conductor that absorbs less than 2e-4 under n = 1.5.
LOSSLESS = conductor(0.01, 20.0, 0.1)
MIXED = {
    "smooth on lambert": stack(coat(0.0, tint=[0.6, 0.8, 1.0]), base=lambert(0.8)),
    "beckmann on oren-nayar": stack(
        coat(0.3, distribution="beckmann", tint=[0.6, 0.8, 1.0]),
        base={"kind": "oren_nayar", "color": [0.9, 0.5, 0.1], "sigma_deg": 30.0},
    ),
    "rough on metal": stack(coat(0.3, tint=[0.5, 0.5, 1.0]), base=conductor(0.2, 3.9, 0.2)),
    "dense, thin, metal": stack(coat(0.2, ior=2.2), coat(0.4, ior=1.2), base=conductor(1.1, 2.6, 0.3, "beckmann")),
}


@pytest.mark.parametrize(
    "model, options, expected",
    (
        # what the interface transmits and a lossless base returns, all orders, is .960, .954, .911, .612
        (WeidlichWilkie, {}, (0.891, 0.639, 0.332, 0.078)),
        (WeidlichWilkie, {"refraction": "macro_normal"}, (1.93, 1.75, 1.31, 0.60)),
        (WeidlichWilkieRepaired, {}, (0.857, 0.778, 0.580, 0.267)),
    ),
)
def test_energy_of_base_lobe_under_smooth_coat(model, options, expected):
    """Independent figures for n = 1.5 over GGX alpha .1 at 0, 40, 60 and 80 degrees, to a little over their last digit."""
    model = model(stack(coat(0.0), base=LOSSLESS), **options)
    energy = directional_albedo(lambda wo, wi: model.components(wo, wi)[-1], view([0.0, 40.0, 60.0, 80.0]), [("ggx", 0.1)])
    print(model.name, options, np.round(energy[:, 0], 4))
    assert energy[:, 0] == pytest.approx(np.array(expected), abs=5e-3 if expected[0] > 1.0 else 1.5e-3)


@pytest.mark.parametrize("model, options, expected", ((WeidlichWilkie, {"refraction": "macro_normal"}, 0.476), (WeidlichWilkieRepaired, {}, 0.234)))
def test_albedo_of_coated_grey_at_normal_incidence(model, options, expected):
    """Known figures for n = 1.5 over Lambert .5; with all orders of bounces it would be .316."""
    albedo = model(stack(coat(0.0), base=lambert(0.5)), **options).albedo(view(0.0))
    assert albedo == pytest.approx(np.full(3, expected), abs=1e-3)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("kind", ("ggx", "beckmann"))
def test_without_layers_it_is_torrance_sparrow(model, kind):
    wo, wi = directions(200, 1), directions(200, 2)
    wh = half_vector(wi, wo)
    lobe = distribution(wh[:, 2], 0.3, kind) * masking_g2(wi[:, 2], wo[:, 2], 0.3, kind) / (4.0 * wi[:, 2] * wo[:, 2])
    bare = model(stack(base=conductor(0.2, 3.9, 0.3, kind))).f(wo, wi)
    assert bare == pytest.approx((fresnel_conductor(dot(wi, wh), 0.2, 3.9) * lobe)[:, None] * np.ones(3), rel=1e-9)
    varnish = model(stack(coat(0.3, distribution=kind), base=BLACK)).f(wo, wi)
    assert varnish == pytest.approx((fresnel_dielectric(dot(wi, wh), 1.5) * lobe)[:, None] * np.ones(3), rel=1e-9)


@pytest.mark.parametrize("model", MODELS)
def test_clear_interface_leaves_absorption_alone(model):
    """Weidlich07, eqs. 5 and 6, over Lambert: an interface of index 1 neither reflects nor bends."""
    wo, wi, tint = directions(100, 3), directions(100, 4), np.array([0.9, 0.4, 0.1])
    f = model(stack(coat(0.2, ior=1.0, tint=tint.tolist(), thickness=0.7), base=lambert(0.6))).f(wo, wi)
    path = 0.7 * (1.0 / wi[:, 2] + 1.0 / wo[:, 2])
    assert f == pytest.approx(0.6 / np.pi * tint ** path[:, None], rel=1e-9)


def test_misprinted_absorption_divides_by_the_angle():
    wo, wi = view(50.0), view(20.0, 2.0)
    model = WeidlichWilkie(stack(coat(0.2, ior=1.0, tint=[0.5] * 3), base=lambert(0.6)), absorption="inverse_angle")
    expected = 0.6 / np.pi * 0.5 ** (1.0 / np.radians(50.0) + 1.0 / np.radians(20.0))
    assert model.f(wo, wi) == pytest.approx(np.full(3, expected))


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("name", MIXED)
def test_no_thickness_no_absorption(model, name):
    data = MIXED[name].to_dict()
    thin = [{**layer, "tint": [0.3, 0.5, 0.7], "thickness": 0.0} for layer in data["layers"]]
    clear = [{**layer, "tint": [1.0] * 3} for layer in data["layers"]]
    wo, wi = directions(50, 5), directions(50, 6)
    values = [model(Stack.from_dict({**data, "layers": layers})).f(wo, wi) for layers in (thin, clear)]
    assert np.array_equal(*values)


def test_compensation_is_equation_4():
    """Where wi = wo neither direction bends about the half vector, and G is below 1."""
    w = view(70.0)
    material = stack(coat(0.5), base=lambert(0.6))
    t, g = 1.0 - fresnel_dielectric(1.0, 1.5), masking_g2(w[2], w[2], 0.5, "ggx")
    assert g < 0.8
    for choice, back in (("interface", (1.0 - g) + t * g), ("none", t)):
        base = WeidlichWilkie(material, compensation=choice).components(w, w)[-1]
        assert base == pytest.approx(np.full(3, 0.6 / np.pi * t * back))


def test_blinn_and_v_cavities_are_those_of_the_paper():
    """Eqs. 1 and 7 on one dielectric interface."""
    wo, wi = view(60.0), view(30.0, 2.5)
    wh = half_vector(wi, wo)
    m, cos_h = blinn_exponent(0.3), dot(wi, wh)
    d = (m + 2.0) / (2.0 * np.pi) * wh[2] ** m
    g = min(1.0, 2.0 * wh[2] * wo[2] / cos_h, 2.0 * wh[2] * wi[2] / cos_h)
    expected = fresnel_dielectric(cos_h, 1.5) * d * g / (4.0 * wi[2] * wo[2])
    model = WeidlichWilkie(stack(coat(0.3), base=BLACK), distribution="blinn", masking="v_cavity")
    assert model.f(wo, wi) == pytest.approx(np.full(3, expected))


@pytest.mark.parametrize("option", OPTIONS)
def test_every_choice_of_every_option_counts(option):
    wo, wi = directions(100, 7), directions(100, 8)
    values = [WeidlichWilkie(MIXED["beckmann on oren-nayar"], **{option: choice}).f(wo, wi) for choice in OPTIONS[option]]
    default = WeidlichWilkie(MIXED["beckmann on oren-nayar"]).f(wo, wi)
    assert np.array_equal(values[0], default)
    assert np.max(np.abs(values[1] / default - 1.0)) > 0.02


@pytest.mark.parametrize(
    "name, options, message",
    (
        ("weidlich_wilkie", {"refractoin": "x"}, r"unknown option 'refractoin'; choose refraction, absorption, compensation"),
        ("weidlich_wilkie", {"masking": "x"}, r"unknown masking 'x'; choose smith, v_cavity"),
        ("weidlich_wilkie_repaired", {"refraction": "half_vector"}, r"unknown option 'refraction'; choose weights"),
        ("weidlich_wilkie_repaired", {"weights": "x"}, r"unknown weights 'x'; choose energy, constant"),
    ),
)
def test_bad_options_name_the_choices(name, options, message):
    with pytest.raises(LaminaError, match=f"model {name}: {message}"):
        make_model(name, MIXED["rough on metal"], **options)


@pytest.mark.parametrize(
    "model, options",
    ((WeidlichWilkie, {}), (WeidlichWilkie, {"refraction": "macro_normal", "compensation": "none"}), (WeidlichWilkieRepaired, {})),
)
def test_reciprocity(model, options):
    wo, wi = directions(100, 9), directions(100, 10)
    for material in [*suite().values(), *MIXED.values()]:
        reflector = model(material, **options)
        assert reflector.f(wo, wi) == pytest.approx(reflector.f(wi, wo), rel=1e-7, abs=1e-12), material.name


def test_compensation_breaks_reciprocity_about_the_surface_normal():
    """Eq. 4 compensates T21 alone; T12 and T21 differ as soon as the directions do not share a facet."""
    wo, wi = view(20.0), view(80.0, 1.0)
    model = WeidlichWilkie(stack(coat(0.5), base=lambert(0.6)), refraction="macro_normal")
    ratio = model.components(wo, wi)[-1] / model.components(wi, wo)[-1]
    assert np.all(np.abs(ratio - 1.0) > 0.05)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("count", (0, 1, 2, 5, 12, 20))
def test_any_number_of_layers(model, count):
    rng = np.random.default_rng(count)
    layers = [
        coat(
            rng.choice([0.0, 0.05, 0.4, 1.0]),
            rng.uniform(1.0, 2.5),
            rng.choice(["ggx", "beckmann"]).item(),
            tint=rng.random(3).tolist(),
            thickness=float(rng.exponential(0.1)),
        )
        for _ in range(count)
    ]
    reflector = model(stack(*layers, base=conductor(0.2, 3.9, 0.2)))
    f = reflector.f(directions(500, 11), directions(500, 12))
    assert np.all(np.isfinite(f)) and np.all(f >= 0.0) and np.any(f > 0.0)
    assert len(reflector.components(view(10.0), view(20.0))) == count + 1


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("place", (0, 1, 2))
def test_interface_without_a_step_of_index_vanishes(model, place):
    layers = [coat(0.2, ior=1.4), coat(0.1, ior=1.9)]
    ghost = coat(0.5, ior=(1.0, 1.4, 1.9)[place])
    base = conductor(0.2, 3.9, 0.2)
    wo, wi = directions(100, 13), directions(100, 14)
    with_ghost = model(stack(*layers[:place], ghost, *layers[place:], base=base)).f(wo, wi)
    assert with_ghost == pytest.approx(model(stack(*layers, base=base)).f(wo, wi), rel=1e-9)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("alpha", (0.0, 1e-4, 0.1, 1.0))
def test_finite_at_every_pair_of_directions(model, alpha):
    theta = np.array([0.0, 1e-9, 45.0, 85.0, 89.9, 89.999999, 90.0])
    w = view(theta[:, None], np.radians([0.0, 90.0, 180.0])).reshape(-1, 3)
    base = {"kind": "oren_nayar", "color": [1.0, 0.5, 0.0], "sigma_deg": 90.0}
    for material in (
        stack(coat(alpha, ior=1.0), base=base),
        stack(coat(alpha, tint=[0.0, 1.0, 0.5], thickness=1000.0), base=base),
        stack(coat(alpha), coat(alpha, ior=4.0), base=conductor(0.2, 3.9, alpha)),
    ):
        reflector = model(material)
        f = reflector.f(w[:, None], w[None])
        assert np.all(np.isfinite(f)) and np.all(f >= 0.0)
        assert np.all(reflector.f(w, -w) == 0.0) and np.all(reflector.f(-w, w) == 0.0) and np.all(reflector.f(-w, -w) == 0.0)
        assert np.all(np.isfinite(reflector.pdf(w[:, None], w[None])))
        assert np.all(np.isfinite(reflector.sample(w, np.random.default_rng(0))[0]))


@pytest.mark.parametrize("name", ("smooth on lambert", "rough on metal", "dense, thin, metal"))
def test_repaired_reflects_no_more_than_it_receives(name):
    data = MIXED[name].to_dict()
    white = lambert(1.0) if data["base"]["kind"] == "lambert" else LOSSLESS
    clear = [{**layer, "tint": [1.0] * 3} for layer in data["layers"]]
    albedo = WeidlichWilkieRepaired(Stack.from_dict({"layers": clear, "base": white})).albedo(view([0.0, 60.0, 85.0, 89.0]))
    print(name, np.round(albedo[:, 0], 3))
    assert np.all(albedo <= 1.0 + 1e-3)
