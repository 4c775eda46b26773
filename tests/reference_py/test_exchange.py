# SPDX-License-Identifier: GPL-3.0-or-later
"""Conversions: energy is kept, what is within reach comes back, and nothing is lost without a word."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from lamina.addon.cli.main import run
from lamina.reference_py.errors import LaminaError
from lamina.reference_py.exchange.matching import color_map, mean, rendered_by, truth
from lamina.reference_py.exchange.materialx import from_mtlx, load_mtlx, to_mtlx
from lamina.reference_py.exchange.openpbr import DEFAULTS, from_openpbr, to_openpbr, to_surface
from lamina.reference_py.exchange.principled import effective_ior, from_principled, to_principled
from lamina.reference_py.exchange.report import LOST
from lamina.reference_py.exchange.surfaces import SURFACES
from lamina.reference_py.material import presets
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.models.baselines import PrincipledCoat
from lamina.reference_py.models.baselines.principled_film import FilmedPrincipled
from lamina.reference_py.optics.frame import spherical
from lamina.reference_py.optics.thin_film import Film
from lamina.reference_py.registry import make_model

PAINT = {"kind": "lambert", "color": [0.7, 0.3, 0.05]}
METAL = {"kind": "conductor", "reflectance": [0.8, 0.6, 0.4], "edge_color": [0.9, 0.85, 0.8], "roughness": 0.4}
CLEAR = {"kind": "dielectric", "ior": 1.5}
TINTED = {"kind": "dielectric", "ior": 1.4, "tint": [0.9, 0.7, 0.5], "thickness": 0.8}
TO = {"principled": to_principled, "openpbr": to_openpbr}
BACK = {"principled": from_principled, "openpbr": from_openpbr}


def stack(base, *layers):
    return Stack.from_dict({"layers": list(layers), "base": base})


REACHED = {
    "paint": stack(PAINT),
    "chalk": stack({"kind": "oren_nayar", "color": [0.7, 0.3, 0.05], "sigma_deg": 25.0}),
    "plastic": stack(PAINT, CLEAR),
    "tinted coat": stack(PAINT, TINTED),
    "partly coated": stack(PAINT, {**CLEAR, "coverage": 0.4}),
    "two interfaces": stack({**PAINT, "color": [0.7, 0.3, 0.2]}, {**TINTED, "ior": 1.3}, {**CLEAR, "ior": 1.6}),
    "metal": stack(METAL),
}


@pytest.mark.parametrize("target", TO)
@pytest.mark.parametrize("name", REACHED)
def test_what_is_within_reach_comes_back(name, target):
    """Round trip: roughness and index exactly, base colors within .006."""
    original = REACHED[name]
    back = BACK[target](TO[target](original).values).stack
    assert [e.kind for e in back.layers] == [e.kind for e in original.layers] and back.base.kind == original.base.kind
    for old, new in zip(original.layers, back.layers):
        assert new["ior"] == pytest.approx(old["ior"]) and new["roughness"] == pytest.approx(old["roughness"])
        np.testing.assert_allclose(np.power(new["tint"], new["thickness"]), np.power(old["tint"], old["thickness"]), atol=1e-9)
        assert new.values.get("coverage", 1.0) == old.values.get("coverage", 1.0)
    key = "reflectance" if original.base.kind == "conductor" else "color"
    np.testing.assert_allclose(back.base[key], original.base[key], atol=0.006)
    if "sigma_deg" in original.base:
        assert back.base["sigma_deg"] == pytest.approx(original.base["sigma_deg"], abs=0.01)


@pytest.mark.parametrize("target, model", (("principled", "principled_coat"), ("openpbr", "openpbr_coat")))
def test_mean_albedo_is_the_truths(target, model):
    """And a plain mapping of the coat's color is far too bright in Principled, so the test can fail."""
    original = stack(PAINT, {**CLEAR, "tint": [0.9, 0.8, 0.7]})
    converted = TO[target](original)
    cosines, weights = np.polynomial.legendre.leggauss(12)
    cosines, weights = 0.5 * (cosines + 1.0), 0.5 * weights * (cosines + 1.0)
    wo = spherical(np.arccos(cosines), 0.0)
    exact = weights @ make_model("adding", original).albedo(wo)
    rendered = weights @ make_model(model, converted.slots.image(True)).albedo(wo)
    np.testing.assert_allclose(rendered, exact, rtol=5e-3)
    if target == "principled":
        plain = weights @ make_model(model, original).albedo(wo)
        assert np.max(plain / exact) > 1.15
    match = converted.report.match
    np.testing.assert_allclose(match.mean, exact, rtol=5e-3)
    assert np.max(np.abs(match.mean_error)) < 2e-4 and 0.0 < match.worst < 0.2


