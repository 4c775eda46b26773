# SPDX-License-Identifier: GPL-3.0-or-later
"""Optional features: what they are in a stack, and anisotropy, films and coverage in the models."""

import numpy as np
import pytest
from support.chi_square import chi_square_p_value

from lamina.reference_py.errors import LaminaError
from lamina.reference_py.lobes.eevee import eevee_tables
from lamina.reference_py.lobes.methods import MAX_CLOSURES, followed_by_nodes, key_of, make_lobe_set
from lamina.reference_py.lobes.methods.not_bakeable import needs_live
from lamina.reference_py.lobes.tabulate import tabulate
from lamina.reference_py.material.coverage import patches
from lamina.reference_py.material.place import Place
from lamina.reference_py.material.schema import ANISOTROPY, COVERAGE, NORMAL, SCHEMA_VERSION, THIN_FILM
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.models.patch_model import PatchModel
from lamina.reference_py.optics import microsurface
from lamina.reference_py.optics.frame import spherical
from lamina.reference_py.optics.fresnel import cos_theta_t, fresnel_conductor, fresnel_dielectric
from lamina.reference_py.optics.sampling import sample_visible_normals, visible_normal_density
from lamina.reference_py.optics.thin_film import Film, film_reflectance
from lamina.reference_py.registry import MODELS, make_model

COAT = {"kind": "dielectric", "ior": 1.5, "roughness": 0.5}
WHITE = {"kind": "lambert", "color": [1, 1, 1]}
STEEL = {"kind": "conductor", "metal": "iron", "roughness": 0.6}
BRUSHED = {"anisotropy": 0.8, "rotation": 0.1}
FILM = {"film_thickness": 400.0, "film_ior": 2.0}
WO = spherical(np.radians([0.0, 30.0, 60.0, 75.0]), 0.4)


def stack(layers, base):
    return Stack.from_dict({"layers": layers, "base": base})


def test_a_feature_is_there_when_any_of_its_parameters_is_given():
    one = stack([{**COAT, "rotation": 0.2}], {**WHITE, "normal": [0, 0, 0]})
    assert one.layers[0].has(ANISOTROPY) and one.layers[0]["anisotropy"] == 0.0
    assert one.base.has(NORMAL)
    assert not any(one.layers[0].has(feature) for feature in (COVERAGE, THIN_FILM, NORMAL))
    assert Stack.from_json(one.to_json()) == one
    with pytest.raises(LaminaError, match="here: layer 0: film_thickness is 3000; choose 0 to 2000 nm"):
        Stack.from_dict({"layers": [{**COAT, "film_thickness": 3000}], "base": WHITE}, "here")


AT_REST = {
    "film": ([{**COAT, **FILM}], WHITE, (0,)),
    "medium": ([{**COAT, "scatter_color": [0.8, 0.7, 0.5], "density": 1.0}], WHITE, (0,)),
    "metal": ([], STEEL, (None,)),
    "one of two": ([COAT], {**STEEL, **BRUSHED}, (0,)),
}


@pytest.mark.parametrize("tier", ["auto", "baked"])
@pytest.mark.parametrize("name", AT_REST)
def test_an_anisotropy_of_0_that_nothing_drives_is_none(name, tier):
    """A film fell back to another model, a medium was refused, and stock nodes of a metal followed no roughness."""
    layers, base, where = AT_REST[name]
    plain, rest = stack(layers, base), {"anisotropy": 0.0, "rotation": 0.25}
    ticked = stack([{**layer, **(rest if i in where else {})} for i, layer in enumerate(layers)], {**base, **(rest if None in where else {})})
    assert ticked != plain and key_of(ticked, tier) == key_of(plain, tier)
    roughness, rotation, anisotropy = (Place(where[0], p) for p in ("roughness", "rotation", "anisotropy"))
    assert roughness in followed_by_nodes(ticked, tier, (roughness, rotation))
    assert followed_by_nodes(ticked, tier, (roughness,)) == followed_by_nodes(plain, tier, (roughness,))
    made, expected = make_lobe_set(ticked, tier), make_lobe_set(plain, tier)
    assert made.lobe_set.name == expected.lobe_set.name and made.reason == expected.reason
    for own, other in zip(made.lobes(WO[:, 2]), expected.lobes(WO[:, 2]), strict=True):
        assert np.allclose(own.weight, other.weight, rtol=0.01)
    # what a user gives a value shows where the lobes are live, and what is driven counts
    assert not made.lobe_set.is_live or made.lobe_set.stack == ticked
    assert key_of(ticked, tier, live=(roughness,)) == key_of(plain, tier, live=(roughness,)) == key_of(ticked, tier, live=(roughness, rotation))
    assert followed_by_nodes(ticked, tier, (anisotropy,)) == ((anisotropy,) if name == "metal" else ())


