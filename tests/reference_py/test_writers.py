# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of the truth: read back they are the truth, as well as they say; what a format cannot hold is refused in one line."""

import json
import re
from xml.etree import ElementTree

import numpy as np
import pytest
from support.stacks import coat, conductor, lambert, stack

from lamina.addon.cli.main import run
from lamina.reference_py.errors import LaminaError
from lamina.reference_py.exchange.writers import csv_table, error, merl, mitsuba, pbrt, rgl
from lamina.reference_py.exchange.writers.truth import Truth
from lamina.reference_py.fit.readers.by_suffix import read
from lamina.reference_py.fit.readers.rgl import Material
from lamina.reference_py.optics.colour import reflectance_to_rgb
from lamina.reference_py.optics.frame import azimuth, spherical

SATIN = stack(coat(0.3, tint=[0.9, 0.7, 0.5], thickness=0.5), base=lambert(0.5))
BRUSHED = stack(base={**conductor(0.2, 3.0, 0.2), "anisotropy": 0.7, "rotation": 0.125})
COARSE = rgl.Sampling(1, 9, (17, 96), 25)


@pytest.fixture
def coarse(monkeypatch):
    """Tables of seconds instead of minutes."""
    monkeypatch.setattr(merl, "SIZES", (16, 16, 32))
    monkeypatch.setattr(rgl, "ISOTROPIC", COARSE)
    monkeypatch.setattr(error, "PAIRS", 400)


def test_merl_gives_back_the_truth(tmp_path, coarse):
    path, truth = tmp_path / "satin.binary", Truth(SATIN, 2)
    merl.write(merl.table(truth), path)
    measured = read(path)
    rows = np.random.default_rng(0).choice(len(measured.f), 200, replace=False)
    wi, wo = measured.wi[rows], measured.wo[rows]
    # both halves of the azimuths are there, and reflect alike
    assert measured.f[rows] == pytest.approx(truth.f(wo, wi), rel=1e-6)
    assert merl.reader(path)(wi, wo) == pytest.approx(measured.f[rows], rel=1e-12)


def test_rgl_gives_back_the_truth_as_well_as_it_says(tmp_path, coarse):
    path, truth = tmp_path / "satin.bsdf", Truth(SATIN, 2)
    rgl.write(rgl.fields(truth, "satin"), path)
    material = Material.load(path)
    said = error.of_table(truth, material.f)
    rng = np.random.default_rng(5)
    cos = rng.uniform(0.1, 1.0, (2, 500))
    wi, wo = spherical(np.arccos(cos), 2.0 * np.pi * rng.random((2, 500)))
    f = truth.f(wo, wi)
    off = np.abs(material.f(wi, wo) - f)
    # directions even in their cosines, not in half angles as those of `said`
    assert np.sum(off * cos[0, :, None] * cos[1, :, None]) / np.sum(f * cos[0, :, None] * cos[1, :, None]) == pytest.approx(said.mean, rel=0.5)
    assert 1e-3 < said.median < 0.02 and said.mean < 0.03
    wrong = error.of_table(truth, lambda wi, wo: 1.1 * material.f(wi, wo))
    assert wrong.median == pytest.approx(0.1, abs=0.01)


def test_rgl_holds_anisotropic_walks(tmp_path, monkeypatch, coarse):
    monkeypatch.setattr(rgl, "ANISOTROPIC", rgl.Sampling(9, 5, (65, 48), 20))
    path, truth = tmp_path / "brushed.bsdf", Truth(BRUSHED, 16)
    assert truth.name == "position_free"
    rgl.write(rgl.fields(truth, "brushed"), path)
    material = Material.load(path)
    assert not material.is_isotropic
    # the grain runs at 45 degrees: highlights differ along it and across
    view, angles = spherical(np.full(2, 0.5), 0.0), np.radians([45.0, 135.0])
    wm = spherical(np.full(2, 0.25), angles)
    wo = 2.0 * np.sum(view * wm, axis=1)[:, None] * wm - view
    along, across = material.f(view, wo)[:, 0]
    exact = Truth(BRUSHED, 4000).f(wo, view)[:, 0]
    assert along / across == pytest.approx(exact[0] / exact[1], rel=0.3) and not 0.5 < exact[0] / exact[1] < 2.0