def test_textures_go_through_the_map_that_single_colors_take():
    original = stack(PAINT, CLEAR)
    converted = to_principled(original, textured=True)
    np.testing.assert_allclose(converted.colors(np.array(PAINT["color"])), converted.values["Base Color"], atol=2e-4)
    exact, rendered = truth(original), rendered_by(PrincipledCoat, converted.slots)
    for color in (0.1, 0.5, 0.9):
        np.testing.assert_allclose(mean(rendered(converted.colors(np.full(3, color)))), mean(exact(np.full(3, color))), atol=2e-3)
    there, back = color_map(exact, rendered), color_map(rendered, exact)
    colors = np.linspace(0.1, 0.9, 5)[:, None] * np.ones(3)
    np.testing.assert_allclose(back(there(colors)), colors, atol=1e-9)


def test_the_report_names_every_parameter_and_what_was_lost():
    rough = {**CLEAR, "roughness": 0.3, "distribution": "beckmann", "coverage": 0.7}
    original = stack(METAL, {**CLEAR, "film_thickness": 300.0, "film_ior": 1.8, "normal": [0, 0, 0]}, {**rough, "ior": 1.7, "tint": [0.9, 0.5, 0.5]})
    report = to_principled(original).report
    named = {loss.parameter for loss in report.losses}
    for where, element in (("layer 0", original.layers[0]), ("layer 1", original.layers[1])):
        ggx = set() if element["distribution"] == "beckmann" and where == "layer 0" else {"distribution"}
        assert {f"{where} {p}" for p in element.values if p not in {"thickness"} | ggx} <= named
    lost = {loss.parameter for loss in report.of(LOST)}
    assert {"layer 0 film_thickness", "layer 1 ior", "layer 1 roughness", "layer 1 coverage"} <= lost
    assert any("worst albedo error" in line for line in report.lines())


def test_what_a_stack_cannot_have_is_lost_by_name():
    odd = {"Metallic": 0.3, "Subsurface Weight": 0.5, "Transmission Weight": 0.2, "Sheen Weight": 0.1, "Emission Strength": 2.0, "Alpha": 0.5}
    report = from_principled(odd).report
    assert {loss.parameter for loss in report.of(LOST)} == set(odd) - {"Subsurface Weight"}
    assert "Subsurface Weight" in {loss.parameter for loss in report.of("approximated")}
    assert not from_principled({}).report.of(LOST)
    lost = {loss.parameter for loss in from_openpbr({"fuzz_weight": 0.5, "transmission_weight": 1.0, "coat_darkening": 0.0}).report.of(LOST)}
    assert lost == {"fuzz_weight", "transmission_weight"}


WAX = {"Base Color": (0.8, 0.5, 0.2), "Subsurface Weight": 1.0, "Subsurface Scale": 0.02, "Subsurface Radius": (1.0, 1.0, 1.0), "Subsurface Anisotropy": 0.4}


@pytest.fixture(scope="module")
def wax():
    return from_principled(WAX)


def test_light_below_the_surface_comes_in_as_a_medium_with_its_error(wax):
    body = wax.stack.layers[0]
    assert body["density"] == pytest.approx(50.0) and body["scatter_g"] == pytest.approx(0.4)
    assert np.max(np.abs(wax.report.match.mean_error)) < 5e-4 and 0.0 < wax.report.match.soft_light < 0.04
    assert "medium without end" in str(next(loss for loss in wax.report.losses if loss.parameter == "Subsurface Weight"))
    # nothing of what is below is seen: its color could be any
    hidden = replace(wax.stack, base=wax.stack.base.with_values(color=(0.0, 0.0, 0.0)))
    albedo, alone = (make_model("adding", one).albedo(spherical(0.6, 0.0)) for one in (wax.stack, hidden))
    assert alone == pytest.approx(albedo, rel=5e-3)


