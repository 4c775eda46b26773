# SPDX-License-Identifier: GPL-3.0-or-later
"""Every string that Blender shows has a translation, and no translation is of a string that is gone."""

import string

import pytest

pytest.importorskip("bpy")

from support import translatable

from lamina.addon.ui import translation

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
        "Mean slope {degrees}\N{DEGREE SIGN}",
    } <= found
