# SPDX-License-Identifier: GPL-3.0-or-later
import json

import numpy as np
import pytest

from lamina.addon.cli.main import BAD_INPUT, DONE, run
from lamina.reference_py.errors import LaminaError
from lamina.reference_py.material import presets
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.models.weidlich_wilkie import WeidlichWilkie
from lamina.reference_py.optics.colour import metal_index, reflectance_to_rgb, standard_wavelengths
from lamina.reference_py.optics.frame import spherical
from lamina.reference_py.optics.fresnel import fresnel_conductor
from lamina.reference_py.optics.spectral import gaussian_band, smoothest_reflectance, spectral_stack
from lamina.reference_py.registry import make_model
from lamina.study.paper import figure9, module
from lamina.study.paper.lights import Disc, Environment
from lamina.study.paper.sphere import radiance, render
from lamina.study.paper.varnish import BANDS, WAVELENGTH_NM, spectral_varnish
from lamina.study.stamp import stamp
from lamina.study.tables import read_heading, read_table

SIZE = 24
WO, WI = spherical(np.radians([10.0, 45.0, 70.0]), 0.0), spherical(np.radians([30.0, 20.0, 60.0]), 2.0)


def grey_stack():
    coat = {"kind": "dielectric", "ior": 1.5, "roughness": 0.5, "tint": [0.6] * 3, "thickness": 0.7}
    return Stack.from_dict({"layers": [coat], "base": {"kind": "oren_nayar", "color": [0.7] * 3}})


@pytest.mark.parametrize("count", (1, 5))
def test_grey_is_the_same_in_rgb_and_at_any_wavelength(count):
    rgb = WeidlichWilkie(grey_stack())
    spectral = WeidlichWilkie(spectral_stack(grey_stack(), np.linspace(400.0, 700.0, count)))
    assert spectral.f(WO, WI).shape == (3, count)
    assert spectral.f(WO, WI) == pytest.approx(np.repeat(rgb.f(WO, WI)[:, :1], count, axis=1), rel=1e-12)
    assert spectral.albedo(WO) == pytest.approx(np.repeat(rgb.albedo(WO)[:, :1], count, axis=1), rel=1e-12)


def test_metal_has_its_index_at_each_wavelength():
    smooth = Stack.from_dict({"base": {"kind": "conductor", "metal": "copper", "roughness": 0.0}})
    wavelength_nm = np.array([450.0, 550.0, 650.0, 700.0])
    expected = fresnel_conductor(np.array([1.0]), *metal_index("copper", wavelength_nm))
    albedo = WeidlichWilkie(spectral_stack(smooth, wavelength_nm)).albedo(np.array([0.0, 0.0, 1.0]))
    assert albedo == pytest.approx(expected, rel=1e-9)
    assert albedo[0] < 0.65 < 0.9 < albedo[2]


def test_bouguer_holds_for_each_wavelength_but_not_for_channels():
    none, one, two = (WeidlichWilkie(spectral_varnish(d)).components(WO, WI)[-1] for d in (0.0, 1.6, 3.2))
    assert two * none == pytest.approx(one**2, rel=1e-12)
    none, one, two = (reflectance_to_rgb(f, WAVELENGTH_NM)[..., 1] for f in (none, one, two))
    assert np.min(two * none / one**2) > 1.05


@pytest.mark.parametrize(
    "kwargs, message",
    (
        ({}, "coloured"),
        ({"tints": {0: [0.5, 0.5]}}, "needs one value for each of 3"),
        ({"tints": {0: [0.5, 0.5, 1.5]}}, "within 0 to 1"),
        ({"tints": {1: [0.5] * 3}}, "has 1 layers"),
    ),
)
def test_what_a_spectral_stack_lacks_is_named(kwargs, message):
    with pytest.raises(LaminaError, match=message):
        spectral_stack(presets.load("tinted_glaze"), [450.0, 550.0, 650.0], **kwargs)


def test_metal_takes_no_color():
    with pytest.raises(LaminaError, match="no color"):
        spectral_stack(presets.load("clean_copper"), [550.0], color=[0.5])


def test_smoothest_reflectance_has_its_colour():
    wavelength_nm = standard_wavelengths()
    spectrum = smoothest_reflectance([0.31, 0.4, 0.71], wavelength_nm)
    assert reflectance_to_rgb(spectrum, wavelength_nm) == pytest.approx([0.31, 0.4, 0.71], abs=1e-9)
    assert smoothest_reflectance([0.4] * 3, wavelength_nm) == pytest.approx(np.full(81, 0.4), abs=1e-9)
    with pytest.raises(LaminaError, match="too saturated"):
        smoothest_reflectance([1.0, 0.0, 0.0], wavelength_nm)


def test_gaussian_band_at_centre_and_one_deviation():
    assert gaussian_band([440.0, 480.0], 440.0, 40.0, 2.0) == pytest.approx([2.0, 2.0 * np.exp(-0.5)])


@pytest.mark.parametrize("name", ("glazed_mug", "frosted_paint", "metal_foil", "metallic_car_paint"))
def test_sphere_in_a_furnace_shows_the_albedo(name):
    model = make_model("weidlich_wilkie", presets.load(name))
    theta = np.radians([5.0, 40.0, 65.0])
    normals = spherical(theta, 0.7)
    light = radiance(model, normals, Environment(1.0, 0.0, (Disc((0.3, 0.2, 1.0), 12.0, 0.0),)), count=1024)
    assert light == pytest.approx(model.albedo(spherical(theta, 0.0)), rel=0.01)