def test_a_version_1_stack_means_what_it_meant():
    old = {"schema_version": 1, "layers": [{**COAT, "coverage": "all of it", "note": 1}], "base": STEEL}
    read = Stack.from_dict(old)
    assert not read.layers[0].has(COVERAGE)
    assert dict(read.layers[0].unknown) == {"coverage_v1": "all of it", "note": 1}
    again = Stack.from_json(read.to_json())
    assert again == read and again.to_dict()["schema_version"] == SCHEMA_VERSION
    assert read.layers[0].values == stack([COAT], STEEL).layers[0].values


def test_patches_have_the_layers_that_are_there():
    parts = patches(stack([{**COAT, "coverage": 0.25}, COAT, {**COAT, "ior": 1.8, "coverage": 0.5}], WHITE))
    assert [p.layers for p in parts] == [(0, 1, 2), (0, 1), (1, 2), (1,)]
    assert [p.share for p in parts] == [0.125, 0.125, 0.375, 0.375]
    assert not any(layer.has(COVERAGE) for p in parts for layer in p.stack.layers)
    with pytest.raises(LaminaError, match="4 clear layers have a coverage .*choose at most 3"):
        patches(stack([{**COAT, "coverage": 0.5}] * 4, WHITE))


# A closure model is one lobe set whose quadrature sees other lobes: its albedo is as exact as that.
@pytest.mark.parametrize("name, rtol", [("weidlich_wilkie", 1e-12), ("adding", 1e-12), ("position_free", 1e-12), ("belcour", 1e-12), ("closure_model", 1e-3)])
def test_coverage_is_exact_at_its_ends_and_the_mean_between(name, rtol):
    options = {"closure_model": {"method": "analytic"}, "position_free": {"walks": 64}}.get(name, {})
    tinted = {**COAT, "tint": [0.9, 0.5, 0.2]}
    glaze = {**COAT, "ior": 1.8}

    def figures(layers):
        model = make_model(name, stack(layers, STEEL), **options)
        return np.stack([model.albedo(WO[:2]), model.f(WO[:2], spherical(np.radians(20.0), 2.0) * np.ones((2, 1)))])

    there, gone = figures([tinted, glaze]), figures([glaze])
    assert np.allclose(figures([{**tinted, "coverage": 1.0}, glaze]), there, rtol=rtol)
    assert np.allclose(figures([{**tinted, "coverage": 0.0}, glaze]), gone, rtol=rtol)
    assert np.allclose(figures([{**tinted, "coverage": 0.5}, glaze]), 0.5 * (there + gone), rtol=rtol)


@pytest.mark.parametrize("generator", [False, True])
def test_the_error_of_walks_of_patches_is_that_of_their_mean(generator):
    # two patches that are alike err alike with the same random numbers, and 1.41 times less with other ones
    grey = {"kind": "lambert", "color": [0.5, 0.5, 0.5]}
    alike = stack([COAT, {**grey, "coverage": 0.5}], grey)
    figures = [make_model("position_free", alike, walks=100, seed=s).albedo_stderr(WO[1], rng=s if generator else None) for s in range(200)]
    albedo, error = (np.array(values)[:, 0] for values in zip(*figures))
    assert np.std(albedo) == pytest.approx(np.mean(error), rel=0.2)
    assert np.std(albedo) == pytest.approx(0.016 if generator else 0.022, rel=0.3)


def test_a_covered_white_stack_is_white():
    white = stack([{**COAT, "coverage": 0.3}, {**COAT, "ior": 1.8, "coverage": 0.6}], WHITE)
    assert np.allclose(make_model("adding", white).albedo(WO), 1.0, atol=1e-3)