def test_spectra_have_the_color_of_the_truth(tmp_path, monkeypatch, coarse):
    monkeypatch.setattr(rgl, "ISOTROPIC", rgl.Sampling(1, 3, (9, 32), 9))
    truth = Truth(SATIN, 2)
    spectra, rgb = (rgl.fields(truth, "satin", spectral=spectral) for spectral in (True, False))
    assert "rgb" not in spectra and np.all(spectra["spectra"] >= 0.0)
    again = reflectance_to_rgb(np.moveaxis(spectra["spectra"].astype(float), 2, -1), spectra["wavelengths"])
    assert again == pytest.approx(np.moveaxis(rgb["rgb"], 2, -1), rel=1e-4, abs=1e-6)


@pytest.mark.parametrize(("layers", "step"), [(SATIN, 5.0), (BRUSHED, 20.0)], ids=["isotropic", "anisotropic"])
def test_csv_gives_back_the_truth(tmp_path, layers, step):
    path, truth = tmp_path / "table.csv", Truth(layers, 64)
    csv_table.write(csv_table.text(truth, step), path)
    measured, interpolation = read(path), csv_table.Interpolation(path)
    # walks differ where one pair of directions has several rows
    once = (np.maximum(measured.wi[:, 2], measured.wo[:, 2]) < 0.999) & (azimuth(measured.wi) < np.pi - 1e-3) & (azimuth(measured.wi) > -1e-3)
    rows = np.random.default_rng(0).choice(np.flatnonzero(once), 300, replace=False)
    wi, wo = measured.wi[rows], measured.wo[rows]
    # at its own rows, to the digits of the text
    assert interpolation.f(wi, wo) == pytest.approx(np.broadcast_to(measured.f[rows], wi.shape), rel=1e-4, abs=1e-6)
    flip = np.array([-1.0, -1.0, 1.0])
    assert interpolation.f(wi * flip, wo * flip) == pytest.approx(np.broadcast_to(measured.f[rows], wi.shape), rel=1e-4, abs=1e-6)
    if layers is SATIN:
        assert measured.f[rows] == pytest.approx(truth.f(wo, wi), rel=1e-4)
        said = error.of_table(truth, interpolation.f)
        assert said.median < 0.02 and said.mean < 0.03


def pbrt_values(text):
    """Name, and values by key, of pbrt's syntax: a directive, then "type name" with a value or a list in brackets."""
    tokens = re.findall(r'"[^"]*"|\[|\]|[^\s"\[\]]+', text)
    assert tokens[0] == "MakeNamedMaterial"
    values, at = {}, 2
    while at < len(tokens):
        key, at = tokens[at].strip('"'), at + 1
        end = tokens.index("]", at) if tokens[at] == "[" else at
        values[key] = [word.strip('"') if word[0] == '"' else json.loads(word) for word in tokens[at : end + 1] if word not in "[]"]
        at = end + 1
    return tokens[1].strip('"'), values


def test_pbrts_layered_material_has_our_values():
    layers = stack(coat(0.09, tint=[0.5] * 3, thickness=2.0), base=conductor(0.3, 3.0, 0.25))
    _, values = pbrt_values(pbrt.layered_material(layers))
    assert values["string type"] == ["coatedconductor"] and values["bool remaproughness"] == [False]
    assert values["float interface.eta"] == [1.5] and values["float interface.roughness"] == pytest.approx([0.09])
    assert values["float thickness"] == pytest.approx([2.0 * np.log(2.0)]), "an optical depth"
    # of vacuum: pbrt divides by the interface's itself
    assert values["spectrum conductor.eta"] == pytest.approx([360.0, 0.3, 830.0, 0.3]) and values["float conductor.roughness"] == pytest.approx([0.25])
    milk = stack(coat(0.0, scatter_albedo=[0.9] * 3, extinction=[0.5] * 3, scatter_g=0.4, thickness=3.0), base=lambert(0.5))
    name, values = pbrt_values(pbrt.layered_material(milk))
    assert name == "surface" and values["string type"] == ["coateddiffuse"] and values["float eta"] == [1.5] and values["float g"] == [0.4]
    assert values["float thickness"] == pytest.approx([1.5]) and values["spectrum albedo"] == pytest.approx([360.0, 0.9, 830.0, 0.9])
    assert values["spectrum reflectance"] == [360.0, 0.5, 830.0, 0.5]
    assert pbrt_values(pbrt.layered_material(stack(base=lambert(0.25))))[1] == {"string type": ["diffuse"], "spectrum reflectance": [360.0, 0.25, 830.0, 0.25]}
    name, values = pbrt_values(pbrt.measured_material('a "fine" paint', "paint.bsdf"))
    assert name == "a 'fine' paint" and values == {"string type": ["measured"], "string filename": ["paint.bsdf"]}


