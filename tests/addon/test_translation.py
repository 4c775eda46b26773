# SPDX-License-Identifier: GPL-3.0-or-later
"""Every string that Blender shows has a translation, and no translation is of a string that is gone."""

import ast
import string

import pytest

bpy = pytest.importorskip("bpy")

from support import translatable

from lamina.addon import registration
from lamina.addon.blender import translation

pytestmark = pytest.mark.blender


@pytest.mark.parametrize("locale", translation.locales())
def test_a_translation_is_complete(blender, locale):
    told, shown = translation.load(locale), translatable.strings()
    assert not shown - set(told), f"without a translation in {locale}.json"
    assert not set(told) - shown, f"in {locale}.json, but shown nowhere"


@pytest.mark.parametrize("locale", translation.locales())
def test_a_translation_keeps_what_is_filled_in(locale):
    for text, told in translation.load(locale).items():
        assert told.strip() and _fields(text) == _fields(told), text


def _fields(text: str) -> list[str]:
    return sorted(name for _, name, _, _ in string.Formatter().parse(text) if name)


def test_labels_and_names_are_in_a_context_of_lamina(blender):
    """In any other a text of Blender's own would win."""
    for cls in registration.CLASSES:
        if hasattr(cls, "bl_label"):
            assert cls.bl_translation_context == translation.CONTEXT
        assert {prop.identifier for prop in translatable.shown_properties(cls) if prop.translation_context != translation.CONTEXT} == set()
    operators = [cls.bl_idname.split(".") for cls in registration.CLASSES if issubclass(cls, bpy.types.Operator)]
    assert {getattr(getattr(bpy.ops, group), name).get_rna_type().translation_context for group, name in operators} == {translation.CONTEXT}


def test_errors_keep_their_template():
    """A text that is put together before it is an error's has no translation; so errors get a template, or another's words."""
    built = (ast.JoinedStr, ast.BinOp)
    found = [f"{path.name}:{call.lineno}" for path in translatable.telling() for _, call in translatable.told(path) if isinstance(call.args[0], built)]
    assert not found, "write LaminaError('... {name} ...', name=name)"


def test_lines_of_a_report_are_sentences(blender):
    """A text that is no sentence has no translation; how many there are is printed."""
    lines = list(translatable.reported())
    bare = (ast.JoinedStr, ast.BinOp, ast.Constant)
    found = [where for said, where in lines if any(isinstance(part, bare) for part in _ways(said))]
    assert not found, "write Loss(..., Sentence('... {name} ...', name=name))"
    templates = {n.args[0].value for said, _ in lines for n in _ways(said) if isinstance(n, ast.Call) and isinstance(n.args[0], ast.Constant)}
    templates &= translatable.strings()  # all but those that only join others
    for locale in translation.locales():
        print(f"{locale}: {len(templates & set(translation.load(locale)))} of {len(templates)} lines of a conversion's report")
    assert len(templates) > 80


def _ways(said: ast.expr) -> list[ast.expr]:
    return [*_ways(said.body), *_ways(said.orelse)] if isinstance(said, ast.IfExp) else [said]


def test_the_collector_sees_all_sources(blender):
    """One string of each sort: schema, choice, operator, its property, its choice, panel, check, ready layer."""
    found = translatable.strings()
    assert {
        "Metal whose measured color is used",
        "Oren-Nayar",
        "Add Layer",
        "Kind",
        "Toward the viewer",
        "Pick a Preset",
        "The shader node was deleted",
        "Clear Varnish",
        "{layer} is the top layer already",
        "{where}: {name} is {shown}; {allowed}",
        "{path}: cannot write into folder {folder}",
        "Mean slope {degrees}\N{DEGREE SIGN}",
    } <= found