@pytest.mark.parametrize("tier, covered", [("weidlich_wilkie", 2), ("analytic", 2), ("baked", 2), ("auto", 1)])
def test_patches_keep_within_the_closures_of_a_shader(tier, covered):
    """Bakes of as many lobes as without coverage would have 8 and 17 here, and those of grey and white ones more."""
    layers = [{**COAT, "roughness": 0.3 + 0.2 * i, "tint": [1.0, 0.8, 0.6], "coverage": 0.5} for i in range(covered)]
    assert 2 <= make_lobe_set(stack(layers, STEEL), tier).lobe_count <= MAX_CLOSURES


def test_a_patch_model_samples_its_density():
    covered = stack([{**COAT, "coverage": 0.4}], STEEL)
    model = PatchModel([(patch, make_model("closure_model", patch.stack, method="weidlich_wilkie")) for patch in patches(covered)])
    wo = np.broadcast_to(spherical(np.radians(50.0), 0.3), (60000, 3))
    wi, valid = model.sample(wo, np.random.default_rng(1))
    assert chi_square_p_value(wi[valid], lambda w: model.pdf(np.broadcast_to(wo[0], w.shape), w), drawn=len(wo)) > 1e-4


@pytest.mark.parametrize("name", ["adding", "weidlich_wilkie", "belcour"])
@pytest.mark.parametrize("feature, element, able", [("anisotropy", BRUSHED, ""), ("thin_film", FILM, "adding, ")])
def test_models_name_what_they_do_not_know(name, feature, element, able):
    if f"{name}, " == able:
        assert np.all(make_model(name, stack([], {**STEEL, **element})).albedo(WO) < 1.0)
    else:
        with pytest.raises(LaminaError, match=f"model {name} knows no {feature}, which base has; choose {able}position_free, closure_model"):
            make_model(name, stack([], {**STEEL, **element}))
    assert name in MODELS


def test_what_a_bake_cannot_hold_is_named_and_makes_it_live():
    one = stack([{**COAT, **BRUSHED, "coverage": 0.5}, {**COAT, **FILM}], {**WHITE, "normal": [0, 0, 0]})
    assert needs_live(one) == "the anisotropy of layer 0", "a film and a normal leave the bake in force"
    assert needs_live(stack([{**COAT, **FILM}], {**WHITE, "normal": [0, 0, 0]})) == "the thin film of layer 0", "a top that is no lobe apart"
    assert needs_live(stack([{**COAT, **FILM, "roughness": 0.0}], {**WHITE, "normal": [0, 0, 0]})) is None
    assert needs_live(stack([{**COAT, "coverage": 0.5}], WHITE)) is None
    assert make_lobe_set(one, "baked").lobe_set.parts[0][1].reason == "weidlich_wilkie, as a bake cannot hold the anisotropy of layer 0"
    assert needs_live(stack([{**COAT, **BRUSHED, "coverage": 0.5}], WHITE)) is None, "a brushed layer is baked"
    assert make_lobe_set(stack([], {**STEEL, **BRUSHED}), "baked").reason == "the base's own closures, right within 1 %"


@pytest.mark.parametrize("kind", ["ggx", "beckmann"])
@pytest.mark.parametrize("theta_deg", [30.0, 80.0, 120.0])
def test_visible_normals_of_anisotropic_surfaces(kind, theta_deg):
    w = np.broadcast_to(spherical(np.radians(theta_deg), 0.7), (60000, 3))
    alpha = (0.7, 0.2)
    normals = sample_visible_normals(w, alpha, kind, np.random.default_rng(3))

    def density(m):
        return visible_normal_density(np.broadcast_to(w[0], m.shape), m, alpha, kind)

    assert chi_square_p_value(normals, density, bins=(16, 48)) > 1e-4


@pytest.mark.parametrize("surface", ["single", "multiple"])
def test_turning_an_anisotropic_stack_turns_its_light(surface):
    layers = [{**COAT, **BRUSHED}]
    turned = [{**COAT, **BRUSHED, "rotation": BRUSHED["rotation"] + 0.2}]
    wi = spherical(np.radians([10.0, 50.0, 20.0, 60.0]), 2.0)

    def turn(w):
        c, s = np.cos(0.4 * np.pi), np.sin(0.4 * np.pi)
        return np.stack([c * w[:, 0] - s * w[:, 1], s * w[:, 0] + c * w[:, 1], w[:, 2]], axis=-1)

    one = make_model("position_free", stack(layers, {**STEEL, **BRUSHED}), surface=surface, walks=4000)
    other = make_model("position_free", stack(turned, {**STEEL, **BRUSHED, "rotation": 0.3}), surface=surface, walks=4000)
    (f, error), (g, other_error) = one.f_stderr(WO, wi), other.f_stderr(turn(WO), turn(wi))
    assert np.all(np.abs(f - g) <= 4.0 * np.hypot(error, other_error))


