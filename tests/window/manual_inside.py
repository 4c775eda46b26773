# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside the Blender that `manual.py` starts: does the steps of the manual's first hour, and waits at each until its picture is taken."""

import contextlib
import importlib
import json
import os
import time
import traceback
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

_STATE = Path(os.environ["LAMINA_STATE"])
# CPU seconds that a view gets to render after the bakes are done, on a machine without a graphics card, and the seconds without work after which
# it has ended earlier.
_RENDERS, _RESTS = 80.0, 10.0
# The share of a core that a window without work takes at most.
_IDLE = 0.05


def lamina_module(name: str):
    """A module of the extension, under the name that Blender gave it."""
    return importlib.import_module(f"bl_ext.user_default.lamina.{name}")


def image(name: str, pixels: np.ndarray, is_data: bool) -> bpy.types.Image:
    """An image (h, w, 3) in the file."""
    high, wide, _ = pixels.shape
    made = bpy.data.images.new(name, wide, high, float_buffer=False, is_data=is_data)
    made.pixels.foreach_set(np.concatenate([pixels, np.ones((high, wide, 1))], axis=2).astype(np.float32).ravel())
    made.pack()
    return made


def wood(size: int = 512) -> np.ndarray:
    """Boards of a light wood, sRGB."""
    y, x = np.mgrid[0:size, 0:size] / size
    random = np.random.default_rng(3)
    board = np.floor(4.0 * y)
    shift = random.random(4)[board.astype(int)]
    rings = np.sin(60.0 * (y + 0.05 * np.sin(5.0 * (x + 3.0 * shift))) + 7.0 * shift) ** 2
    grain = 0.5 + 0.5 * np.sin(900.0 * y + 25.0 * np.sin(7.0 * x + 9.0 * shift))
    value = 0.62 + 0.2 * rings - 0.07 * grain - 0.1 * shift
    gap = np.abs(4.0 * y - np.round(4.0 * y)) < 0.012
    return np.where(gap[..., None], 0.15, value[..., None] * np.array([1.0, 0.74, 0.46])).clip(0.0, 1.0)


def smudges(size: int = 512) -> np.ndarray:
    """Where a varnish is worn, .2 to .55."""
    y, x = np.mgrid[0:size, 0:size] / size
    random = np.random.default_rng(5)
    value = np.full((size, size), 0.2)
    for u, v, r in zip(*random.random((2, 9)), 0.06 + 0.1 * random.random(9)):
        distance = np.hypot(x - u, y - v)
        value += 0.3 * np.exp(-(((distance - r) / 0.02) ** 2))
    return np.repeat(value.clip(0.0, 0.55)[..., None], 3, axis=2)


def stage() -> None:
    """A board, a ball on it, and light; the 3D view looks through the camera."""
    scene = bpy.context.scene
    for thing in list(scene.objects):
        if thing.type in ("MESH", "LIGHT"):
            bpy.data.objects.remove(thing)
    bpy.ops.mesh.primitive_cube_add(size=2.0)
    board = bpy.context.object
    board.name, board.scale = "Table", (1.7, 1.2, 0.06)
    for place, corner in zip(board.data.uv_layers.active.uv, board.data.loops):  # the picture lies on the top, boards along it
        x, y, _ = board.data.vertices[corner.vertex_index].co
        place.vector = 0.5 + 0.5 * x, 0.5 + 0.5 * y
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=0.55, location=(0.0, 0.0, 0.61))
    bpy.context.object.name = "Ball"
    bpy.ops.object.shade_smooth()
    for place, size, energy in (((-2.5, -1.5, 3.0), 2.0, 420.0), ((2.8, 0.6, 2.2), 1.0, 160.0)):
        bpy.ops.object.light_add(type="AREA", location=place)
        light = bpy.context.object
        light.data.size, light.data.energy = size, energy
        light.rotation_euler = Vector(-np.array(place)).to_track_quat("-Z", "Y").to_euler()
    camera = scene.camera
    camera.data.show_passepartout = False
    camera.location = (0.0, -3.9, 2.3)
    camera.rotation_euler = (np.radians(64.0), 0.0, 0.0)
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.35, 0.4, 0.5, 1.0)
    scene.render.engine, scene.cycles.preview_samples = "CYCLES", 48
    scene.cycles.use_preview_denoising = True
    for area in bpy.context.screen.areas:
        if area.type == "VIEW_3D":
            space = area.spaces.active
            space.region_3d.view_perspective = "CAMERA"
            space.region_3d.view_camera_zoom = 10.0
            space.shading.type = "RENDERED"
            space.overlay.show_overlays = space.show_gizmo = space.show_region_toolbar = False


