#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# bpy 4.5.15 and 5.3.0: Paste Material leaves the render settings and custom properties of the material behind.
# Expected: "Copy Material" and "Paste Material" give the second material all that the first one has.
# Seen: nodes, the node tree's custom properties, viewport color, roughness, pass index and culling come along. Displacement method, EEVEE's
# render method, Cycles' emission sampling and the material's custom properties stay those of the target, so displacement
# set to BOTH stays BUMP. An add-on that keeps its data in properties of the material ends with data that do not belong to the nodes.
# Output of 2026-11-28, both (source / target before / target after):
#   custom property of the node tree 1 2 1, node Roughness .1 .9 .1, pass_index 1 2 1, use_backface_culling True False True
#   custom property of the material 1 2 2, displacement_method BOTH BUMP BUMP, surface_render_method BLENDED DITHERED DITHERED,
#   cycles.emission_sampling NONE AUTO AUTO
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
cat >"$work/measure.py" <<'PYTHON'
from blender import *

empty_file()
owners = {}
for number, name, roughness in ((1, "source", 0.1), (2, "target", 0.9)):
    owner, node = material(name, "ShaderNodeBsdfPrincipled", Roughness=roughness)
    owner["of material"] = owner.node_tree["of tree"] = owner.pass_index = number
    owners[name] = owner
source, target = owners["source"], owners["target"]
source.use_backface_culling, source.displacement_method, source.surface_render_method = True, "BOTH", "BLENDED"
source.cycles.emission_sampling = "NONE"


def state(owner):
    node = next(node for node in owner.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    return {
        "of tree": owner.node_tree["of tree"], "Roughness": round(node.inputs["Roughness"].default_value, 6), "pass_index": owner.pass_index,
        "use_backface_culling": owner.use_backface_culling, "of material": owner["of material"], "displacement_method": owner.displacement_method,
        "surface_render_method": owner.surface_render_method, "emission_sampling": owner.cycles.emission_sampling,
    }  # fmt: skip


first, before = state(source), state(target)
shown = bpy.context.view_layer.objects.active = plane(source)
with silent():
    with bpy.context.temp_override(material=source, object=shown):
        bpy.ops.material.copy()
    with bpy.context.temp_override(material=target, object=shown):
        bpy.ops.material.paste()
after = state(target)
for number, name in enumerate(after):
    told(f"{name}: {first[name]}, {before[name]} ->", after[name], first[name] if number < 4 else before[name])
done()
PYTHON
blenders 4.5.15 5.3.0
