# SPDX-License-Identifier: GPL-3.0-or-later
"""Groups of an older version get the ranges of this one's sliders when their file is opened."""

import bpy
from bpy.app.handlers import persistent

from ..material import kind_groups


@persistent
def update_after_load(*_) -> None:
    """No value changes, and a file without Lamina's materials is left alone."""
    if any(material.lamina.is_layered for material in bpy.data.materials):
        kind_groups.update_groups()


def handlers() -> list[tuple]:
    """(list of Blender's handlers, ours) for `registration`."""
    return [(bpy.app.handlers.load_post, update_after_load)]
