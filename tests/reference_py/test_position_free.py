# SPDX-License-Identifier: GPL-3.0-or-later
import numpy as np
import pytest
from support.stacks import coat, conductor, lambert, stack, view

from lamina.reference_py.errors import LaminaError
from lamina.reference_py.models import position_free
from lamina.reference_py.models.position_free import Cancelled, PositionFree
from lamina.reference_py.models.position_free.walk import connected_f
from lamina.reference_py.models.position_free.walk_surfaces import Surfaces
from lamina.reference_py.optics import microsurface
from lamina.reference_py.optics.frame import spherical
from lamina.reference_py.optics.fresnel import cos_theta_t, fresnel_dielectric
from lamina.reference_py.optics.optical_stack import OpticalStack
from lamina.reference_py.registry import make_model

SURFACES = ("multiple", "single")


def within(value, stderr, expected, floor=1e-9):
    assert np.all(np.abs(value - expected) <= 4.0 * stderr + floor), (value, stderr, expected)


# A conductor that absorbs less than 2e-4 under n = 1.5.
LOSSLESS = conductor(0.01, 20.0, 0.1)

MIXED = {
    "smooth on lambert": stack(coat(0.0, tint=[0.6, 0.8, 1.0]), base=lambert(0.8)),
    "rough on lambert": stack(coat(0.4, tint=[0.6, 0.8, 1.0]), base=lambert(0.8)),
    "beckmann on oren-nayar": stack(coat(0.3, distribution="beckmann"), base={"kind": "oren_nayar", "color": [0.9, 0.5, 0.1], "sigma_deg": 30.0}),
    "rough on rough metal": stack(coat(0.3), base=conductor(0.2, 3.9, 0.3)),
    "rough on mirror": stack(coat(0.4), base=conductor(0.2, 3.9, 0.0)),
    "rough, rough, metal": stack(coat(0.3), coat(0.4, ior=1.9), base=conductor(1.1, 2.6, 0.4)),
    "smooth, rough, lambert": stack(coat(0.0), coat(0.4, ior=1.3, tint=[0.5, 1, 1]), base=lambert(0.7)),
    "rough, smooth, lambert": stack(coat(0.4, ior=1.7), coat(0.0, ior=1.3), base=lambert(0.7)),
}


def uniform_projected(n, rng):
    """Light directions of density cos / pi."""
    u = rng.random((n, 2))
    return spherical(np.arcsin(np.sqrt(u[:, 0])), 2.0 * np.pi * u[:, 1])


@pytest.mark.parametrize("distribution", ("ggx", "beckmann"))
@pytest.mark.parametrize("alpha", (0.0, 0.1, 0.4, 1.0))
def test_white_furnace_of_multiple(alpha, distribution):
    white = stack(coat(alpha, distribution=distribution), coat(0.2, ior=1.2), base=lambert(1.0))
    albedo, stderr = PositionFree(white, walks=3000).albedo_stderr(view([0.0, 60.0, 89.0]))
    within(albedo, stderr, 1.0)


def test_white_furnace_of_f():
    white = stack(coat(0.3), coat(0.5, ior=1.2), base=lambert(1.0))
    wi = uniform_projected(15_000, np.random.default_rng(1))
    f = np.pi * PositionFree(white, walks=2).f(view(40.0), wi)[:, 0]
    within(f.mean(), f.std() / len(f) ** 0.5, 1.0)


def test_smooth_coat_on_lambert_is_the_closed_form():
    """f = T(o) a(o) T(i) a(i) / n^2 rho / pi / (1 - rho R_d), with R_d of the coat seen from the base."""
    n, rho = 1.5, 0.5
    tint = np.array([1.0, 0.7, 0.2])
    tau = -np.log(tint)
    mu = (np.arange(20_000) + 0.5) / 20_000
    inside = fresnel_dielectric(mu, 1.0 / n)[:, None] * np.exp(-2.0 * tau / mu[:, None])
    r_d = np.mean(2.0 * mu[:, None] * inside, axis=0)

    def crossing(cos):
        return (1.0 - fresnel_dielectric(cos, n)) * np.exp(-tau / cos_theta_t(cos, n))

    wo, wi = view(30.0), view(65.0, 2.0)
    expected = crossing(wo[2]) * crossing(wi[2]) / n**2 * rho / np.pi / (1.0 - rho * r_d)
    model = PositionFree(stack(coat(0.0, tint=tint.tolist()), base=lambert(rho)), walks=100_000)
    f, stderr = model.f_stderr(wo, wi)
    assert np.all(stderr < 0.01 * f)
    within(f, stderr, expected)
    t_d = np.mean(2.0 * mu[:, None] * (1.0 - fresnel_dielectric(mu, 1.0 / n))[:, None] * np.exp(-tau / mu[:, None]), axis=0)
    albedo, stderr = model.albedo_stderr(wo)
    within(albedo, stderr, fresnel_dielectric(wo[2], n) + crossing(wo[2]) * rho * t_d / (1.0 - rho * r_d))


