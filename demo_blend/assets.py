# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the asset library of the presets in addon/presets: materials, previews, catalogues. `make assets` runs it."""

from pathlib import Path

import bpy

from ..addon.blender.images import read_png
from ..addon.library.preset_catalogues import ASSETS, CATALOGUE_FILE, CATALOGUES, catalogue_id, catalogue_text, thumbnail_of
from ..addon.library.thumbnails import give_preview
from ..addon.session import blender, say
from ..reference_py.atomic import replacing, write_text
from .materials import preset_material


def build(output: Path, names: list[str] | None = None, settle: bool = True) -> None:
    """Write a .blend with all presets, or those of `names`, as material assets."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    made = [_asset(name, catalogue, settle) for catalogue, members in CATALOGUES.items() for name in members if names is None or name in names]
    with replacing(output) as temporary:
        # only the materials and what they use: no scene, no window
        bpy.data.libraries.write(str(temporary), set(made), path_remap="RELATIVE_ALL", compress=True)


def _asset(name: str, catalogue: str, settle: bool) -> bpy.types.Material:
    material = preset_material(name, settle)
    material.asset_mark()
    data = material.asset_data
    data.catalog_id, data.description, data.author = catalogue_id(catalogue), material.lamina.source, "Lamina contributors"
    data.tags.new("Lamina")
    give_preview(material, read_png(thumbnail_of(name))[0])
    return material


def main() -> None:
    with blender(say("assets")):
        build(ASSETS)
        write_text(CATALOGUE_FILE, catalogue_text())
    say("assets")(f"wrote {ASSETS} and {CATALOGUE_FILE}")


if __name__ == "__main__":
    main()
    import os

    os._exit(0)
