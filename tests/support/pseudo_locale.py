# SPDX-License-Identifier: GPL-3.0-or-later
"""A language that no code can know: every string that is offered for translation comes back in brackets. What is shown without them is hard-wired,
or asked for in a context that is not Lamina's, where a text of Blender's own would win.

The wheel's Blender has no languages, so this takes the place of the functions that it translates with.
"""

import re
from types import SimpleNamespace

import bpy
import pytest

from lamina.addon.blender import translation

from . import translatable
from .layouts import Recorder

OPEN, CLOSE = "\N{MATHEMATICAL LEFT WHITE SQUARE BRACKET}", "\N{MATHEMATICAL RIGHT WHITE SQUARE BRACKET}"
FUNCTIONS = ("pgettext_iface", "pgettext_rpt", "pgettext_tip", "pgettext_data")


class Language:
    """The brackets around what is there to be translated."""

    def __init__(self):
        self.strings = translatable.strings()

    def translated(self, text: str, context: str = "*") -> str:
        return f"{OPEN}{text}{CLOSE}" if text in self.strings and context == translation.CONTEXT else text

    def use(self, patch: pytest.MonkeyPatch) -> None:
        """Let all of Lamina translate into it."""
        patch.setattr(translation, "translations", SimpleNamespace(**dict.fromkeys(FUNCTIONS, self.translated)))


def left_over(text: str, names: set[str]) -> str:
    """The words of a text that are neither in brackets nor names, paths or numbers; empty where there are none."""
    inside = re.compile(f"{OPEN}[^{OPEN}{CLOSE}]*{CLOSE}")
    while inside.search(text):
        text = inside.sub(" ", text)
    for name in sorted(names, key=len, reverse=True):
        text = text.replace(name, " ")
    return " ".join(re.findall(r"[^\W\d_]{2,}", re.sub(r"\S*/\S*", " ", text)))


class Translated(Recorder):
    """A layout that shows texts as Blender would in that language: all but those with `translate=False`, in the context of `text_ctxt`, or else of the
    property or operator that is drawn."""

    def __init__(self, language: Language, is_row: bool = False):
        super().__init__(is_row)
        self.language = language

    def _inner(self, is_row: bool):
        inner = Translated(self.language, is_row)
        inner.operators, inner.icons = self.operators, self.icons
        self.parts.append(inner)
        return inner

    def label(self, text="", translate=True, text_ctxt="*", **options):
        super().label(self.language.translated(text, text_ctxt) if translate else text, **options)

    def progress(self, text="", **options):
        super().progress(text, **options)  # Blender shows it as it is given

    def operator(self, name, text=None, translate=True, text_ctxt="", **options):
        group, function = name.split(".")
        rna = getattr(getattr(bpy.ops, group), function).get_rna_type()
        return super().operator(name, self._of(rna, text, text_ctxt) if translate else text, **options)

    def prop(self, owner, name, text=None, text_ctxt="", **options):
        super().prop(owner, name, self._of(owner.bl_rna.properties[name], text, text_ctxt), **options)

    def menu(self, name, text=None, text_ctxt="*", **options):
        cls = getattr(bpy.types, name)
        super().menu(name, self.language.translated(*((cls.bl_label, cls.bl_translation_context) if text is None else (text, text_ctxt))), **options)

    def popover(self, name, text="", text_ctxt="*", **options):
        super().popover(name, self.language.translated(text, text_ctxt), **options)

    def operator_menu_enum(self, name, prop, text="", text_ctxt="*", **options):
        super().operator_menu_enum(name, prop, self.language.translated(text, text_ctxt), **options)

    def template_node_view(self, tree, node, socket):
        # A socket's name has no context.
        self._note("socket", socket.name, texts=lambda: [self.language.translated(socket.name, translation.CONTEXT)])

    def _of(self, rna, text: str | None, context: str) -> str:
        return self.language.translated(rna.name if text is None else text, context or rna.translation_context)