def test_single_scattering_brushed_metal_is_the_formula():
    base = {**STEEL, **BRUSHED}
    model = make_model("position_free", stack([], base), surface="single", walks=16)
    lobe = make_model("closure_model", stack([], base), method="weidlich_wilkie").lobe_set.lobes(np.ones(1))[0]
    wi = spherical(np.radians([25.0, 40.0, 55.0, 70.0]), np.array([1.0, 2.5, 3.3, 4.0]))
    c, s = np.cos(lobe.frame), np.sin(lobe.frame)
    own = [np.stack([c * w[:, 0] + s * w[:, 1], c * w[:, 1] - s * w[:, 0], w[:, 2]], axis=-1) for w in (WO, wi)]
    alpha = (lobe.alpha_x, lobe.alpha_y)
    h = own[0] + own[1]
    h /= np.linalg.norm(h, axis=-1, keepdims=True)
    d = visible_normal_density(h, h, alpha, "ggx") * microsurface.projected_area(h, alpha, "ggx")
    g = microsurface.masking(own[0], alpha, "ggx") * microsurface.masking(own[1], alpha, "ggx")
    cos_h = np.sum(own[0] * h, axis=-1)
    from lamina.reference_py.optics.colour import conductor_rgb

    expected = (d * g / (4.0 * WO[:, 2] * wi[:, 2]))[:, None] * fresnel_conductor(cos_h[:, None], *conductor_rgb("iron"))
    assert np.allclose(model.f(WO, wi), expected, rtol=1e-6)


@pytest.mark.parametrize("extra", [BRUSHED, FILM, {**BRUSHED, **FILM}], ids=["brushed", "film", "both"])
@pytest.mark.parametrize("kind", ["ggx", "beckmann"])
def test_white_stacks_with_features_are_white(extra, kind):
    layers = [{**COAT, **extra, "distribution": kind}, {**COAT, "roughness": 0.0, "ior": 1.8, **extra}]
    albedo, error = make_model("position_free", stack(layers, WHITE), walks=4000).albedo_stderr(WO)
    assert np.all(np.abs(albedo - 1.0) <= 4.0 * error + 1e-9)


def test_f_with_a_film_is_reciprocal_and_sums_to_the_albedo():
    model = make_model("position_free", stack([{**COAT, **FILM}], STEEL), walks=40000)
    wi = spherical(np.radians([25.0, 40.0, 55.0, 70.0]), 2.0)
    edges = np.linspace(0.0, np.pi / 2, 7), np.linspace(0.0, 2.0 * np.pi, 2)
    histogram = model.histogram(WO[2], *edges)
    albedo, error = model.albedo_stderr(WO[2])
    assert np.all(np.abs(histogram.energy.sum(axis=(0, 1)) - albedo) <= 4.0 * np.hypot(error, histogram.stderr.sum(axis=(0, 1))))
    u = (np.arange(40) + 0.5) / 40
    cos, phi = np.meshgrid(np.sqrt(u), 2.0 * np.pi * u)
    directions = spherical(np.arccos(cos).ravel(), phi.ravel())
    quick = make_model("position_free", stack([{**COAT, **FILM}], STEEL), walks=60)
    integral = np.pi * quick.f(np.broadcast_to(WO[2], directions.shape), directions).mean(axis=0)
    assert np.allclose(integral, albedo, rtol=0.02)
    assert np.all(np.isfinite(model.f(WO, wi)))


COSINES = np.cos(np.radians([0.0, 30.0, 60.0, 80.0]))