@pytest.mark.parametrize("surface, alpha, rho, expected", (("single", 0.0, 0.5, 0.316), ("multiple", 0.0, 0.5, 0.316), ("single", 0.4, 0.8, 0.450)))
def test_known_albedo_at_normal_incidence(surface, alpha, rho, expected):
    albedo, stderr = PositionFree(stack(coat(alpha), base=lambert(rho)), surface=surface).albedo_stderr(view(0.0))
    within(albedo, stderr, expected, floor=5e-4)


def test_base_lobe_under_smooth_coat_has_what_the_coat_transmits():
    theta = np.array([0.0, 40.0, 60.0, 80.0])
    by_depth, stderr = PositionFree(stack(coat(0.0), base=LOSSLESS), walks=30_000).albedo_by_depth(view(theta))
    within(by_depth[:, 1], stderr[:, 1], 1.0 - fresnel_dielectric(np.cos(np.radians(theta)), 1.5)[:, None], floor=5e-4)


# Albedo at 0, 30, 60, 75 and 85 degrees of explicit slabs, 2000 wide and 0.1 thick under a uniform sky, by the path
# tracer of Mitsuba 3.9.1 (roughdielectric n = 1.5 over diffuse .8 or roughconductor eta .2 / 1.5, k 3.9 / 1.5):
# 262 144 paths each, standard error about 6e-4.
SLABS = (
    (coat(0.0), lambert(0.8), (0.6327, 0.6332, 0.6515, 0.7148, 0.8518)),
    (coat(0.1), lambert(0.8), (0.6036, 0.6043, 0.6191, 0.6494, 0.6670)),
    (coat(0.4), lambert(0.8), (0.4503, 0.4471, 0.4332, 0.4193, 0.4000)),
    (coat(0.4, distribution="beckmann"), lambert(0.8), (0.5606, 0.5598, 0.5556, 0.5716, 0.6071)),
    (coat(0.3), conductor(0.2, 3.9, 0.05), (0.7935, 0.7407, 0.5761, 0.4904, 0.4448)),
    (coat(0.0), conductor(0.2, 3.9, 0.3), (0.6980, 0.6750, 0.6385, 0.6869, 0.8342)),
    (
        coat(0.2, distribution="beckmann"),
        conductor(0.2, 3.9, 0.3, "beckmann"),
        (0.8497, 0.8192, 0.7601, 0.7269, 0.7403),
    ),
)


@pytest.mark.parametrize("layer, base, expected", SLABS)
def test_single_agrees_with_path_traced_slabs(layer, base, expected):
    model = PositionFree(stack(layer, base=base), surface="single", walks=30_000)
    albedo, stderr = model.albedo_stderr(view([0.0, 30.0, 60.0, 75.0, 85.0]))
    assert np.all(stderr < 0.004)
    within(albedo[:, 0], np.hypot(stderr[:, 0], 7e-4), np.array(expected))


def f_integral_and_albedo(model_stack, surface, n=20_000):
    """Means and their standard errors, mirror-like components left out of both."""
    wo, rng = view(50.0, 0.4), np.random.default_rng(3)
    f = np.pi * PositionFree(model_stack, walks=2, surface=surface).f_stderr(wo, uniform_projected(n, rng), rng=rng)[0]
    by_depth, stderr = PositionFree(model_stack, walks=n, surface=surface).albedo_by_depth(wo)
    smooth_top = model_stack.layers[0]["roughness"] == 0.0
    kept = slice(1, None) if smooth_top else slice(None)
    return f.mean(axis=0), f.std(axis=0) / n**0.5, by_depth[kept].sum(axis=0), np.linalg.norm(stderr[kept], axis=0)


@pytest.mark.parametrize("surface", SURFACES)
@pytest.mark.parametrize("name", MIXED)
def test_f_integrates_to_the_albedo(name, surface):
    integral, error, albedo, albedo_error = f_integral_and_albedo(MIXED[name], surface)
    assert np.all(error < 0.04 * integral)
    within(integral, np.hypot(error, albedo_error), albedo)