def test_slabs_have_our_values():
    layers = stack(
        coat(0.09, tint=[0.5, 0.25, 1.0], thickness=2.0), coat(0.0, ior=1.2), base={**conductor(0.3, 3.0, 0.25), "anisotropy": 0.5, "rotation": 0.125}
    )
    root = ElementTree.fromstring(mitsuba.slab_scene(layers))
    planes = {shape.get("id"): shape for shape in root.findall("shape")}
    medium = root.find("medium")
    assert len(planes) == 3 and len(root.findall("medium")) == 1, "a medium that does nothing is none"
    depth = float(medium.find("float[@name='scale']").get("value")) * np.array(medium.find("rgb[@name='sigma_t']").get("value").split(","), float)
    assert depth == pytest.approx(2.0 * np.log([2.0, 4.0, 1.0]))
    assert planes["interface_0"].find("ref").get("name") == "interior" and planes["interface_1"].find("ref").get("name") == "exterior"
    inner = planes["interface_1"].find("bsdf")
    assert inner.get("type") == "dielectric" and [float(value.get("value")) for value in inner.findall("float")] == [1.2, 1.5]
    base = planes["base"]
    assert base.find("transform/rotate").get("angle") == "45.0"
    assert base.find("bsdf/rgb[@name='eta']").get("value").split(",")[0] == repr(0.3 / 1.2)


FILMED = stack(coat(0.1, film_thickness=300.0, film_ior=1.4), base=lambert(0.5))
COVERED = stack(coat(0.1, coverage=0.5), base=lambert(0.5))


@pytest.mark.parametrize(
    ("write", "layers", "words"),
    [
        (mitsuba.slab_scene, FILMED, "knows no thin_film"),
        (mitsuba.slab_scene, COVERED, "coverage"),
        (mitsuba.slab_scene, stack(coat(0.1), base={"kind": "oren_nayar", "color": [0.5] * 3, "sigma_deg": 30.0}), "rough diffuse"),
        (pbrt.layered_material, stack(coat(0.1), coat(0.2, ior=1.2), base=lambert(0.5)), "one layer, this stack has 2"),
        (pbrt.layered_material, stack(coat(0.1), base={"kind": "lambert", "color": [0.5, 0.4, 0.3]}), "greys alone, and the base's color"),
        (pbrt.layered_material, SATIN, "layer 0's medium is colored"),
        (pbrt.layered_material, stack(coat(0.1, distribution="beckmann"), base=lambert(0.5)), "distribution beckmann"),
        (pbrt.layered_material, stack(coat(0.0005), base=lambert(0.5)), "for a mirror"),
        (pbrt.layered_material, BRUSHED, "anisotropy"),
    ],
)
def test_what_layers_cannot_be_is_refused(write, layers, words):
    with pytest.raises(LaminaError, match=words) as told:
        write(layers)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize(
    ("refuse", "layers", "words"),
    [
        (merl.require_holdable, BRUSHED, "the base is anisotropic"),
        (merl.require_holdable, stack(coat(0.0), base=lambert(0.5)), "layer 0 is as smooth as a mirror"),
        (rgl.require_holdable, stack(coat(0.0, ior=1.0), coat(0.0), base=lambert(0.5)), "layer 1 is as smooth"),
        (rgl.require_holdable, stack(base=conductor(0.2, 3.0, 0.0)), "the base is as smooth"),
    ],
)
def test_what_a_table_cannot_hold_is_refused(refuse, layers, words):
    with pytest.raises(LaminaError, match=words) as told:
        refuse(layers)
    assert "\n" not in str(told.value)


