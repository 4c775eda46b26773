# SPDX-License-Identifier: GPL-3.0-or-later
"""The note of Blender's stamp of a render: names, errors and hashes of the Lamina materials in it. The scene's own settings are put back."""

import bpy
from bpy.app.handlers import persistent

from ...reference_py.errors import LaminaError
from ...reference_py.lobes.cache import stack_key
from ...reference_py.version import version
from ..blender.dependencies import shown_objects
from ..material import chosen, reading

LONGEST = 511  # bytes that a picture gets of a note, whatever more the scene's setting takes (4.5 to 5.2)
# The scene's settings while it renders, by its name: whether it has a note, and which.
_former: dict[str, tuple[bool, str]] = {}


def note_of(materials: list[bpy.types.Material], longest: int = LONGEST) -> str:
    """At most `longest` characters: for each material its name, the estimated error and a hash of its stack, whole ones, and how many more there are."""
    text = f"Lamina {version()}"
    for i, material in enumerate(materials):
        try:
            digest = stack_key(reading.stack_of(material))[:12]
        except LaminaError:
            digest = "of no valid stack"
        error = f"error {material.lamina.error:.2g} %" if material.lamina.error >= 0.0 else "error unknown"
        entry, left = f"; {material.name}: {material.lamina.tier}, {error}, {digest}", len(materials) - i - 1
        if len(f"{text}{entry}; and {left} more".encode()) > longest:
            return f"{text}; and {left + 1} more"
        text += entry
    return text


def _shown_materials(scene: bpy.types.Scene) -> list[bpy.types.Material]:
    """Lamina materials on objects of the scene and of the collections that it instances."""
    found = {slot.material for item in shown_objects(scene) for slot in item.material_slots if slot.material is not None and slot.material.lamina.is_layered}
    return sorted(found, key=lambda material: material.name_full)


def _is_wanted() -> bool:
    preferences = chosen.own_preferences()
    return preferences is None or preferences.stamps_note


@persistent
def write(scene, *_) -> None:
    """Where stamps are burned into the picture it is left as it is."""
    render = scene.render
    if render.use_stamp or scene.name_full in _former or not _is_wanted():
        return
    materials = _shown_materials(scene)
    if not materials:
        return
    own = f"{render.stamp_note_text}; " if render.use_stamp_note and render.stamp_note_text else ""
    note = own + note_of(materials, LONGEST - len(own.encode()))
    if len(note.encode()) > LONGEST:
        return  # the user's own fills it
    _former[scene.name_full] = render.use_stamp_note, render.stamp_note_text
    render.use_stamp_note, render.stamp_note_text = True, note


@persistent
def put_back(scene, *_) -> None:
    if scene.name_full in _former:
        scene.render.use_stamp_note, scene.render.stamp_note_text = _former.pop(scene.name_full)


def handlers() -> list[tuple]:
    """(list of Blender's handlers, ours) for `registration`."""
    lists = bpy.app.handlers
    return [(lists.render_init, write), (lists.render_complete, put_back), (lists.render_cancel, put_back)]
