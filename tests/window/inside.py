# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside the Blender that `window.py` starts: shows the Material tab, and tells what is there, again and again."""

import json
import os
from pathlib import Path

import bpy

_STATE = Path(os.environ["LAMINA_STATE"])
_count = 0
_quick = False
_copied = [0, ""]
_evaluated = 0

preferences = bpy.context.preferences
preferences.view.show_splash = False
preferences.view.show_tooltips = False
preferences.view.ui_scale = 1.0
for area in bpy.context.screen.areas:
    if area.type == "VIEW_3D":  # no 3D shaders to wait for
        area.type = "PROPERTIES"
cube = bpy.data.objects["Cube"]
bpy.context.view_layer.objects.active = cube
cube.data.materials.clear()


@bpy.app.handlers.persistent
def count(_scene, depsgraph) -> None:
    """Every time that Blender evaluates a material, a render in a window begins anew."""
    global _evaluated
    _evaluated += depsgraph.id_type_updated("MATERIAL")


bpy.app.handlers.depsgraph_update_post.append(count)


def biggest() -> bpy.types.Area:
    areas = [area for area in bpy.context.window_manager.windows[0].screen.areas if area.type == "PROPERTIES"]
    return max(areas, key=lambda area: area.width * area.height)


def show() -> None:
    biggest().spaces.active.context = "MATERIAL"
    bpy.app.timers.register(tell, first_interval=1.0)


def tell() -> float:
    global _count, _quick, _copied
    _count += 1
    manager = bpy.context.window_manager
    if manager.clipboard:  # emptied, so that a second copy of the same is seen
        _copied, manager.clipboard = [_count, manager.clipboard], ""
    window = bpy.context.window_manager.windows[0]
    region = next(region for region in biggest().regions if region.type == "WINDOW")
    material = bpy.data.objects["Cube"].active_material
    lamina = material.lamina if material is not None else None
    _quick = _quick and lamina is not None
    if lamina is not None and lamina.is_layered and not _quick:
        # a bake and its progress would move the buttons while the mouse is on its way
        _quick, lamina.tier = True, "analytic"
        with bpy.context.temp_override(window=window):
            bpy.ops.ed.undo_push(message="tier")
    elements = dict(zip([layer.name for layer in lamina.layers] + ["Base"], [*lamina.layers, lamina.base])) if lamina is not None else {}
    sockets = {f"{name} {socket.name}": socket for name, e in elements.items() if e.node for socket in material.node_tree.nodes[e.node].inputs}
    sources = {name: socket.links[0].from_node for name, socket in sockets.items() if socket.is_linked}
    browsers = [w for w in bpy.context.window_manager.windows if w != window and w.screen.areas[0].type == "FILE_BROWSER"]
    state = {
        "ready": biggest().spaces.active.context == "MATERIAL",
        "tick": _count,
        "panel": {"left": region.x, "right": region.x + region.width - 20, "top": window.height - region.y - region.height,
                  "bottom": window.height - region.y},
        "copied": _copied,
        "name": material.name if material is not None else "",
        "stack": lamina.stack_name if lamina is not None else "",
        "layers": [layer.name for layer in lamina.layers] if lamina is not None else [],
        "active": lamina.active_layer if lamina is not None else -1,
        "materials": [material.name for material in bpy.data.materials],
        "masked": [is_masked(material.node_tree.nodes[layer.node]) for layer in lamina.layers] if lamina is not None else [],
        "paths": {name: socket.path_from_id("default_value") for name, socket in sockets.items() if hasattr(socket, "default_value")},
        "linked": {name: node.bl_idname for name, node in sources.items()},
        "images": {name: [node.image.name, node.image.colorspace_settings.name] for name, node in sources.items() if getattr(node, "image", None)},
        "tint": [round(v, 3) for v in sockets["Tinted Glaze Tint"].default_value] if "Tinted Glaze Tint" in sockets else [],
        "browser": next(([b.x, window.height - b.y - b.height, b.x + b.width, window.height - b.y] for b in browsers), []),
        "evaluated": _evaluated,
        "findings": findings(material),
    }  # fmt: skip
    temporary = _STATE.with_suffix(".new")
    temporary.write_text(json.dumps(state), encoding="utf-8")
    os.replace(temporary, _STATE)
    return 0.1


def is_masked(node) -> bool:
    coverage = node.inputs.get("Coverage")
    return coverage is not None and coverage.is_linked


def findings(material) -> list[str]:
    """What Check finds, through the operators that the extension registered."""
    if material is None or not material.lamina.is_layered:
        return []
    import sys

    check = next(module for name, module in sys.modules.items() if name.endswith(".lamina.addon.check.check"))
    scene = bpy.context.window_manager.windows[0].scene
    return [finding.text() for finding in check.find(material, scene, bpy.context.preferences)]


bpy.app.timers.register(show, first_interval=1.0)