def test_it_goes_out_as_light_below_the_surface_again(wax):
    for values, names in (
        (to_principled(wax.stack).values, ("Base Color", "Subsurface Weight", "Subsurface Scale", "Subsurface Anisotropy")),
        (to_openpbr(wax.stack).values, ("subsurface_color", "subsurface_weight", "subsurface_radius", "subsurface_scatter_anisotropy")),
        (to_surface(SURFACES["standard_surface"], wax.stack).values, ("subsurface_color", "subsurface", "subsurface_scale", "subsurface_anisotropy")),
    ):
        color, *others = (values[name] for name in names)
        np.testing.assert_allclose(color, WAX["Base Color"], atol=0.04)
        np.testing.assert_allclose(others, (1.0, 0.02, 0.4))
    assert from_openpbr(to_openpbr(wax.stack).values).stack.layers[0]["density"] == pytest.approx(50.0)
    # what has no such light has the color alone, as bright
    plain = to_surface(SURFACES["gltf_pbr"], wax.stack)
    assert plain.values["base_color"][0] == pytest.approx(0.8, abs=0.04) and np.max(np.abs(plain.report.match.mean_error)) < 5e-4


def test_what_scatters_backward_is_said_to_be_lost(wax):
    backward = replace(wax.stack, layers=(wax.stack.layers[0].with_values(scatter_g=-0.5),))
    converted = to_principled(backward)
    assert converted.values["Subsurface Anisotropy"] == 0.0
    assert [str(loss) for loss in converted.report.of(LOST)] == [
        "lost: scatter_g -0.5: light below the surface of Principled is not scattered backward; its anisotropy is 0"
    ]
    assert to_openpbr(backward).values["subsurface_scatter_anisotropy"] == -0.5 and not to_openpbr(backward).report.of(LOST)
    assert not to_principled(wax.stack).report.of(LOST)


@pytest.mark.parametrize(
    ("value", "density"),
    [({"Subsurface Scale": 0.0}, 1000.0), ({"Subsurface Radius": (-1.0,) * 3}, 1000.0), ({"Subsurface Scale": 1e6}, 20.0)],
)
def test_a_path_below_the_surface_of_any_length_keeps_the_color(wax, value, density):
    """A medium is as dense as the schema allows at most, and lets nothing show through at least; the report says so."""
    converted = from_principled(WAX | {"Subsurface Anisotropy": 0.0} | value)
    assert converted.stack.layers[0]["density"] == density and np.max(np.abs(converted.report.match.mean_error)) < 5e-4
    assert f"of density {density:g}" in str(next(loss for loss in converted.report.losses if loss.parameter in value))


def test_a_haze_over_another_color_goes_out_as_a_base_color():
    haze = {"kind": "dielectric", "ior": 1.5, "roughness": 0.2, "scatter_color": [0.9] * 3, "density": 1.0}
    values = to_principled(stack(PAINT, haze)).values
    assert "Subsurface Weight" not in values and min(values["Base Color"]) > min(PAINT["color"])


def test_a_texture_or_a_film_leaves_a_diffuse_base(wax):
    for values, used in ((WAX, frozenset({"Base Color"})), (WAX | {"Anisotropic": 0.5}, frozenset()), (WAX | {"Diffuse Roughness": 0.5}, frozenset())):
        converted = from_principled(values, used=used)
        assert "density" not in converted.stack.layers[0]
        assert any("as a diffuse base of the color" in str(loss) for loss in converted.report.losses)


