# SPDX-License-Identifier: GPL-3.0-or-later
"""No string that an artist reads is hard-wired: all of it comes back in the brackets of a language that no code knows."""

import json
from types import SimpleNamespace

import pytest

bpy = pytest.importorskip("bpy")

from support.layouts import Recorder
from support.pseudo_locale import CLOSE, OPEN, Language, Translated, left_over
from support.stacks import on_a_plane

from lamina.addon.blender.translation import CONTEXT, rpt_
from lamina.addon.check import check
from lamina.addon.jobs import bakes, fitting, saving
from lamina.addon.jobs.process import Process, worker
from lamina.addon.material import material as materials
from lamina.addon.material.elements import node_of
from lamina.addon.operators import exchange_operators, mask_link_operators, mask_operators, preset_operators
from lamina.addon.ui import panel, panel_feedback, panel_layers, preferences
from lamina.reference_py.errors import LaminaError, Sentence
from lamina.reference_py.exchange import conversion_process
from lamina.reference_py.fit import fit_process, outcome
from lamina.reference_py.fit.parameters import Parameters, Structure
from lamina.reference_py.lobes.methods import bake_process
from lamina.reference_py.material import presets
from lamina.reference_py.material.schema import CHOICE, COLOR, FLOAT, SCHEMA, VECTOR
from lamina.reference_py.material.stack import Stack

pytestmark = pytest.mark.blender

STACK = Stack.from_dict(
    {
        "name": "Qqstack",
        "layers": [{"kind": "dielectric", "name": "Qqcoat", "coverage": 0.5}, {"kind": "oren_nayar", "name": "Qqpaint", "coverage": 0.5}],
        "base": {"kind": "conductor", "metal": "gold", "name": "Qqbase"},
    }
)
# Names of things and of what has the same name in every language.
NAMES = {"Lamina", "Qqstack", "Qqcoat", "Qqpaint", "Qqbase", "Qqown", "coated", "Principled", "GGX", "OSL", "MB", "MaterialX", "JSON", "Sphere"}
# What files call things.
KEYS = {"roughness", "none", "open_pbr_surface", "standard_surface", "gltf_pbr", "UsdPreviewSurface", "surface", "layers"}
NAMES |= {presets.label(name) for name in presets.names()} | {"px"}


@pytest.fixture
def language(monkeypatch, tmp_path):
    monkeypatch.setenv("LAMINA_PRESETS", str(tmp_path / "own"))
    found = Language()
    found.use(monkeypatch)
    return found


@pytest.fixture
def material(blender):
    return on_a_plane(blender, STACK)


def window():
    context = bpy.context
    shown = SimpleNamespace(system=SimpleNamespace(ui_scale=1.0), addons=context.preferences.addons)
    return SimpleNamespace(
        scene=context.scene, object=context.object, region=SimpleNamespace(width=600), preferences=shown, window_manager=context.window_manager
    )


def _values_out_of_range(material, _):
    node_of(material.lamina.base).inputs["Roughness"].default_value = 2.0
    node_of(material.lamina.layers[0]).mute = True


STATES = {
    "all is well": lambda *_: None,
    "no layers are selected": lambda material, _: setattr(material.lamina, "active_layer", 9),
    "a layer is alone": lambda material, _: setattr(material.lamina, "solo", material.lamina.layers[0].node),
    "values are out of range": _values_out_of_range,
    "a bake runs": lambda _, patch: patch.setattr(bakes, "bake_of", lambda _: SimpleNamespace(share=0.5)),
    "a fit runs": lambda _, patch: patch.setattr(fitting, "running", lambda: SimpleNamespace(share=0.5)),
    "a preset is saved": lambda _, patch: patch.setattr(saving, "running", lambda: SimpleNamespace(share=0.5)),
    "all features that a preview knows": lambda material, _: [setattr(e, f"use_{f}", True) for e in material.lamina.layers for f in ("coverage", "anisotropy", "thin_film", "normal")
                                         if hasattr(e, f"use_{f}")],
    "stock nodes": lambda material, _: setattr(material.lamina, "backend", "nodes"),
}  # fmt: skip


