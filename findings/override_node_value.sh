#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# bpy 4.5.15 and 5.3.0: a library override of a material takes a node's value, renders it, and loses it in the saved file.
# Expected: a value that an override accepts from Python either is an override and survives, or is refused as read-only.
# Seen: `default_value` of a node's socket is written without an error and renders, but `override_library.properties` never names it, and after
# save and load the library's value is back. A property of the material itself (viewport roughness) survives beside it.
# Output of 2026-11-28, both:
#   of the library: strength 0.25 roughness 0.25     written: 0.75 0.75, picture 0.75     loaded again: 0.25 0.75, picture 0.25
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
cat >"$work/measure.py" <<'PYTHON'
from blender import *

library, shot = str(FOLDER / "library.blend"), str(FOLDER / "shot.blend")


def strength(owner):
    return next(node for node in owner.node_tree.nodes if node.type == "EMISSION").inputs["Strength"]


empty_file()
owner, emission = material("glowing", "ShaderNodeEmission", Strength=0.25)
owner.roughness = 0.25
owner.use_fake_user = True
with silent():
    bpy.ops.wm.save_as_mainfile(filepath=library)
empty_file()
with bpy.data.libraries.load(library, link=True) as (_, found):
    found.materials = ["glowing"]
shown = plane(found.materials[0])
override = found.materials[0].override_create(remap_local_usages=True)
told("of the library: strength, roughness", (strength(override).default_value, override.roughness), (0.25, 0.25), 1e-6)
strength(override).default_value = override.roughness = 0.75
told("written: strength, roughness, picture", (strength(override).default_value, override.roughness, seen()[0]), (0.75, 0.75, 0.75), 1e-6)
with silent():
    bpy.ops.wm.save_as_mainfile(filepath=shot)
    bpy.ops.wm.open_mainfile(filepath=shot)
override = bpy.data.objects["plane"].data.materials[0]
told("loaded again: strength, roughness, picture", (strength(override).default_value, override.roughness, seen()[0]), (0.25, 0.75, 0.25), 1e-6)
told("overridden properties", " ".join(each.rna_path for each in override.override_library.properties), "roughness")
done()
PYTHON
blenders 4.5.15 5.3.0