@pytest.mark.parametrize("fault", ("refraction jacobian", "index of the light's medium"))
def test_faults_of_f_are_caught(fault, monkeypatch):
    name = "rough on lambert" if fault == "refraction jacobian" else "smooth on lambert"
    if fault == "refraction jacobian":
        monkeypatch.setattr(microsurface, "refraction_jacobian", lambda eta, length2: np.ones_like(length2))
    else:
        monkeypatch.setattr(position_free, "Surfaces", _with_equal_indices)
    integral, error, albedo, albedo_error = f_integral_and_albedo(MIXED[name], "single")
    assert np.all(np.abs(integral - albedo) > 8.0 * np.hypot(error, albedo_error))


def _with_equal_indices(*arguments):
    surfaces = Surfaces(*arguments)
    surfaces.n_above = [1.0] * len(surfaces)
    return surfaces


@pytest.mark.parametrize("surface", SURFACES)
@pytest.mark.parametrize("name", MIXED)
def test_connections_are_reciprocal(name, surface):
    surfaces, n, rng = Surfaces(OpticalStack.of(MIXED[name]), surface), 20_000, np.random.default_rng(6)
    a, b = np.tile(view(20.0), (n, 1)), np.tile(view(60.0, 2.5), (n, 1))
    there, back = connected_f(surfaces, a, b, rng), connected_f(surfaces, b, a, rng)
    error = np.hypot(there.std(axis=0), back.std(axis=0)) / n**0.5
    within(there.mean(axis=0), error, back.mean(axis=0))
    assert np.all(error < 0.05 * there.mean(axis=0))


def test_f_agrees_with_the_histogram_of_walks_down_to_grazing_light():
    model_stack = MIXED["rough on rough metal"]
    theta, phi = np.radians([0.0, 40.0, 80.0, 89.0]), np.linspace(-np.pi, np.pi, 3)
    wo, n, rng = view(30.0, 0.5), 10_000, np.random.default_rng(7)
    histogram = PositionFree(model_stack, walks=80_000).histogram(wo, theta, phi)
    expected, stderr = histogram.f()
    for row, (low, high) in enumerate(zip(theta[:-1], theta[1:])):
        sin2 = rng.uniform(np.sin(low) ** 2, np.sin(high) ** 2, n)
        wi = spherical(np.arcsin(np.sqrt(sin2)), 0.5 + rng.uniform(0.0, np.pi, n))
        f = PositionFree(model_stack, walks=2).f_stderr(wo, wi, rng=rng)[0][:, 0]
        within(f.mean(), np.hypot(f.std() / n**0.5, stderr[row, 1, 0]), expected[row, 1, 0])


def test_histogram_holds_the_albedo():
    model = PositionFree(MIXED["rough, rough, metal"], walks=20_000)
    edges = np.linspace(0.0, np.pi / 2, 7), np.linspace(0.0, 2.0 * np.pi, 9)
    whole = model.histogram(view(50.0), *edges)
    assert whole.energy.sum(axis=(0, 1)) == pytest.approx(model.albedo_by_depth(view(50.0))[0].sum(axis=0))
    parts = [model.histogram(view(50.0), *edges, deepest=i).energy for i in range(3)]
    assert sum(parts) == pytest.approx(whole.energy)
    # the mirror direction, half a turn from the viewer, is the brightest
    assert np.argmax(whole.energy[..., 0].sum(axis=0)) in (3, 4)


@pytest.mark.parametrize("surface", SURFACES)
@pytest.mark.parametrize("alpha", (0.0, 0.3))
def test_a_reflection_that_is_split_off_says_the_same_with_less_noise(surface, alpha):
    """Over a dark base most of the noise was whether a walk is one of the few that the top turns back."""
    model = PositionFree(stack(coat(alpha), coat(0.2, ior=1.3), base=lambert(0.05)), surface=surface, walks=20_000)
    by_depth, _ = model.albedo_by_depth(view(60.0))
    at_top = by_depth[0, 0]
    albedo, stderr = model.albedo_stderr(view(60.0))
    by_chance = np.sqrt(at_top * (1.0 - at_top) / 20_000)
    within(albedo, np.hypot(stderr, by_chance), by_depth.sum(axis=0))
    assert np.all(stderr < 0.7 * by_chance)


