# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials of objects as files for other programs, one each, with pictures of what textures feed and the reports, if asked for.

The files are what `lamina convert IN.blend --object NAME` writes (`reference_py.exchange.targets`).
"""

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import bpy

from ...reference_py.atomic import output_folder, write_text
from ...reference_py.errors import LaminaError, Sentence, one_of
from ...reference_py.exchange.report import KEPT, LOST, noted
from ...reference_py.exchange.targets import LAYERS, TARGETS, convert_to, suffix_of, text_of
from ..blender.images import require_pictures, write_png
from ..material.principled_node import has_linked_color, linked_places
from ..material.reading import measured_stack
from .materialx_import import lost_textures
from .textures import CHANNELS, NORMALS, bake_studio, can_be_baked, corrected, stored


@dataclass(frozen=True)
class Wish:
    """What is written: a target's name, whether textures become pictures of `size` pixels beside it, and whether reports do."""

    target: str
    pictures: bool
    size: int
    reports: bool


def layered_materials(objects: Sequence[bpy.types.Object]) -> dict[bpy.types.Material, bpy.types.Object]:
    """The Lamina materials of objects, each with the first object that has it."""
    found: dict = {}
    for item in objects:
        for slot in item.material_slots:
            if slot.material is not None and slot.material.lamina.is_layered:
                found.setdefault(slot.material, item)
    return found


def export(objects: Sequence[bpy.types.Object], folder: str | os.PathLike, wish: Wish) -> Iterator[tuple[str, list[Sentence]]]:
    """Write them; yields of each material its name and what became of it. What cannot be converted is left out, and said.

    Raises LaminaError where there is no such material, no such target or no such folder.
    """
    one_of("export", "format", wish.target, TARGETS)
    chosen = layered_materials(objects)
    if not chosen:
        raise LaminaError("no selected object has a material with a Lamina stack; select one")
    if wish.pictures:
        require_pictures()
    place, taken = output_folder(folder), set()
    for material, item in chosen.items():
        stem = _free(bpy.path.clean_name(material.name), taken)
        try:
            yield material.name, _written(material, item, place, stem, wish)
        except LaminaError as error:
            yield material.name, [noted(LOST, Sentence("left out: {error}", error=error))]


def _free(stem: str, taken: set[str]) -> str:
    """The name, or with a number where another material's file has it; names that differ in case are one file to some systems."""
    number, name = 1, stem
    while name.lower() in taken:
        number += 1
        name = f"{stem}_{number}"
    taken.add(name.lower())
    return name


def _written(material: bpy.types.Material, item: bpy.types.Object, folder: Path, stem: str, wish: Wish) -> list[Sentence]:
    draws = wish.pictures and wish.target != LAYERS
    converted = convert_to(wish.target, measured_stack(material), textured=draws and has_linked_color(material))
    pictures: dict[str, Path] = {}
    lines = []
    if draws:
        linked = {socket: source for socket, _, _, source in linked_places(material, converted.owners) if socket in CHANNELS}
        if linked:
            can_be_baked(material, item)
            pictures = _drawn(material, item, folder, stem, linked, converted, wish.size)
        lines += [noted(KEPT, Sentence("{socket} texture: {file}", socket=socket, file=path.name)) for socket, path in pictures.items()]
    lost = lost_textures(material)
    if not pictures:
        lines += lost
    elif len(lost) > len(pictures):
        lines.append(noted(LOST, Sentence("{count} more textures: their means are written", count=len(lost) - len(pictures))))
    lines += converted.report.lines()
    write_text(folder / f"{stem}{suffix_of(wish.target)}", text_of(wish.target, converted, material.name, pictures))
    if wish.reports:
        write_text(folder / f"{stem}_report.txt", "\n".join(lines) + "\n")
    return lines


def _drawn(material, item, folder: Path, stem: str, linked: dict, converted, size: int) -> dict[str, Path]:
    """Pictures of what feeds Principled's sockets, over the object's UVs, and their files."""
    files = {}
    with bake_studio(material, item, size) as studio:
        pixels = {socket: corrected(studio.baked(source, socket in NORMALS), socket, converted.colors) for socket, source in linked.items()}
    for socket, values in pixels.items():
        files[socket] = folder / f"{stem}_{CHANNELS[socket]}.png"
        write_png(files[socket], stored(values, socket == "Base Color"))
    return files
