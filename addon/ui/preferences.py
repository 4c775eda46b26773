# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension's preferences."""

import time
from pathlib import Path

import bpy
from bpy.props import BoolProperty

from ...reference_py.lobes import cache
from ..blender.translation import CONTEXT, iface_
from ..blender.user_folders import cache_folder, presets_folder
from ..material.properties import backend_property, quality_property
from ..operators.folder_operators import LAMINA_OT_clear_cache

# The manual as `make docs` builds it and the extension ships it.
MANUAL = Path(__file__).resolve().parents[2] / "manual" / "index.html"
# Seconds for which the size of a folder is not looked up again; preferences are drawn at every move of the mouse.
_KNOWN_FOR = 5.0
_known: tuple[float, float] = (-_KNOWN_FOR, 0.0)


class LaminaPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__.rsplit(".", 2)[0]

    tier: quality_property()
    backend: backend_property()
    stamps_note: BoolProperty(
        name="Materials in the Stamp's Note",
        description="Write names, errors and hashes of the Lamina materials of a render into the metadata of its picture",
        default=True,
    )

    def draw(self, _context) -> None:
        draw_preferences(self.layout, self)


def draw_preferences(layout, owner) -> None:
    """The manual, what is kept on the disk, and settings."""
    row = layout.row()
    row.enabled = MANUAL.is_file()
    row.operator("wm.url_open", text="Documentation", text_ctxt=CONTEXT, icon="HELP").url = MANUAL.as_uri()
    row = layout.row()
    row.label(text=iface_("Final looks that are kept: {size} MB").format(size=f"{_cache_mb():.1f}"), translate=False)
    row.operator(LAMINA_OT_clear_cache.bl_idname)
    row = layout.row()
    folder = presets_folder()
    row.label(text=iface_("Own presets: {folder}").format(folder=folder), translate=False)
    row = row.row()
    row.enabled = folder.is_dir()
    row.operator("wm.path_open", text="", icon="FILE_FOLDER").filepath = str(folder)
    layout.label(text="New Materials", text_ctxt=CONTEXT)
    column = layout.column()
    column.use_property_split = True
    column.prop(owner, "tier")
    column.prop(owner, "backend")
    layout.prop(owner, "stamps_note")


def _cache_mb() -> float:
    global _known
    now = time.monotonic()
    if now - _known[0] >= _KNOWN_FOR:
        _known = now, cache.usage(cache_folder()).size / 1e6
    return _known[1]