def unmarked(layout: Recorder) -> str:
    """Words of all that a layout shows; sentences are broken into lines."""
    return left_over(" ".join(layout.texts()), NAMES)


@pytest.mark.parametrize("state", STATES)
def test_the_panel_shows_nothing_that_is_not_translated(material, language, monkeypatch, state):
    STATES[state](material, monkeypatch)
    layout, popover = Translated(language), Translated(language)
    panel.LAMINA_PT_material.draw(SimpleNamespace(layout=layout, bl_label="Lamina"), window())
    panel_feedback.draw_findings(popover, window(), material)
    row = Translated(language, is_row=True)
    panel_layers.LAMINA_UL_layers.draw_item(None, window(), row, material.lamina, material.lamina.layers[0], 0, None, "active_layer", 0)
    assert unmarked(layout) == unmarked(popover) == unmarked(row) == ""
    assert len([text for text in layout.texts() if OPEN in text]) > 5


def test_check_names_values_as_the_panel_does(material, language):
    tree, coat, base = material.node_tree, node_of(material.lamina.layers[0]), node_of(material.lamina.base)
    base.inputs["Roughness"].default_value = 2.0
    for socket, source in ((coat.inputs["IOR"], "ShaderNodeTexImage"), (base.inputs["Reflectance"], "ShaderNodeTexChecker")):
        tree.links.new(tree.nodes.new(source).outputs["Color"], socket)
    about = [finding for finding in check.find(material, bpy.context.scene, bpy.context.preferences) if finding.label]
    assert {"out_of_range", "image_missing", "value_rests"} <= {finding.code for finding in about}
    assert [f.code for f in about if f"{OPEN}{f.label}{CLOSE}" not in f.text(rpt_)] == []
    base.inputs["Roughness"].default_value = 0.5  # of a value that is none nobody asks what stock nodes leave out
    found = {finding.code: finding.text(rpt_) for finding in check.find(material, bpy.context.scene, bpy.context.preferences)}
    assert f"{OPEN}IOR{CLOSE}" in found["texture_ignored"] and f"{OPEN}{OPEN}IOR{CLOSE} of Qqcoat{CLOSE}" in found["without_osl"]


def test_menus_and_dialogs_show_nothing_that_is_not_translated(material, language, tmp_path):
    (tmp_path / "own").mkdir()
    STACK.save(tmp_path / "own" / "qqown.json")
    material.lamina.layers[0].visible = False
    layout = Translated(language)
    menus = (
        panel.LAMINA_MT_presets,
        panel_layers.LAMINA_MT_add_layer,
        panel_layers.LAMINA_MT_specials,
        mask_link_operators.LAMINA_MT_mask,
        mask_operators.LAMINA_MT_add_mask,
        exchange_operators.LAMINA_MT_exchange,
        preset_operators.LAMINA_MT_remove_preset,
    )
    for menu in menus:
        menu.draw(SimpleNamespace(layout=layout), window())
    preset_operators.LAMINA_OT_save_preset.draw(SimpleNamespace(layout=layout, bl_rna=bpy.ops.lamina.save_preset.get_rna_type()), bpy.context)
    preferences.draw_preferences(layout, SimpleNamespace(bl_rna=preferences.LaminaPreferences.bl_rna))
    panel_feedback.draw_unlayered_status(layout, window(), None)
    assert unmarked(layout) == ""


@pytest.fixture
def refused(material, tmp_path):
    """A material whose shader does not follow its layers, from a file that was opened again."""
    covered, clear = ({"kind": "dielectric", "name": "Qqcoat"} | more for more in ({"coverage": 0.5}, {}))
    materials.apply_stack(material, Stack.from_dict({"layers": [covered] * 3 + [clear], "base": {"kind": "lambert", "name": "Qqbase"}}), "weidlich_wilkie")
    material.lamina.layers[3].use_coverage = True
    name = material.name
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "refused.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "refused.blend"))
    return bpy.data.materials[name]