def test_what_is_no_number_is_refused_and_what_is_out_of_range_is_said():
    with pytest.raises(LaminaError, match="Principled: Roughness is nan"):
        from_principled({"Roughness": float("nan")})
    with pytest.raises(LaminaError, match="OpenPBR: base_color is .* inf"):
        from_openpbr({"base_color": (0.0, 0.0, float("inf"))})
    report = from_principled({"IOR": 10.0, "Coat Weight": 1.0, "Coat IOR": 0.5}).report
    assert {"Coat IOR", "IOR"} <= {loss.parameter for loss in report.of("approximated")}


def test_a_base_that_is_not_seen_keeps_its_textures_color():
    hidden = stack(PAINT, {**CLEAR, "tint": [0.0, 0.5, 1.0], "thickness": 3.0})
    mapped = to_principled(hidden, textured=True).colors(np.full(3, 0.5))
    assert mapped[0] == 0.5 and np.all(np.isfinite(mapped))


def test_specular_level_is_an_index():
    assert effective_ior(1.5, 0.5) == 1.5 and effective_ior(1.5, 0.0) == 1.0
    assert effective_ior(1.5, 1.0) == pytest.approx((1 + 0.08**0.5) / (1 - 0.08**0.5))
    assert effective_ior(0.8, 1.0) < 0.8


@pytest.mark.parametrize("target, metre", (("principled", "Thin Film Thickness"), ("openpbr", "thin_film_thickness")))
def test_films_and_brushing_go_both_ways(target, metre):
    original = stack({**METAL, "anisotropy": 0.6, "film_thickness": 250.0, "film_ior": 2.0})
    values = TO[target](original).values
    assert values[metre] == pytest.approx(250.0 if target == "principled" else 0.25)
    back = BACK[target](values).stack.base
    for name in ("anisotropy", "film_thickness", "film_ior", "roughness"):
        assert back[name] == pytest.approx(original.base[name])


FILM = {"film_thickness": 52.0, "film_ior": 2.3}


@pytest.mark.parametrize("values", ({"exported": True}, {"metal_films": False}), ids=str)
def test_the_color_of_a_film_is_in_the_base_color_where_none_goes_out(values):
    """The error counts it too, and a film below or on a coat as well as that of a flake that is left out."""
    original = stack({"kind": "conductor", "metal": "titanium", "roughness": 0.3, **FILM})
    converted = to_principled(original, **values)
    assert "Thin Film Thickness" not in converted.values and not converted.report.match.without_film
    shown = mean(rendered_by(PrincipledCoat, converted.slots)(converted.slots.color))
    np.testing.assert_allclose(shown, mean(truth(original, {-1})()), atol=2e-4)
    assert np.max(mean(truth(original)()) / shown) > 3.0, "the metal alone is far brighter"
    told = {loss.parameter: str(loss) for loss in converted.report.losses}
    assert "in the base color, the same at all angles" in told["base film_thickness"] and told["base film_thickness"].startswith("approximated")
    assert 0.03 < converted.report.match.soft_light < 0.1


@pytest.mark.parametrize(
    ("original", "filmed"),
    (
        (stack(METAL, {**CLEAR, "film_thickness": 400.0, "film_ior": 2.2}), {0}),
        (stack(PAINT, {"kind": "conductor", "reflectance": [0.6] * 3, "edge_color": [0.9] * 3, "coverage": 0.3, **FILM}), {0}),
    ),
    ids=("on a coat", "of a flake that is left out"),
)
@pytest.mark.parametrize("target", TO)
def test_a_film_without_a_place_counts(original, filmed, target):
    match = TO[target](original).report.match
    np.testing.assert_allclose(match.mean, mean(truth(original, filmed)()))
    assert np.max(np.abs(match.mean - mean(truth(original)()))) > 0.01 and not match.without_film
    np.testing.assert_allclose(match.mean_error, 0.0, atol=2e-4)