def test_equal_indices_vanish():
    bare = np.array([0.8, 0.5, 0.2])
    model = PositionFree(stack(coat(0.5, ior=1.0), base={"kind": "lambert", "color": bare.tolist()}), walks=1000)
    wo = view([0.0, 80.0])
    assert model.albedo(wo) == pytest.approx(np.tile(bare, (2, 1)), rel=1e-9)
    assert model.f(wo, view(30.0)) == pytest.approx(np.tile(bare / np.pi, (2, 1)), rel=1e-9)


@pytest.mark.parametrize("surface", SURFACES)
def test_hard_stacks_stay_finite(surface):
    stacks = (
        stack(coat(0.5, ior=2.4), coat(0.3, ior=1.0), base=lambert(1.0)),
        stack(coat(0.2, tint=[1.0, 0.0, 0.5], thickness=1000.0), base=lambert(1.0)),
        stack(*(coat(0.04 * (i % 4), ior=1.0 + 0.1 * (i % 5)) for i in range(20)), base=conductor(0.2, 3.9, 0.0)),
        stack(coat(2e-5), base=conductor(0.2, 3.9, 1.0)),
    )
    wo = view([0.0, 85.0, 89.9, 90.0 - 1e-6])
    for hard in stacks:
        model = PositionFree(hard, surface=surface, walks=60)
        albedo, stderr = model.albedo_stderr(wo)
        within(albedo, stderr, np.clip(albedo, 0.0, 1.0))
        f, stderr = model.f_stderr(wo[:, None], view([0.0, 85.0, 90.0 - 1e-6], 2.0))
        assert np.all(np.isfinite(f)) and np.all(f >= 0.0) and np.all(np.isfinite(stderr))


def test_nothing_below_the_horizon():
    model = PositionFree(MIXED["rough on lambert"], walks=100)
    assert np.all(model.albedo(view([90.5, 120.0])) == 0.0)
    f = model.f(view([30.0, 120.0]), view([120.0, 30.0]))
    assert f.shape == (2, 3) and np.all(f == 0.0)


def test_same_seed_same_result():
    def run(seed):
        model = PositionFree(MIXED["rough, rough, metal"], walks=500, seed=seed)
        return model.albedo(view([10.0, 50.0])), model.f(view(20.0), view(40.0, 1.0))

    for first, second, other in zip(run(1), run(1), run(2)):
        assert np.array_equal(first, second) and not np.array_equal(first, other)


def test_standard_error_is_that_of_the_mean():
    model = PositionFree(MIXED["rough on rough metal"], walks=400)
    wo, rng = np.tile(view(30.0), (200, 1)), np.random.default_rng(0)
    for value, stderr in (model.albedo_stderr(wo, rng=rng), model.f_stderr(wo, view(45.0, 2.0), rng=rng)):
        # 200 repeats give the spread to 5 %
        assert np.sqrt(np.mean(np.square(stderr[:, 0]))) == pytest.approx(value[:, 0].std(), rel=0.2)


def test_memory_does_not_grow_with_the_walks(monkeypatch):
    sizes = []

    class Counting(position_free.Walk):
        def __init__(self, surfaces, wo, *arguments, **options):
            sizes.append(len(wo))
            super().__init__(surfaces, wo, *arguments, **options)

    monkeypatch.setattr(position_free, "Walk", Counting)
    walks = 3 * position_free.BATCH + 7
    PositionFree(MIXED["smooth on lambert"], walks=walks).albedo(view(0.0))
    assert sum(sizes) == walks and max(sizes) == position_free.BATCH


def test_progress_and_cancel():
    model, shares = PositionFree(MIXED["smooth on lambert"], walks=2 * position_free.BATCH), []
    model.albedo_stderr(view(0.0), progress=shares.append)
    assert shares == [0.5, 1.0]
    calls = []
    with pytest.raises(Cancelled):
        model.f_stderr(view(0.0), view(10.0), progress=calls.append, cancel=lambda: len(calls) == 1)
    assert calls == [0.5]


@pytest.mark.parametrize(
    "options, message",
    (
        ({"surfaces": "single"}, "unknown option 'surfaces'; choose surface, walks, seed"),
        ({"surface": "double"}, "unknown surface 'double'; choose multiple, single"),
        ({"walks": 1}, "walks is 1; choose a whole number from 2"),
        ({"walks": "many"}, "walks is 'many'; choose a whole number from 2"),
        ({"seed": -1}, "seed is -1; choose a whole number from 0"),
    ),
)
def test_bad_options_name_the_choices(options, message):
    with pytest.raises(LaminaError, match=message):
        make_model("position_free", MIXED["rough on lambert"], **options)
