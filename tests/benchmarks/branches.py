# SPDX-License-Identifier: GPL-3.0-or-later
"""What it costs that a material has both branches: to render, to start a render, and to make. Ratios of CPU time, paired.

    branches.py [TABLE.csv]

Three presets. Each figure is a median of interleaved rounds: with OSL over the script alone, without OSL over the stock nodes alone.
"""

import os
import sys
import time
from pathlib import Path
from statistics import median

import bpy

import lamina
from lamina.addon.blender.environment import ensure_osl_query_on_path
from lamina.addon.material import material as materials
from lamina.addon.material.shader_node import remove_material
from lamina.addon.rendering.geometry import plane_mesh
from lamina.addon.rendering.settings import measurement_settings, render_to
from lamina.reference_py.material import presets
from lamina.study.tables import write_table

NAMES = ("glazed_mug", "metallic_car_paint", "frosted_paint")
ROUNDS, SIZE, SAMPLES, COPIES = 5, 96, 64, 8
COLUMNS = ("preset", "osl", "render", "start", "start_ms", "alone_start_ms", "make", "make_ms", "alone_make_ms")


def cpu(work) -> float:
    before = time.process_time()
    work()
    return time.process_time() - before


def made(name: str, backend: str) -> bpy.types.Material:
    new = bpy.data.materials.new(f"{name} {backend}")
    materials.apply_stack(new, presets.load(name), "auto", backend)
    materials.refresh(new, settle=True)
    return new


class Scene:
    """Planes, the first of which fills the frame, with a copy each of a material."""

    def __init__(self, folder: str):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.scene, self.file = bpy.context.scene, os.path.join(folder, "x.exr")
        camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
        camera.data.type, camera.data.ortho_scale, camera.location = "ORTHO", 1.3, (0.0, 0.0, 50.0)
        self.scene.collection.objects.link(camera)
        self.scene.camera, self.scene.world = camera, bpy.data.worlds.new("world")
        self.scene.world.color = (1.0, 1.0, 1.0)
        self.planes = [bpy.data.objects.new("plane", plane_mesh(f"plane {i}", 1.0)) for i in range(COPIES)]
        for i, plane in enumerate(self.planes):
            self.scene.collection.objects.link(plane)
            plane.location.x = 3.0 * i
            plane.data.materials.append(None)

    def seconds(self, copies: list, osl: bool, size: int, samples: int) -> float:
        measurement_settings(self.scene, samples, size, max_bounces=1)
        self.scene.cycles.shading_system = osl
        self.scene.render.threads_mode, self.scene.render.threads = "FIXED", 1
        for plane, material in zip(self.planes, copies):
            plane.data.materials[0] = material
            plane.hide_render = False
        for plane in self.planes[len(copies) :]:
            plane.hide_render = True
        return cpu(lambda: render_to(self.scene, self.file))


def paired(one, other, rounds: int) -> tuple[float, float, float]:
    """Median ratio of two ways, and the median seconds of each."""
    pairs = [(one(), other()) for _ in range(rounds + 1)][1:]
    return median(a / b for a, b in pairs), median(a for a, _ in pairs), median(b for _, b in pairs)


def making(name: str, tier: str, backend: str) -> float:
    """Seconds to make a material of known bakes; a script that was compiled before is compiled again."""
    from lamina.addon.material import script_node

    script_node._compiled.clear()
    new = bpy.data.materials.new("made")
    taken = cpu(lambda: materials.apply_stack(new, presets.load(name), tier, backend))
    remove_material(new)
    return taken


def rows(folder: str):
    for name in NAMES:
        stage = Scene(folder)
        both, alone = made(name, "auto"), {True: made(name, "osl"), False: made(name, "nodes")}
        for osl in (True, False):
            full = paired(lambda: stage.seconds([both], osl, SIZE, SAMPLES), lambda: stage.seconds([alone[osl]], osl, SIZE, SAMPLES), ROUNDS)
            copies = {who: [who.copy() for _ in range(COPIES)] for who in (both, alone[osl])}
            start = paired(lambda: stage.seconds(copies[both], osl, 4, 1), lambda: stage.seconds(copies[alone[osl]], osl, 4, 1), ROUNDS)
            none = median(stage.seconds([], osl, 4, 1) for _ in range(5))
            tier, backend = "analytic", "osl" if osl else "nodes"
            make = paired(lambda: making(name, tier, "auto"), lambda: making(name, tier, backend), ROUNDS)
            each = [1000.0 * (seconds - none) / COPIES for seconds in start[1:]]
            yield (
                name,
                "on" if osl else "off",
                f"{full[0]:.3f}",
                f"{each[0] / max(each[1], 1e-6):.2f}",
                f"{each[0]:.1f}",
                f"{each[1]:.1f}",
                f"{make[0]:.2f}",
                f"{1000.0 * make[1]:.0f}",
                f"{1000.0 * make[2]:.0f}",
            )


def main() -> int:
    import tempfile

    ensure_osl_query_on_path()
    lamina.register()
    with tempfile.TemporaryDirectory() as folder:
        found = []
        for row in rows(folder):
            found.append(row)
            print("branches", "  ".join(f"{column} {value}" for column, value in zip(COLUMNS, row)), file=sys.stderr, flush=True)
    if len(sys.argv) > 1:
        write_table(Path(sys.argv[1]), ("make branches: both branches over one alone, CPU time",), COLUMNS, found)
    sys.stdout.flush()
    os._exit(0)


if __name__ == "__main__":
    main()