def test_why_a_shader_does_not_follow_is_translated(refused, language):
    layout = Translated(language)
    panel_feedback.draw_findings(layout, window(), refused)
    assert f"{OPEN}clear layers{CLOSE} have a coverage" in " ".join(layout.texts())
    assert left_over(" ".join(layout.texts()), NAMES) == ""


OLDER = {
    "of an older version": lambda lamina: setattr(lamina, "packed_problem", ""),
    "that an older version changed": lambda lamina: setattr(lamina, "problem", "Qq {braces} 4 clear layers"),
    "of a file that somebody edited": lambda lamina: setattr(lamina, "packed_problem", '{"template": 3}'),
    "with a word that is missing": lambda lamina: setattr(lamina, "packed_problem", '{"template": "{count}", "words": {"other": 3}}'),
}


@pytest.mark.parametrize("what", OLDER)
def test_a_problem_without_its_words_is_shown_as_it_is(refused, language, what):
    OLDER[what](refused.lamina)
    layout = Translated(language)
    panel_feedback.draw_findings(layout, window(), refused)
    shown = " ".join(layout.texts())
    assert all(word in shown for word in refused.lamina.problem.split()) and "clear layers" in left_over(shown, NAMES)


REPORTS = {
    "check": lambda _: bpy.ops.lamina.check(),
    "preset": lambda _: bpy.ops.lamina.apply_preset(preset="satin_varnish"),
    "save": lambda _: bpy.ops.lamina.remove_preset(name="qqown"),
    "export": lambda folder: bpy.ops.lamina.export_stack(filepath=str(folder / "stack.json")),
    "base": lambda _: bpy.ops.lamina.set_base(kind="lambert"),
}


@pytest.mark.parametrize("what", REPORTS)
def test_reports_are_translated(material, language, tmp_path, capfd, what):
    (tmp_path / "own").mkdir()
    STACK.save(tmp_path / "own" / "qqown.json")
    material.lamina.layers[0].visible = False
    node_of(material.lamina.layers[0]).mute = True
    capfd.readouterr()
    REPORTS[what](tmp_path)
    said = [line.partition(": ")[2] for line in capfd.readouterr().out.splitlines() if line.startswith(("Info: ", "Warning: "))]
    assert [words for line in said if (words := left_over(line, NAMES))] == []


ERRORS = {
    "an operator's own": lambda _: bpy.ops.lamina.layer_move(direction="UP"),
    "of a value": lambda _: bpy.ops.lamina.export_stack(filepath="/no/such/folder/stack.json"),
    "with a sentence in it": lambda folder: bpy.ops.lamina.import_stack(filepath=str(folder / "wrong.json")),
    "of a file": lambda folder: bpy.ops.lamina.import_mtlx(filepath=str(folder / "wrong.mtlx")),
}


@pytest.mark.parametrize("what", ERRORS)
def test_errors_are_translated(material, language, tmp_path, what):
    (tmp_path / "wrong.json").write_text('{"layers": [{"kind": "dielectric", "roughness": 7.0}], "base": {"kind": "lambert"}}')
    (tmp_path / "wrong.mtlx").write_text('<materialx><nodegraph name="g"/></materialx>')
    with pytest.raises(RuntimeError) as error:
        ERRORS[what](tmp_path)
    assert OPEN in str(error.value)
    assert left_over(str(error.value).removeprefix("Error: "), NAMES | KEYS) == ""


@pytest.mark.parametrize(
    "parameter", {p.name: p for kind in (*SCHEMA.layers.values(), *SCHEMA.bases.values()) for p in kind.all_parameters}.values(), ids=lambda p: p.name
)
def test_what_a_parameter_takes_is_translated(language, parameter):
    """Numbers and choices alone are what they are; whatever else there is comes in brackets, with those of its unit inside."""
    with pytest.raises(LaminaError) as error:
        parameter.check([9e9] * 3 if parameter.type in (COLOR, VECTOR) else 9e9 if parameter.type == FLOAT else "qq", Sentence("layer {number}", number=1))
    for told in (parameter.allowed.told(rpt_), error.value.told(rpt_)):
        assert left_over(told, set(parameter.choices)) == ""
        if parameter.type != CHOICE:
            bounds = f"{OPEN}{parameter.minimum:g} to {parameter.maximum:g}"
            assert f"{bounds} {OPEN}{parameter.unit}{CLOSE}{CLOSE}" in told if parameter.unit else f"{bounds}{CLOSE}" in told