def test_disc_lights_a_matte_surface_by_its_irradiance():
    white = WeidlichWilkie(Stack.from_dict({"base": {"kind": "lambert", "color": [1.0] * 3}}))
    disc = Disc((0.0, 0.6, 0.8), 10.0, 5.0)
    angle = np.radians(np.linspace(0.0, 10.0, 4001))
    profile = disc.radiance_from(np.stack([0.0 * angle, np.sin(angle + np.arcsin(0.6)), np.cos(angle + np.arcsin(0.6))], axis=-1))
    irradiance = 2.0 * np.pi * angle[-1] * np.mean(profile * np.cos(angle) * np.sin(angle))
    lit = radiance(white, np.array([[0.0, 0.6, 0.8], [0.0, -0.8, 0.6]]), Environment(0.0, 0.0, (disc,)), count=2048)
    assert lit[0] == pytest.approx(np.full(3, irradiance / np.pi), rel=0.01)
    assert lit[1] == pytest.approx(np.full(3, lit[1, 0])) and lit[1, 0] < 0.05 * lit[0, 0]


def test_sphere_fills_its_picture():
    picture = render(WeidlichWilkie(grey_stack()), 16)
    assert np.mean(picture.on_sphere) == pytest.approx(np.pi / 4.0, abs=0.05)
    assert np.all(picture.radiance[picture.on_sphere] > 0.0) and np.all(picture.radiance[~picture.on_sphere] == 0.0)


def test_figure3_absorption_changes_chroma_more_than_hue_and_most_at_grazing_angles():
    pytest.importorskip("colour")
    means = {row[:3]: row[3:] for row in module("figure3").compute(SIZE).rows}
    for varnish in BANDS:
        hue, chroma, lightness = (means[varnish, "same colour", f"abs_delta_{k}"] for k in "HCL")
        assert hue[-1] < 0.5 * chroma[-1]
        assert chroma[2] > 1.2 * chroma[0] and lightness[2] > 1.2 * lightness[0]


def test_figure3_sees_no_difference_without_a_varnish(monkeypatch):
    pytest.importorskip("colour")
    figure3 = module("figure3")
    monkeypatch.setattr(figure3, "THICKNESS", 1e-9)
    assert all(max(row[3:]) < 1e-4 for row in figure3.compute(SIZE).rows)


def test_figure5_thicker_varnish_is_darker_more_saturated_and_redder():
    pytest.importorskip("colour")
    table = np.array(module("figure5").compute(SIZE).rows)
    lightness, hue, saturation = table[:, 1], table[1:, 3], table[:, 4]
    assert np.all(np.diff(lightness) < 0.0) and np.all(np.diff(saturation) > 0.0) and np.all(np.diff(hue) < 0.0)
    assert saturation[0] < 1e-9


def test_rgb_absorption_is_wrong_more_the_thicker_the_varnish():
    pytest.importorskip("colour")
    error = np.array(module("spectral").compute(SIZE).rows)[:, -1]
    assert error[0] < 1e-9 and np.all(np.diff(error) > 0.0) and error[-1] > 10.0


def test_figure6_tinted_glaze_saturates_towards_grazing_angles_and_opaque_paint_does_not():
    pytest.importorskip("colour")
    through = {row[0]: np.array(row[4:]) for row in module("figure6").compute(SIZE).rows if row[2] == "through the varnish"}
    assert np.all(np.diff(through["b"]) > 0.0) and np.ptp(through["b"]) > 0.1
    assert np.ptp(through["a"]) < 1e-9


@pytest.mark.parametrize("name, fails", (("figure7", []), ("figure8", ["matte christmas orbs"])))
def test_sentences_that_do_not_hold_of_surface_types(name, fails):
    """The orbs: a rough coat does not widen the lobe below it when both directions refract about one half vector."""
    pytest.importorskip("colour")
    assert [s.sentence for s in module(name).compute(SIZE).statements if not s.holds] == fails


def test_figure9_depends_on_the_reading_of_the_lower_index():
    data = figure9.compute()
    error = {row[:2]: row[2] for row in data.rows}
    for angle in figure9.INCIDENT_DEG:
        assert error["n 1.3 and 1.69 (relative 1.3)", angle] < error["n 1.3 and 1.3 (absolute)", angle] < 0.4
    holds = {s.sentence[:20]: s.holds for s in data.statements}
    assert holds["[The topmost] layer "] and holds["To reproduce the ret"]
    assert not holds["The underlying layer"]


def test_command_writes_tables_and_prints_what_holds(tmp_path, capsys):
    assert run(["figures", "--out", str(tmp_path / "new"), "--only", "figure9"]) == DONE
    assert "holds: " in capsys.readouterr().out
    statements = json.loads((tmp_path / "new" / "figure9.json").read_text())["statements"]
    assert {s["holds"] for s in statements} == {True, False}
    heading, stamps = read_heading(tmp_path / "new" / "figure9.csv")
    assert heading == ["lamina figures"] and stamps == [stamp()]
    assert list(read_table(tmp_path / "new" / "figure9.csv")[0])[:2] == ["curve", "incident_deg"]


@pytest.mark.parametrize("arguments, message", ((["--only", "figure4"], "figure9"), (["--size", "3"], "choose 16 to 1024")))
def test_command_names_bad_input(tmp_path, capsys, arguments, message):
    assert run(["figures", "--out", str(tmp_path / "new"), *arguments]) == BAD_INPUT
    error = capsys.readouterr().err
    assert message in error and "Traceback" not in error and not (tmp_path / "new").exists()