def test_a_vanishing_film_leaves_the_fresnel_equations():
    for film in (Film(0.0, 2.0), Film(300.0, 1.0)):
        assert np.allclose(film_reflectance(COSINES, 1.0, film, 1.5), fresnel_dielectric(COSINES, 1.5)[:, None], rtol=1e-9)
        metal = film_reflectance(COSINES, 1.0, film, np.array([0.2, 0.9, 1.1]), np.array([3.9, 2.4, 2.1]))
        exact = fresnel_conductor(COSINES[:, None], np.array([0.2, 0.9, 1.1]), np.array([3.9, 2.4, 2.1]))
        assert np.allclose(metal, exact, rtol=1e-9)


def test_a_quarter_wave_film_does_not_reflect():
    """Index sqrt(1.5 * 1), a quarter of 550 nm thick: green light vanishes, as from a coated lens."""
    film = Film(550.0 / 4.0 / 1.5**0.5, 1.5**0.5)
    reflectance = film_reflectance(np.ones(1), 1.0, film, 1.5)[0]
    assert reflectance[1] < 0.1 * fresnel_dielectric(1.0, 1.5)


@pytest.mark.parametrize("k", [None, np.array([2.0, 2.5, 3.0])])
@pytest.mark.parametrize("thickness", [120.0, 500.0])
def test_a_film_against_airys_formula_integrated_over_the_spectrum(k, thickness):
    """The exact amplitude of a film per wavelength, an independent way to the same color; the series stops at three terms."""
    from lamina.reference_py.optics.colour.spectrum import observer_rgb

    n = np.array([1.5, 1.5, 1.5]) if k is None else np.array([0.3, 0.8, 1.2])
    film = Film(thickness, 1.7)
    wavelength_nm, matching = observer_rgb()
    expected = np.empty((len(COSINES), 3))
    for row, cos in enumerate(COSINES):
        inner = cos_theta_t(cos, film.ior)
        for channel in range(3):
            index = n[channel] + 1j * (0.0 if k is None else k[channel])
            last = np.sqrt(index**2 - (1.0 - cos**2)) / index
            turn = np.exp(4j * np.pi * film.ior * thickness * inner / wavelength_nm)
            total = 0.0
            for (a, b), (c, d) in (((cos, film.ior * inner), (film.ior * inner, index * last)),
                                   ((film.ior * cos, inner), (index * inner, film.ior * last))):  # fmt: skip
                r12, r23 = (a - b) / (a + b), (c - d) / (c + d)
                total = total + 0.5 * np.abs((r12 + r23 * turn) / (1.0 + r12 * r23 * turn)) ** 2
            expected[row, channel] = total @ matching[:, channel] / matching[:, channel].sum()
    value = film_reflectance(COSINES, 1.0, film, n[0] if k is None else n, k)
    errors = np.abs(value - np.clip(expected, 0.0, 1.0)).max(axis=-1)
    print(errors)
    # Cycles stops at three terms: on metal at grazing angles more would count
    assert np.all(errors[:3] <= 8e-3) and errors[3] <= (5e-3 if k is None else 5e-2)


def test_lobes_are_about_the_normal_of_their_element_in_every_form():
    """The coat's reflection about the coat's, what comes from below about the base's; live ones, bakes and tables alike, each in the patch that has it."""
    own = {"normal": [0.0, 0.0, 0.0]}
    rough, gold = {**COAT, "roughness": 0.4, **own}, {"kind": "conductor", "metal": "gold", "roughness": 0.3}
    one, plain = stack([rough], {**gold, **own}), stack([{**COAT, "roughness": 0.4}], gold)
    for method in ("weidlich_wilkie", "analytic", "baked", "auto"):
        made = make_lobe_set(one, method)
        tables = tabulate(made.lobe_set)
        for lobe_set in (made.lobe_set, tables, eevee_tables(made.lobe_set, tables)):
            layers = [lobe.normal.layer for lobe in lobe_set.lobes(np.ones(1))]
            assert layers[0] == 0 and set(layers[1:]) == {None}, method
        assert all(lobe.normal is None for lobe in make_lobe_set(plain, method).lobes(np.ones(1)))
    chipped = make_lobe_set(stack([{**rough, "coverage": 0.5}], {**gold, **own}), "baked").lobe_set
    assert [{lobe.normal.layer for lobe in part.lobe_set.lobes(np.ones(1))} for _, part in chipped.parts] in ([{0, None}, {None}], [{None}, {0, None}])
