# SPDX-License-Identifier: GPL-3.0-or-later
"""Property groups as plain data, to put them back when a change fails half-way."""

import bpy


def snapshot(group: bpy.types.PropertyGroup) -> dict:
    """All properties of a group by name, with nested groups as dictionaries and collections as lists of them."""
    data = {}
    for prop in _properties(group):
        value = getattr(group, prop.identifier)
        if prop.type == "COLLECTION":
            value = [snapshot(item) for item in value]
        elif prop.type == "POINTER":
            value = snapshot(value)
        elif getattr(prop, "is_array", False):
            value = list(value)
        data[prop.identifier] = value
    return data


def restore(group: bpy.types.PropertyGroup, data: dict) -> None:
    """Set a group to what `snapshot` returned, here or in another version: what that had not gets its default."""
    for prop in _properties(group):
        if prop.identifier not in data:
            group.property_unset(prop.identifier)
            continue
        value = data[prop.identifier]
        if prop.type == "COLLECTION":
            collection = getattr(group, prop.identifier)
            while len(collection) > len(value):  # those of a library override cannot grow, so none is made anew
                collection.remove(len(collection) - 1)
            while len(collection) < len(value):
                collection.add()
            for item, each in zip(collection, value):
                restore(item, each)
        elif prop.type == "POINTER":
            restore(getattr(group, prop.identifier), value)
        else:
            setattr(group, prop.identifier, value)


def _properties(group) -> list[bpy.types.Property]:
    return [prop for prop in group.bl_rna.properties if prop.identifier != "rna_type"]
