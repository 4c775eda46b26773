# SPDX-License-Identifier: GPL-3.0-or-later
"""What a user wants of new materials, by the extension's preferences. Only the window's buttons ask: commands and batches have options of their own."""

import bpy

from ...reference_py.errors import LaminaError
from ...reference_py.material.qualities import DEFAULT_METHOD
from .backend import DEFAULT_BACKEND, branches_here


def own_preferences() -> bpy.types.AddonPreferences | None:
    """The extension's preferences; None where Lamina is no extension of this Blender."""
    addon = bpy.context.preferences.addons.get(__package__.rsplit(".", 2)[0])
    return addon.preferences if addon is not None else None


def for_new(material: bpy.types.Material) -> tuple[str, str]:
    """Quality and backend that a material gets with a new stack; one that is layered already keeps its backend.

    Raises LaminaError where this Blender has not what the preferences say.
    """
    given = own_preferences()
    tier, backend = (given.tier, given.backend) if given is not None else (DEFAULT_METHOD, DEFAULT_BACKEND)
    if material.lamina.is_layered:
        return tier, material.lamina.backend
    try:
        branches_here(backend)
    except LaminaError as error:
        raise LaminaError("Lamina's preferences: {reason}", reason=error) from None
    return tier, backend
