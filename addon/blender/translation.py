# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamina's strings in other languages: one JSON file per locale, English to that language, for Blender's translation.

Blender looks for a text in its own catalogue first, where "Layer" is something else than a layer of a coating. So all that
Lamina shows is asked for in a context of its own, which that catalogue does not know.
"""

import json
from pathlib import Path

from bpy.app import translations

FOLDER = Path(__file__).parents[1] / "translations"
CONTEXT = "Lamina"
_NAME = "lamina"
_ADDON = __package__.rpartition(".")[0]


def iface_(text: str) -> str:
    """A text of the interface in the user's language."""
    return translations.pgettext_iface(text, CONTEXT)


def tip_(text: str) -> str:
    """A tooltip in the user's language."""
    return translations.pgettext_tip(text, CONTEXT)


def rpt_(text: str) -> str:
    """A report in the user's language."""
    return translations.pgettext_rpt(text, CONTEXT)


def data_(text: str) -> str:
    """A name of new data in the user's language."""
    return translations.pgettext_data(text, CONTEXT)


def in_context(cls):
    """A class, before it is registered, whose label and properties' names Blender looks for in Lamina's context."""
    cls.bl_translation_context = CONTEXT
    for base in cls.__mro__:
        if base.__module__.startswith(_ADDON):
            for made in base.__annotations__.values():
                made.keywords["translation_context"] = CONTEXT
    return cls


def locales() -> list[str]:
    """The locales that there is a file for, such as "de_DE"."""
    return sorted(path.stem for path in FOLDER.glob("*.json"))


def load(locale: str) -> dict[str, str]:
    """The translations of a locale by their English text."""
    return json.loads((FOLDER / f"{locale}.json").read_text(encoding="utf-8"))


def register() -> None:
    # Descriptions and the names of sockets have no context: Blender looks for them in the default one, "*".
    tables = {locale: {(c, text): said for text, said in load(locale).items() for c in (CONTEXT, "*")} for locale in locales()}
    translations.register(_NAME, tables)


def unregister() -> None:
    translations.unregister(_NAME)
