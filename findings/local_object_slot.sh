#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# bpy 4.5.15 and 5.2.3: the material of a local object with a linked mesh is read-only until its slot links to the object.
# Expected: the linked mesh owns the slot, so nothing in this file can give the object another material without an override or a copy.
# Seen: with slot.link "DATA" setting slot.material raises; slot.link = "OBJECT" is allowed, then it can be set, and the file keeps it.
# Output of 2026-11-29, both: set at first False, set after link = "OBJECT" True, material after loading "local"
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
cat >"$work/measure.py" <<'PYTHON'
from blender import *

library, path = str(FOLDER / "library.blend"), str(FOLDER / "user.blend")
empty_file()
plane(material("linked", "ShaderNodeEmission")[0])
with silent():
    bpy.ops.wm.save_as_mainfile(filepath=library)
empty_file()
with bpy.data.libraries.load(library, link=True) as (_, found):
    found.meshes = ["plane"]
shown = bpy.data.objects.new("shown", found.meshes[0])
bpy.context.scene.collection.objects.link(shown)
own = material("local", "ShaderNodeEmission")[0]


def set_material():
    try:
        shown.material_slots[0].material = own
    except (AttributeError, RuntimeError):
        pass
    return shown.material_slots[0].material == own


told("set at first", set_material(), False)
shown.material_slots[0].link = "OBJECT"
told('set after link = "OBJECT"', set_material(), True)
with silent():
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
told("material after loading", bpy.data.objects["shown"].material_slots[0].material.name, "local")
done()
PYTHON
blenders 4.5.15 5.2.3
