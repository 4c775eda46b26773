# SPDX-License-Identifier: GPL-3.0-or-later
"""What a hand waits for, in CPU time: opening a file of many Lamina materials beside one of Principled ones, adding a layer, a preset.

    felt.py [TABLE.csv]

Each file is opened in processes of its own, in turns; the least of `ROUNDS`. A click is measured in a new session, the
first one, after the panel was seen: its buttons were asked whether they can be pressed as Blender does to draw them, and
what a window then reads between its events was read. Then the least of some more. The scene renders with Cycles, and what a
window compiles while values rest is compiled between clicks. A ready layer is one that a window does not foresee.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import bpy

import lamina
from lamina.addon import later
from lamina.addon.blender.environment import ensure_osl_query_on_path
from lamina.addon.material import first_click
from lamina.study.stamp import module_blender, numpy_version, stamp
from lamina.study.tables import write_table

MANY, ROUNDS, CLICKS = 200, 5, 6
PRESETS = ("glazed_mug", "clean_copper", "frosted_paint", "metal_foil")
COLUMNS = ("what", "first_ms", "least_ms", "asked_ms")
ASKED_OPEN, ASKED_ADD, ASKED_PRESET = 500.0, 60.0, 150.0


def build(path: str, kind: str) -> None:
    """A file of `MANY` materials, each on a plane of its own; a save bakes and solves what they need."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    mesh = bpy.data.meshes.new("plane")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    for i in range(MANY):
        material = bpy.data.materials.new(f"{kind} {i}")
        material.use_nodes = True
        if kind == "lamina":
            from lamina.addon.material import material as materials
            from lamina.reference_py.material import presets

            materials.apply_stack(material, presets.load(PRESETS[i % len(PRESETS)]))
        item = bpy.data.objects.new(material.name, mesh.copy())
        item.data.materials.append(material)
        bpy.context.collection.objects.link(item)
    bpy.ops.wm.save_as_mainfile(filepath=path, compress=False)


def opened(path: str) -> float:
    """Milliseconds to open a file and to look at it once."""
    start = time.process_time()
    bpy.ops.wm.open_mainfile(filepath=path)
    bpy.context.view_layer.update()
    return 1000.0 * (time.process_time() - start)


def clicked() -> dict[str, list[float]]:
    """Milliseconds of every click, by what it does."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.engine = "CYCLES"
    item = bpy.data.objects.new("object", bpy.data.meshes.new("mesh"))
    bpy.context.collection.objects.link(item)
    bpy.context.view_layer.objects.active = item
    item.data.materials.append(bpy.data.materials.new("material"))
    took: dict[str, list[float]] = {"a preset": [], "a layer": [], "a ready layer": []}
    bpy.ops.lamina.convert_principled.poll()
    bpy.ops.lamina.apply_preset.poll()
    timer = later.read_soon()
    while timer() is not None:
        pass

    def timed(what: str, act) -> None:
        start = time.process_time()
        act()
        took[what].append(1000.0 * (time.process_time() - start))
        first_click.compile_next(item.active_material)

    for i in range(CLICKS):
        timed("a preset", lambda i=i: bpy.ops.lamina.apply_preset(preset=("clear_coat_car_paint", "metallic_car_paint")[i % 2]))
        timed("a layer", lambda: bpy.ops.lamina.layer_add(kind="dielectric"))
        timed("a ready layer", lambda: bpy.ops.lamina.layer_add_ready(ready="rust"))
    return took


def in_a_process(*arguments: str, cache: Path):
    """What `main` prints for these arguments in a process of its own."""
    environment = os.environ | {"LAMINA_CACHE": str(cache), "PYTHONPYCACHEPREFIX": str(cache / "compiled")}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    done = subprocess.run([sys.executable, __file__, *arguments], env=environment, capture_output=True, text=True)
    line = next((line for line in done.stdout.splitlines() if line.startswith("TOOK ")), None)
    if line is None:
        raise SystemExit(f"lamina: {' '.join(arguments)}: {done.stderr[-500:]}")
    return json.loads(line.removeprefix("TOOK "))


def main() -> None:
    acts = {"--build": build, "--open": opened, "--click": clicked}
    if len(sys.argv) > 1 and sys.argv[1] in acts:
        ensure_osl_query_on_path()
        lamina.register()
        print("TOOK", json.dumps(acts[sys.argv[1]](*sys.argv[2:])), flush=True)
        os._exit(0)
    table = Path(sys.argv[1]) if len(sys.argv) > 1 else None
    with tempfile.TemporaryDirectory() as home:
        cache = Path(home) / "cache"
        files = {kind: str(Path(home) / f"{kind}.blend") for kind in ("principled", "lamina")}
        for kind, path in files.items():
            in_a_process("--build", path, kind, cache=cache)
        took = {kind: [] for kind in files}
        for _ in range(ROUNDS):
            for kind, path in files.items():
                took[kind].append(in_a_process("--open", path, cache=cache))
        clicks = [in_a_process("--click", cache=cache) for _ in range(ROUNDS)]
    least = {kind: min(values) for kind, values in took.items()}
    rows = [(f"opening {MANY} {kind} materials", "", f"{ms:.0f}", "") for kind, ms in least.items()]
    rows.append(("what Lamina adds to that", "", f"{least['lamina'] - least['principled']:.0f}", f"{ASKED_OPEN:.0f}"))
    for what, asked in (("a preset", ASKED_PRESET), ("a layer", ASKED_ADD), ("a ready layer", ASKED_ADD)):
        first, later = min(c[what][0] for c in clicks), min(min(c[what][1:]) for c in clicks)
        rows.append((what, f"{first:.0f}", f"{later:.0f}", f"{asked:.0f}"))
    for row in rows:
        print(*row, sep="\t")
    if table:
        write_table(table, ("make felt", f"CPU time, least of {ROUNDS} processes"), COLUMNS, rows, print, [stamp(module_blender(), numpy_version())])


if __name__ == "__main__":
    main()