@pytest.mark.parametrize("metal, thickness, ior", (("titanium", 52.0, 2.3), ("iron", 58.0, 2.5), ("iron", 420.0, 1.47)))
def test_under_a_film_of_principled_the_base_color_is_the_nearest(metal, thickness, ior):
    """Films make brighter metals darker and have two such colors: the error is under 4 %, of the metal's own color it was up to 13 %."""
    original = stack({"kind": "conductor", "metal": metal, "roughness": 0.3, "film_thickness": thickness, "film_ior": ior})
    converted = to_principled(original)
    match, film = converted.report.match, Film(thickness, ior)
    assert converted.values["Thin Film Thickness"] == thickness and match.soft_light < 0.04 and not match.without_film
    shown = rendered_by(partial(FilmedPrincipled, film=film), converted.slots)
    exact = truth(original, {-1})()
    off = {
        name: np.sum(mean(np.abs(shown(color) - exact)))
        for name, color in (
            ("found", converted.slots.color),
            ("own", to_principled(stack(dict(original.base.values, kind="conductor", film_thickness=0.0))).slots.color),
        )
    }
    assert off["found"] / np.sum(mean(exact)) == pytest.approx(match.soft_light) and off["found"] <= 1.1 * off["own"]


def test_under_a_gloss_with_a_film_paint_has_the_truths_albedo():
    original = stack(PAINT, {**CLEAR, "film_thickness": 300.0, "film_ior": 2.0})
    converted = to_principled(original)
    assert converted.values["Thin Film Thickness"] == 300.0
    np.testing.assert_allclose(converted.report.match.mean_error, 0.0, atol=2e-4)
    np.testing.assert_allclose(converted.report.match.mean, mean(truth(original, {0})()))


def test_files_come_back_and_broken_ones_are_refused_in_one_line(tmp_path):
    values = to_openpbr(REACHED["tinted coat"]).values
    text = to_mtlx(values, "2 coats & <more>")
    (material,) = from_mtlx(text)
    assert not material.losses and material.name == "M_2_coats_more"
    for key, value in (DEFAULTS | values).items():
        np.testing.assert_allclose(material.values[key], value, rtol=1e-6)
    bomb = '<!DOCTYPE x [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]><materialx>&b;</materialx>'
    broken = {
        "truncated": (text[: len(text) // 2], "not valid XML"), "bomb": (bomb, "document type"), "empty": ("", "not valid XML"),
        "node": (text.replace("open_pbr_surface", "some_hair"), "it has some_hair"),
        "root": ("<svg/>", "its root is <svg>"), "nan": (text.replace('value="1.4"', 'value="nan"'), "coat_ior is 'nan'"),
        "word": (text.replace('value="1.4"', 'value="thick"'), "coat_ior is 'thick'"), "range": (text.replace('value="1.4"', 'value="-3"'), "0 to 100"),
        "deep": ("<a>" * 1000 + "</a>" * 1000, "nested too deeply"), "zero": ("<materialx>\0</materialx>", "not valid XML"),
    }  # fmt: skip
    for key, (content, words) in broken.items():
        file = tmp_path / f"{key}.mtlx"
        file.write_text(content)
        with pytest.raises(LaminaError) as error:
            load_mtlx(file)
        assert words in str(error.value) and "\n" not in str(error.value), key
    large = tmp_path / "large.mtlx"
    large.write_bytes(b" " * 5_000_000)
    with pytest.raises(LaminaError, match="too large"):
        load_mtlx(large)


def test_the_command_converts_there_and_back(tmp_path, capsys):
    file, again = tmp_path / "mug.mtlx", tmp_path / "mug.json"
    assert run(["convert", "glazed_mug", "--to", "openpbr", "-o", str(file)]) == 0
    assert "worst albedo error" in capsys.readouterr().out
    assert run(["convert", str(file), "-o", str(again)]) == 0
    np.testing.assert_allclose(Stack.load(again).base["color"], presets.load("glazed_mug").base["color"], atol=1e-3)
    file.write_text("<materialx")
    capsys.readouterr()
    for arguments in (
        ["convert", str(file), "-o", str(tmp_path / "no.json")],
        ["convert", "glazed_mug"],
        ["convert", str(file)],
        ["convert", "glazed_mug", "--to", "openpbr", "-o", str(tmp_path / "no.txt")],
    ):
        assert run(arguments) == 2
        assert capsys.readouterr().err.count("\n") == 1
    assert sorted(p.name for p in tmp_path.iterdir()) == ["mug.json", "mug.mtlx"]
