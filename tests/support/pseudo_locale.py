# SPDX-License-Identifier: GPL-3.0-or-later
"""A language that no code can know: every string that is offered for translation comes back in brackets. What is shown without them is hard-wired.

The wheel's Blender has no languages, so this takes the place of the functions that Lamina's modules translate with.
"""

import re
import sys

import pytest

from . import translatable
from .layouts import Recorder

OPEN, CLOSE = "\N{MATHEMATICAL LEFT WHITE SQUARE BRACKET}", "\N{MATHEMATICAL RIGHT WHITE SQUARE BRACKET}"
FUNCTIONS = ("iface_", "rpt_", "tip_", "data_")


class Language:
    """The brackets around what is there to be translated."""

    def __init__(self):
        self.strings = translatable.strings()

    def translated(self, text: str, _context: str = "*") -> str:
        return f"{OPEN}{text}{CLOSE}" if text in self.strings else text

    def use(self, patch: pytest.MonkeyPatch) -> None:
        """Let all of Lamina translate into it."""
        for name, module in list(sys.modules.items()):
            if name.startswith("lamina.addon."):
                for function in set(FUNCTIONS) & set(vars(module)):
                    patch.setattr(module, function, self.translated)


def left_over(text: str, names: set[str]) -> str:
    """The words of a text that are neither in brackets nor names, paths or numbers; empty where there are none."""
    inside = re.compile(f"{OPEN}[^{OPEN}{CLOSE}]*{CLOSE}")
    while inside.search(text):
        text = inside.sub(" ", text)
    for name in sorted(names, key=len, reverse=True):
        text = text.replace(name, " ")
    return " ".join(re.findall(r"[^\W\d_]{2,}", re.sub(r"\S*/\S*", " ", text)))


class Translated(Recorder):
    """A layout that shows texts as Blender would in that language: of layouts, what is not `translate=False`."""

    def __init__(self, language: Language, is_row: bool = False):
        super().__init__(is_row)
        self.language = language

    def _inner(self, is_row: bool):
        inner = Translated(self.language, is_row)
        inner.operators, inner.icons = self.operators, self.icons
        self.parts.append(inner)
        return inner

    def _shown(self, text: str, translate: bool = True) -> str:
        return self.language.translated(text) if translate else text

    def label(self, text="", translate=True, **options):
        super().label(self._shown(text, translate), **options)

    def progress(self, text="", **options):
        super().progress(text, **options)  # Blender shows it as it is given

    def operator(self, name, text="", translate=True, **options):
        return super().operator(name, self._shown(text, translate), **options)

    def prop(self, owner, name, text="", translate=True, **options):
        super().prop(owner, name, self._shown(text, translate), **options)

    def menu(self, name, text="", translate=True, **options):
        super().menu(name, self._shown(text, translate), **options)

    def popover(self, name, text="", translate=True, **options):
        super().popover(name, self._shown(text, translate), **options)

    def operator_menu_enum(self, name, prop, text="", translate=True, **options):
        super().operator_menu_enum(name, prop, self._shown(text, translate), **options)

    def template_node_view(self, tree, node, socket):
        self._note("socket", socket.name, texts=lambda: [self._shown(socket.name)])
