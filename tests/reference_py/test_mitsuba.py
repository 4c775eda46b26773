# SPDX-License-Identifier: GPL-3.0-or-later
"""Mitsuba 3 renders what is exported within its noise of the truth: tables, and stacks as explicit slabs. `make mitsuba` installs it."""

import numpy as np
import pytest
from support.stacks import coat, conductor, lambert, stack

from lamina.reference_py.exchange.writers import mitsuba as scenes
from lamina.reference_py.exchange.writers import rgl
from lamina.reference_py.exchange.writers.truth import Truth
from lamina.reference_py.fit.readers.measurement import spread_pairs
from lamina.reference_py.fit.readers.rgl import Material
from lamina.reference_py.optics.frame import rotate_z, spherical
from lamina.reference_py.registry import make_model
from lamina.study.mitsuba_slabs import mitsuba_albedo
from lamina.study.suite import scattering_suite

SATIN = stack(coat(0.3, tint=[0.9, 0.7, 0.5], thickness=0.5), base=lambert(0.5))
BRUSHED = {**conductor(0.2, 3.0, 0.3), "anisotropy": 0.9, "rotation": 0.05}


@pytest.fixture(scope="module")
def mi():
    found = pytest.importorskip("mitsuba", reason="needs Mitsuba: make mitsuba")
    found.set_variant("scalar_rgb")
    return found


@pytest.fixture(scope="module")
def satin(tmp_path_factory):
    """A table of the satin stack."""
    path = tmp_path_factory.mktemp("mitsuba") / "satin.bsdf"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rgl, "ISOTROPIC", rgl.Sampling(1, 12, (33, 128), 25))
        rgl.write(rgl.fields(Truth(SATIN, 2), "satin"), path)
    return path


def surface(mi, wi):
    found = mi.SurfaceInteraction3f()
    found.wi = mi.Vector3f(*wi)
    return found


@pytest.fixture(scope="module")
def brushed(tmp_path_factory):
    """A table of a brushed metal, of few walks: what is read back matters here, and not how true it is."""
    path = tmp_path_factory.mktemp("mitsuba") / "brushed.bsdf"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rgl, "ANISOTROPIC", rgl.Sampling(9, 4, (33, 32), 10))
        rgl.write(rgl.fields(Truth(stack(base=BRUSHED), 4), "brushed"), path)
    return path


@pytest.mark.parametrize("name", ["satin", "brushed"])
def test_mitsuba_reads_a_table_as_our_reader_does(mi, name, request):
    path = request.getfixturevalue(name)
    material, plugin = Material.load(path), mi.load_dict({"type": "measured", "filename": str(path)})
    rng = np.random.default_rng(3)
    wi, wo = spread_pairs(200, rng)
    turn = 2.0 * np.pi * rng.random(200)
    wi, wo = rotate_z(wi, turn), rotate_z(wo, turn)
    found = np.array([plugin.eval(mi.BSDFContext(), surface(mi, i), mi.Vector3f(*o)) for i, o in zip(wi, wo)])
    # Mitsuba computes in single precision, and walks leave steep steps between nodes
    assert found == pytest.approx(material.f(wi, wo) * wo[:, 2:], rel=1e-3 if name == "brushed" else 1e-4, abs=1e-7)


@pytest.mark.parametrize("theta_deg", [10.0, 60.0])
def test_samples_of_a_table_have_the_truths_albedo(mi, satin, theta_deg):
    """Mitsuba's own sampling by `vndf` and `luminance`: its weights are f cos over the density."""
    plugin, wi = mi.load_dict({"type": "measured", "filename": str(satin)}), spherical(np.radians(theta_deg), 0.3)
    rng = np.random.default_rng(4)
    drawn = [plugin.sample(mi.BSDFContext(), surface(mi, wi), *u)[1] for u in ((u[0], mi.Point2f(u[1], u[2])) for u in rng.random((4000, 3)).tolist())]
    weights = np.array(drawn)
    exact = make_model("adding", SATIN).albedo(wi)
    stderr = weights.std(axis=0) / np.sqrt(len(weights))
    assert np.all(np.abs(weights.mean(axis=0) - exact) < 4.0 * stderr + 0.005 * exact)
    assert np.all(stderr < 0.01 * exact), "samples that do not follow f are noisy"


def test_the_scene_of_a_table_is_the_sphere_in_the_sun(mi, satin):
    scene = mi.load_file(str(_beside(satin, scenes.measured_scene("satin", satin.name))), size="33", spp="4")
    picture = np.array(mi.render(scene))
    middle = picture[16, 16]  # seen along the normal, the sun of irradiance pi at 45 degrees
    wi = spherical(np.radians(scenes.SUN_THETA_DEG), 0.0)
    exact = np.pi * make_model("adding", SATIN).f(np.array([0.0, 0.0, 1.0]), wi) * wi[2]
    assert middle == pytest.approx(exact, rel=0.05)
    assert picture[16, 30].mean() > 2.0 * picture[16, 2].mean(), "the sun stands on the side of +x"


def _beside(table, text):
    path = table.with_suffix(".xml")
    path.write_text(text, encoding="utf-8")
    return path


SLABS = {
    "tinted coat": SATIN,
    "two media that scatter": scattering_suite()["two_media"],
    "smooth metal": stack(coat(0.2, tint=[0.5, 0.7, 0.9], thickness=1.0), base=conductor(0.2, 3.0, 0.0)),
    "air gap": stack(coat(0.2), coat(0.3, ior=1.0, distribution="beckmann"), base=lambert(0.7)),
    "brushed": stack(coat(0.1, anisotropy=0.8, rotation=0.2), base=BRUSHED),
}


@pytest.mark.parametrize("name", SLABS)
def test_slabs_are_single(mi, name):
    """At four standard errors, of a fixed seed; slabs of the wrong absorption or roughness are beyond."""
    layers = SLABS[name]
    found, stderr = mitsuba_albedo(mi, layers, 50.0, 8, most_rounds=6)
    wo = spherical(np.radians(50.0), 0.0)
    exact, own = (
        make_model("position_free", layers, surface="single").albedo_stderr(wo)
        if name == "brushed"
        else (make_model("adding", layers, surface="single").albedo(wo), 0.0)
    )
    assert np.all(stderr < 0.006 * exact)
    assert np.all(np.abs(found - exact) < 4.0 * np.hypot(stderr, own) + 1e-3 * exact)