def select(name: str) -> bpy.types.Object:
    chosen = bpy.data.objects[name]
    for other in bpy.context.scene.objects:
        other.select_set(other is chosen)
    bpy.context.view_layer.objects.active = chosen
    return chosen


def texture(element, label: str, picture: bpy.types.Image) -> None:
    """Link a picture to a value of a layer or base, as the dot beside it does."""
    node = lamina_module("addon.material.elements").node_of(element)
    tree = element.id_data.node_tree
    found = tree.nodes.new("ShaderNodeTexImage")
    found.image = picture
    found.location = node.location[0] - 400.0, node.location[1]
    tree.links.new(found.outputs["Color"], node.inputs[label])


def pick() -> None:
    select("Table")


def varnish() -> None:
    select("Table")
    bpy.ops.lamina.apply_preset(preset="satin_varnish")


def table() -> None:
    lamina = select("Table").active_material.lamina
    texture(lamina.base, "Color", image("boards.png", wood(), False))
    texture(lamina.layers[0], "Roughness", image("smudges.png", smudges(), True))


def rust() -> None:
    ball = select("Ball")
    bpy.ops.lamina.apply_preset(preset="glossy_plastic")
    bpy.ops.lamina.layer_add_ready(ready="rust")
    lamina = ball.active_material.lamina
    tree = ball.active_material.node_tree
    node = lamina_module("addon.material.elements").node_of(lamina.layers[0])
    noise, ramp = tree.nodes.new("ShaderNodeTexNoise"), tree.nodes.new("ShaderNodeValToRGB")
    noise.inputs["Scale"].default_value, noise.inputs["Detail"].default_value = 4.0, 8.0
    ramp.color_ramp.elements[0].position, ramp.color_ramp.elements[1].position = 0.5, 0.56
    tree.links.new(noise.outputs["Fac" if "Fac" in noise.outputs else 0], ramp.inputs[0])
    tree.links.new(ramp.outputs["Color"], node.inputs["Coverage"])


def car_paint() -> None:
    select("Ball")
    bpy.ops.lamina.apply_preset(preset="clear_coat_car_paint")


STEPS = {"pick": pick, "varnish": varnish, "table": table, "rust": rust, "car_paint": car_paint}
_left = list(STEPS)
# CPU time when the bakes were done, and the clock's and the CPU time when it last worked.
_begun, _looked = 0.0, (0.0, 0.0)
_now = ""


def tell(**state) -> None:
    temporary = _STATE.with_suffix(".new")
    temporary.write_text(json.dumps(state), encoding="utf-8")
    os.replace(temporary, _STATE)


def is_busy() -> bool:
    """Whether a final shader is still computed."""
    bake_of = lamina_module("addon.jobs.bakes").bake_of
    return any(bake_of(material) is not None for material in bpy.data.materials)


def show_material_tab() -> None:
    """An editor of properties has a tab from its first draw after an object was chosen on."""
    for area in bpy.context.window_manager.windows[0].screen.areas:
        if area.type == "PROPERTIES" and area.spaces.active.context != "MATERIAL":
            with contextlib.suppress(TypeError):
                area.spaces.active.context = "MATERIAL"


def turn() -> float:
    """Do the next step once the picture of the last is taken; say when a picture can be."""
    global _now, _begun, _looked
    try:
        show_material_tab()
        if _now and not _STATE.with_name(f"{_now}.taken").exists():
            if is_busy():
                _begun = time.process_time()
            if time.process_time() - _looked[1] > _IDLE * (time.monotonic() - _looked[0]) or is_busy():
                _looked = time.monotonic(), time.process_time()
            if time.process_time() - _begun > _RENDERS or time.monotonic() - _looked[0] > _RESTS:
                tell(shows=_now)
            return 0.5
        if not _left:
            tell(done=True)
            return 0.5
        _now, _begun, _looked = _left.pop(0), time.process_time(), (time.monotonic(), time.process_time())
        STEPS[_now]()
        bpy.ops.ed.undo_push(message=_now)
    except Exception:
        traceback.print_exc()
        tell(failed=_now)
        return 5.0
    return 0.5


def begin() -> None:
    try:
        with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
            stage()
    except Exception:
        traceback.print_exc()
        tell(failed="stage")
    else:
        bpy.app.timers.register(turn, first_interval=1.0)


bpy.context.preferences.view.show_splash = False
bpy.app.timers.register(begin, first_interval=1.0)
