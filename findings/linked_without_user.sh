#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# bpy 5.2.3 and 5.3.0: what is linked and not used yet cannot be overridden or made local in 5.3, and no error says so.
# Expected: libraries.load(link=True) links a material directly, as it was named, so override_create() and make_local() work at once.
# Seen: in 5.3.0 it counts as indirectly linked until something uses it: override_create() returns None, make_local() returns the linked
# material unchanged. A fake user or a user in the file mends it; copy() is local either way. Node groups, meshes, objects and
# collections behave alike. In 5.2.3 both work without a user.
# Output of 2026-11-28 (user: is_library_indirect, override made, made local):
#   Blender 5.2.3   no user: False True True      fake user: False True True     in a mesh: False True True
#   Blender 5.3.0   no user: True False False     fake user: False True True     in a mesh: False True True
#   the others with no user: like the material
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
cat >"$work/measure.py" <<'PYTHON'
from blender import *

library = str(FOLDER / "library.blend")
empty_file()
MADE = {
    "materials": lambda: material("one", "ShaderNodeEmission")[0], "node_groups": lambda: bpy.data.node_groups.new("one", "ShaderNodeTree"),
    "meshes": lambda: bpy.data.meshes.new("one"), "objects": lambda: bpy.data.objects.new("one", None),
    "collections": lambda: bpy.data.collections.new("one"),
}  # fmt: skip
for make in MADE.values():
    make().use_fake_user = True
with silent():
    bpy.ops.wm.save_as_mainfile(filepath=library)


def linked(kind, user):
    empty_file()
    with bpy.data.libraries.load(library, link=True) as (_, found):
        setattr(found, kind, ["one"])
    (one,) = getattr(found, kind)
    if user == "fake user":
        one.use_fake_user = True
    elif user == "in a mesh":
        plane(one)
    return one


CASES = [("materials", user) for user in ("no user", "fake user", "in a mesh")] + [(kind, "no user") for kind in list(MADE)[1:]]
for case in CASES:
    works = case[1] != "no user" or VERSION < (5, 3)
    found = (linked(*case).is_library_indirect, linked(*case).override_create() is not None, linked(*case).make_local().library is None)
    told(f"{', '.join(case)}: indirect, override made, made local", " ".join(map(str, found)), f"{not works} {works} {works}")
told("materials, no user: copy is local", linked("materials", "no user").copy().library is None, True)
done()
PYTHON
blenders 5.2.3 5.3.0