CONVERSIONS = {
    "to Principled": lambda _: bpy.ops.lamina.principled_copy(),
    "copies": lambda _: bpy.ops.lamina.principled_copies(),
    "export": lambda folder: bpy.ops.lamina.export_mtlx(filepath=str(folder / "out.mtlx")),
    "import": lambda folder: bpy.ops.lamina.import_mtlx(filepath=str(folder / "in.mtlx")),
    "import of all": lambda folder: bpy.ops.lamina.import_materials(filepath=str(folder / "in.mtlx")),
}
SURFACE = """<materialx version="1.39"><standard_surface name="qqsurface" type="surfaceshader">
<input name="base_color" type="color3" value="-0.2, 0.5, 1.4"/><input name="sheen" type="float" value="0.5"/><input name="metalness" type="float" value="0.3"/>
<input name="coat" type="float" value="0.5"/><input name="emission" type="float" value="0.1"/><input name="specular_color" type="color3" value="0.5, 0.6, 0.7"/>
<input name="diffuse_roughness" type="float" nodename="qqgone"/><input name="subsurface" type="float" value="0.3"/>
</standard_surface></materialx>"""


# What a report's lines are about has the name that its file or stack gives it.
PARAMETERS = {"layer", "kind", "ior", "tint", "coverage", "base color", "sigma_deg", "conductor", "qqsurface", "base"}
PARAMETERS |= {"base_color", "specular_color", "diffuse_roughness", "metalness", "coat", "sheen", "emission", "subsurface"}


@pytest.mark.parametrize("what", CONVERSIONS)
def test_the_report_of_a_conversion_is_translated(material, language, tmp_path, what):
    (tmp_path / "in.mtlx").write_text(SURFACE)
    CONVERSIONS[what](tmp_path)
    title, *lines = bpy.data.texts[exchange_operators.REPORT_TEXT].as_string().splitlines()
    assert lines
    assert sorted({word for line in lines for word in left_over(line, NAMES | KEYS | PARAMETERS).split()}) == []


WRONG = {"layers": [{"kind": "dielectric", "roughness": 7.0}], "base": {"kind": "lambert"}}
REQUESTS = {
    bake_process.MODULE: {"stack": WRONG, "method": "analytic", "live": [], "tolerance": 0.01, "folder": None},
    conversion_process.MODULE: {"stack": WRONG, "textured": False, "folder": None},
}


@pytest.mark.parametrize("module", REQUESTS)
def test_why_a_process_failed_is_translated(language, module):
    process = Process(Sentence("a bake"), worker(module), [json.dumps(REQUESTS[module])])
    process.wait()
    assert "roughness is 7" in process.error
    assert left_over(process.error.told(rpt_), KEYS) == ""


def test_why_a_measurement_cannot_be_fitted_is_translated(language, tmp_path):
    (tmp_path / "wrong.csv").write_text("theta_i,r,g\n1,2,3\n")
    process = Process(Sentence("a fit"), worker(fit_process.MODULE), [fit_process.request(str(tmp_path / "wrong.csv"), "auto", "auto", "adding")])
    process.wait()
    assert "missing column" in process.error
    assert left_over(process.error.told(rpt_), {"theta_i", "theta_o"}) == ""