def test_a_smooth_surface_under_a_rough_one_is_no_mirror():
    rgl.require_holdable(stack(coat(0.2), coat(0.0, ior=1.8), base=conductor(0.2, 3.0, 0.0)))


def test_the_command_states_the_error(tmp_path, coarse, capsys):
    file, out = tmp_path / "satin.json", tmp_path / "satin.bsdf"
    SATIN.save(file)
    assert run(["export", str(file), "--to", "rgl", "-o", str(out)]) == 0
    said = capsys.readouterr()
    assert "adding" in said.out and "read back at 400 random pairs" in said.out and "40 %" in said.err
    assert read(out).found[0].startswith("RGL material ")


def test_scenes_stand_beside_their_table(tmp_path, coarse, monkeypatch, capsys):
    monkeypatch.setattr(rgl, "ISOTROPIC", rgl.Sampling(1, 3, (9, 32), 9))
    SATIN.save(tmp_path / "satin.json")
    for to, suffix in (("mitsuba", ".xml"), ("pbrt", ".pbrt")):
        folder = tmp_path / to
        folder.mkdir()
        assert run(["export", str(tmp_path / "satin.json"), "--to", to, "-o", str(folder / f"x{suffix}")]) == 0
        assert sorted(path.name for path in folder.iterdir()) == sorted(["x.bsdf", f"x{suffix}"]) and '"x.bsdf"' in (folder / f"x{suffix}").read_text()
        assert (Material.load(folder / "x.bsdf").wavelength_nm is None) == (to == "mitsuba")
    assert run(["export", str(tmp_path / "satin.json"), "--to", "mitsuba", "--as", "layers", "-o", str(tmp_path / "slabs.xml")]) == 0
    assert "--surface single" in capsys.readouterr().out and not (tmp_path / "slabs.bsdf").exists()


def test_bad_arguments_are_refused_before_work(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("lamina.addon.cli.export.Truth", None)
    for arguments, words in (
        (["glazed_mug", "--to", "rgl", "-o", str(tmp_path / "x.bsdf")], "layer 0 is as smooth"),
        (["brushed_nickel", "--to", "merl", "-o", str(tmp_path / "x.binary")], "anisotropic"),
        (["satin_varnish", "--to", "merl", "-o", str(tmp_path / "x.bsdf")], ".binary"),
        (["satin_varnish", "--to", "merl", "-o", str(tmp_path / "no" / "x.binary")], "folder"),
        (["satin_varnish", "--to", "rgl", "--as", "layers", "-o", str(tmp_path / "x.bsdf")], "--as layers goes with --to mitsuba or pbrt"),
        (["satin_varnish", "--to", "rgl", "--step", "5", "-o", str(tmp_path / "x.bsdf")], "--step goes with --to csv"),
        (["satin_varnish", "--to", "mitsuba", "--as", "layers", "--surface", "multiple", "-o", str(tmp_path / "x.xml")], "--surface multiple"),
    ):
        assert run(["export", *arguments]) == 2
        line = capsys.readouterr().err
        assert line.count("\n") == 1 and words in line
    assert list(tmp_path.iterdir()) == []


def test_cancelling_leaves_nothing(tmp_path, coarse, monkeypatch):
    def cancelled(fields):
        raise KeyboardInterrupt

    monkeypatch.setattr(rgl, "tensor_bytes", cancelled)
    SATIN.save(tmp_path / "satin.json")
    assert run(["export", str(tmp_path / "satin.json"), "--to", "rgl", "-o", str(tmp_path / "x.bsdf")]) == 130
    assert [path.name for path in tmp_path.iterdir()] == ["satin.json"]
