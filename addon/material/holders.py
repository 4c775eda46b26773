# SPDX-License-Identifier: GPL-3.0-or-later
"""Which objects and materials can show a surface, and where an object's material goes."""

from collections.abc import Iterable
from difflib import get_close_matches

import bpy

from ...reference_py.errors import LaminaError

# Volumes and Grease Pencil objects have material slots too, and Cycles shows no surface of theirs.
_WITH_SURFACE = {"MESH", "CURVE", "SURFACE", "META", "FONT", "CURVES", "POINTCLOUD"}
_NEAREST = 5
ALL = "all"


def can_hold_material(item: bpy.types.Object | None) -> bool:
    """Whether an object takes a surface material."""
    return item is not None and item.type in _WITH_SURFACE and hasattr(item.data, "materials")


def holder_named(objects: Iterable[bpy.types.Object], name: str) -> bpy.types.Object:
    """The object of this name, the file's own before a library's. Raises LaminaError with the nearest names."""
    holders = [item for item in objects if can_hold_material(item)]
    found = sorted((item for item in holders if item.name == name), key=lambda item: item.library is not None)
    if found:
        return found[0]
    by_lower: dict[str, str] = {item.name.lower(): item.name for item in holders}
    nearest = [by_lower[lower] for lower in get_close_matches(name.lower(), sorted(by_lower), _NEAREST, 0.0)]
    if not nearest:
        raise LaminaError("no object {name!r} that takes a surface material; there is none", name=name)
    raise LaminaError("no object {name!r} that takes a surface material; the nearest are {choices}", name=name, choices=", ".join(nearest))


def slots_of(target: bpy.types.Object, wanted: str | None) -> list[int]:
    """Indices of an object's slots: the active one, "all", or the one of a material's name or a number from 0. Raises LaminaError.

    An object without slots gives the first, which it gets with its first material.
    """
    names = [slot.name for slot in target.material_slots]
    if wanted is None:
        return [target.active_material_index if names else 0]
    if wanted == ALL:
        return list(range(max(len(names), 1)))
    if wanted in names:
        return [names.index(wanted)]
    if wanted.isdecimal() and int(wanted) < max(len(names), 1):
        return [int(wanted)]
    choices = ", ".join(f"{i} ({name or 'empty'})" for i, name in enumerate(names)) or "0"
    raise LaminaError(
        "object {target} has no slot {wanted!r}; choose {every}, or one of {choices}", target=target.name, wanted=wanted, every=ALL, choices=choices
    )


def require_own(target: bpy.types.Object, alone: bool) -> None:
    """Raise LaminaError for an object that is a library's, or whose mesh is, unless the material is given to the object `alone`."""
    if target.library is not None:
        raise LaminaError(
            "object {target} is the library {library}'s, so it cannot be changed here; make it local, or make a library override of the object and its mesh",
            target=target.name,
            library=target.library.filepath,
        )
    if not target.data.is_editable and not alone:
        raise LaminaError(
            "the mesh {mesh} of object {target} is the library {library}'s; make it local or a library override, or give --object-level or --single-user",
            mesh=target.data.name,
            target=target.name,
            library=target.data.library.filepath,
        )


def sharing(target: bpy.types.Object) -> list[str]:
    """Names of other objects that show the same mesh."""
    return sorted(item.name for item in bpy.data.objects if item.data == target.data and item != target)


def give(target: bpy.types.Object, material: bpy.types.Material, slots: Iterable[int], object_level: bool = False) -> None:
    """Put a material into an object's slots: into the mesh's, so that all who share it show it, or into the object's own alone."""
    if not target.material_slots:
        if not target.data.is_editable:
            target.data = target.data.copy()
        target.data.materials.append(None if object_level else material)
    for index in slots:
        slot = target.material_slots[index]
        if object_level:
            slot.link = "OBJECT"
        slot.material = material