def test_what_a_fit_found_is_translated(material, language, monkeypatch):
    hidden = Sentence(
        "{share:.0f} % of the values are off by more than a factor of two ({factor:.2g} in the median) but hardly count, as they are dim beside the highlight",
        share=9.0,
        factor=3.0,
    )
    fit = object.__new__(fitting.Fit)
    fit.target, fit.file, fit.is_object, fit.error = material.session_uid, "qqown.csv", False, ""
    fit.result = {"stack": STACK.to_dict(), "error": 0.1, "explains": False, "warnings": [hidden.packed()], "not_determined": ["a"]}
    fit.result |= {"parameters": ["a"], "found": [], "lines": []}
    monkeypatch.setattr(fitting, "_noted", lambda *_: "Qqown")
    said = fit.apply(bpy.context.scene)[0]
    assert "9 % of the values" in said and "do not determine" in said and left_over(said, NAMES | {"csv"}) == ""


def test_the_text_of_a_fit_is_translated(material, language, tmp_path):
    """Of a table with something to say: an angle's other name, negative and steep ones, and a value that is none."""
    rows = [(theta_i, theta_o, phi) for theta_i in (-10, 20, 40, 60, 70, 88) for theta_o in (5, 25, 45, 65) for phi in range(0, 180, 30)]
    table = ["theta_in,theta_o,phi_o,r,g,b", "50,50,50,nan,0.1,0.1", *(f"{theta_i},{theta_o},{phi},0.2,0.1,0.05" for theta_i, theta_o, phi in rows)]
    (tmp_path / "qqown.csv").write_text("\n".join(table))
    fit = fitting.Fit(material, str(tmp_path / "qqown.csv"), 0, "lambert", False)
    fit.wait()
    fit.apply(bpy.context.scene)
    file, *lines = bpy.data.texts[f"{OPEN}Fit of qqown.csv{CLOSE}"].as_string().splitlines()
    assert file == str(tmp_path / "qqown.csv")
    for said in ("RGB", "not finite", "steeper than", "near the mirror direction", "0 layers over lambert", "as many layers as asked for", "red", "the base"):
        assert any(f"{OPEN}{said}" in line for line in lines), said
    names = {"theta_in", "theta_i", "0 layers over lambert", "lambert", "adding", "color"}
    assert [words for line in lines if (words := left_over(line, names))] == []


def test_all_that_a_fit_may_say_of_its_values_is_translated(language):
    unsure = {"determined": False, "at_bound": True, "value": 1.0, "standard_error": 0.5}
    result = {"stack": STACK.to_dict(), "parameters": [unsure | {"name": name} for name in Parameters(Structure.of(1, "conductor"), 3).names]}
    result |= {"model": "adding", "error": 0.1, "pairs": 9, "shape_error": 0.2, "noise": 0.1, "misfit": 0.1, "error_by_region": {}, "fitted_pairs": 9}
    structures = [Structure.of(count, "lambert", cloudy=cloudy) for count, cloudy in ((0, False), (1, False), (2, False), (1, True), (2, True))]
    result |= {"tried": [{"structure": s.name, "parameters": 1, "error": 0.1} for s in structures], "reason": Sentence("as many layers as asked for")}
    lines = outcome.lines(result | {"not_determined": ["ior"]})
    names = NAMES | {"ggx", "adding", "lambert", "ior", "roughness", "tint", "reflectance", "edge_color"}
    assert [words for line in lines if (words := left_over(line.told(rpt_), names))] == []


def test_why_a_process_is_gone_is_translated(language):
    process = Process(Sentence("a bake"), worker("no_such_module"), [])
    process.wait()
    assert process.error == "its process ended with code 1" and left_over(process.error.told(rpt_), set()) == ""


def test_the_language_marks_what_it_knows_and_nothing_else(language):
    assert language.translated("Pick a Preset", CONTEXT) == f"{OPEN}Pick a Preset{CLOSE}" and language.translated("Hard-wired", CONTEXT) == "Hard-wired"
    assert language.translated("Pick a Preset") == "Pick a Preset"  # Blender's own would win
    assert left_over(f"{OPEN}Mean of {OPEN}Air{CLOSE}: 2{CLOSE} Hard-wired", {"wired"}) == "Hard"
    assert json.dumps(sorted(language.strings))
