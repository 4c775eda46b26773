# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina chart scale`: time and memory over the number of materials, layers, samples and pictures of a batch."""

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from ...reference_py.atomic import require_writable
from ...reference_py.errors import LaminaError
from ...reference_py.lobes.cache import FOLDER_VARIABLE, keep_in
from ...reference_py.lobes.methods.bake_process import ENVIRONMENT
from ..stamp import module_blender, numpy_version, stamp
from ..tables import Report, write_table
from .output import pyplot, save_picture

_THOUSAND, _LAYERS = (1, 10, 100, 1000), (1, 2, 4, 8, 12, 16, 20)
POINTS = {
    "materials, one baked stack": _THOUSAND,
    "materials, one stack as stock nodes": _THOUSAND,
    "materials, distinct, weidlich_wilkie": _THOUSAND,
    "materials, distinct, baked": (1, 10, 30, 100),
    "materials, distinct, baked before": (1, 10, 30, 100),  # by the study above, in another session
    "materials, Principled in OSL": _THOUSAND,
    "layers, analytic": _LAYERS,
    "layers, weidlich_wilkie": _LAYERS,
    "samples": (1, 4, 16, 64, 256),
    "pictures": (1, 4, 16, 64),
}
_HEADING = (
    "lamina chart scale",
    "CPU seconds and megabytes, each point a process of its own, whose start without materials is taken off; make_clock_s by the clock",
)
_COLUMNS = ("study", "n", "make_s", "make_clock_s", "make_mb", "render_s", "render_mb", "shader_bytes", "texts")


def chart(folder: Path, report: Report) -> None:
    """Write scale.csv and .png and print the table."""
    table = folder / "scale.csv"
    require_writable(table)
    points = [(study, n) for study, numbers in POINTS.items() for n in numbers]
    rows = []
    with tempfile.TemporaryDirectory() as home:
        for i, (study, n) in enumerate(points):
            report(f"{100 * i // len(points):3} % {study}, {n}")
            # what one study baked another may read; no other bakes are seen
            cache = Path(home, f"{study.removesuffix(' before')} {n}")
            # of what takes tenths of a second, the median of three
            runs = [_in_a_process(study, n, cache) for _ in range(3 if study.startswith("layers") else 1)]
            measured = {c: sorted(run[c] for run in runs)[len(runs) // 2] for c in runs[0]}
            rows.append([study, str(n), *("" if measured.get(c) is None else f"{measured[c]:.4g}" for c in _COLUMNS[2:])])
    print(write_table(table, _HEADING, _COLUMNS, rows, report, [stamp(module_blender(), numpy_version())]), end="")
    _draw(folder / "scale.png", rows, report)


def _in_a_process(study: str, n: int, cache: Path) -> dict:
    code = "import os, sys; from lamina.study.charts import scale; scale.measure(sys.argv[1], int(sys.argv[2])); os._exit(0)"
    with tempfile.TemporaryDirectory() as home:
        environment = os.environ | ENVIRONMENT | {"TMPDIR": home, FOLDER_VARIABLE: str(cache)}
        ran = subprocess.run([sys.executable, "-c", code, study, str(n)], env=environment, capture_output=True, text=True)
    answer = next((line for line in ran.stdout.splitlines() if line.startswith('{"')), None)
    if answer is None:
        raise LaminaError(f"{study}, {n}: its process ended with code {ran.returncode}: {ran.stderr.strip()[-300:]}")
    return json.loads(answer)


def measure(study: str, n: int) -> None:
    """Measure one point in this process and print it as JSON."""
    channel = os.fdopen(os.dup(1), "w")
    if study == "pictures":
        result = _pictures(n)
    else:
        from ...addon.blender.user_folders import cache_folder
        from ...addon.session import blender

        keep_in(cache_folder())
        with blender(lambda text: None):
            result = _scene(study, n)
    channel.write("\n" + json.dumps(result) + "\n")
    channel.flush()


def _scene(study: str, n: int) -> dict:
    import bpy

    from ...addon.blender.versions import node_tree
    from ...addon.jobs.prefetch import prefetch
    from ...addon.material.backend import NODES, OSL
    from ...addon.material.material import apply_stack, refresh
    from ...addon.material.state import Wanted
    from ...addon.rendering.geometry import plane_mesh
    from ...addon.rendering.settings import add_object, measurement_settings, render_to

    stacks, method = _stacks(study, n)
    backend = NODES if "stock" in study else OSL
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.data.scenes.new("Scale")
    measurement_settings(scene, n if study == "samples" else 1, 64, max_bounces=1)
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    camera = bpy.data.cameras.new("Camera")
    side = max(round(len(stacks) ** 0.5 + 0.49), 1)
    camera.type, camera.ortho_scale = "ORTHO", 1.1 * side
    scene.camera = add_object(scene, "Camera", camera)
    scene.camera.location = (0.55 * (side - 1), 0.55 * (side - 1), 10.0)
    sun = add_object(scene, "Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.rotation_euler = (0.0, 0.7, 0.0)
    with tempfile.TemporaryDirectory() as folder:
        render_to(scene, Path(folder, "empty.exr"))  # what Cycles takes without materials
        seconds, clock, memory = _spent(), time.monotonic(), _resident()
        prefetch([Wanted(stack, method) for stack in stacks if stack], [], lambda message: None)
        for i, stack in enumerate(stacks):
            material = bpy.data.materials.new("Scale")
            if stack is None:
                node_tree(material).nodes["Principled BSDF"].inputs["Roughness"].default_value = 0.2 + 0.6 * i / n
            else:
                apply_stack(material, stack, method, backend)
                refresh(material, settle=True)
            tile = add_object(scene, "Tile", plane_mesh("Tile", 1.0))
            tile.location = (1.1 * (i % side), 1.1 * (i // side), 0.0)
            tile.data.materials.append(material)
        made, taken, held = _spent(), time.monotonic() - clock, _resident()
        scene.cycles.shading_system = backend == OSL
        render_to(scene, Path(folder, "full.exr"))
        rendered, peak = _spent(), _peak()
    texts = [text for text in bpy.data.texts if text.name.startswith("lamina_")]
    return {"make_s": made - seconds, "make_clock_s": taken, "make_mb": held - memory, "render_s": rendered - made, "render_mb": peak - held,
            "shader_bytes": max((len(t.as_string()) for t in texts), default=0), "texts": len(texts)}  # fmt: skip


def _stacks(study: str, n: int) -> tuple[list, str]:
    from ...reference_py.material import presets
    from ...reference_py.material.stack import Stack

    if study.startswith("layers"):
        layer = {"kind": "dielectric", "ior": 1.5, "roughness": 0.2}
        layers = [layer | {"ior": 1.3 + 0.4 * (i % 2)} for i in range(n)]
        return [Stack.from_dict({"layers": layers, "base": {"kind": "lambert"}})], study.rpartition(" ")[2]
    if "Principled" in study:
        return [None] * n, ""
    if "distinct" in study:
        metals = [{"kind": "conductor", "metal": "copper", "roughness": 0.2 + 0.6 * i / n} for i in range(n)]  # bare metal bakes fastest
        return [Stack.from_dict({"base": metal}) for metal in metals], "weidlich_wilkie" if "wilkie" in study else "baked"
    return [presets.load("clean_copper")] * (1 if study == "samples" else n), "baked"


def _pictures(n: int) -> dict:
    """A whole `lamina batch`, its processes included."""
    job = {"stacks": ["clean_copper"], "qualities": ["weidlich_wilkie"], "frames": f"1-{n}", "size": 32, "samples": 4}
    with tempfile.TemporaryDirectory() as home:
        Path(home, "job.json").write_text(json.dumps(job), encoding="utf-8")
        code = "import os, sys; from lamina.addon.cli.main import run; os._exit(run(sys.argv[1:]))"
        before = os.times()
        subprocess.run([sys.executable, "-c", code, "batch", f"{home}/job.json", "-o", f"{home}/out", "--no-sheet"],
                       check=True, stderr=subprocess.DEVNULL)  # fmt: skip
        after = os.times()
    return {"render_s": after.children_user + after.children_system - before.children_user - before.children_system}


def _spent() -> float:
    """Of this process and of the bakes that it started."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def _resident() -> float:
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def _peak() -> float:
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3


def _draw(path: Path, rows: list[list[str]], report: Report) -> None:
    plot = pyplot(report)
    if plot is None:
        return
    both = ("make", "render")
    panels = (("materials", ("make",), "materials, making them"), ("materials", ("render",), "materials, their first render"), ("layers", both, "layers"),
              ("samples", both, "samples per pixel"), ("pictures", both, "pictures of a batch"))  # fmt: skip
    figure, axes = plot.subplots(2, len(panels), figsize=(20, 8), layout="constrained")
    for column, (word, parts, label) in enumerate(panels):
        for row, unit in ((0, "s"), (1, "mb")):
            axis = axes[row, column]
            for study in dict.fromkeys(r[0] for r in rows if word in r[0]):
                for part in parts:
                    index = _COLUMNS.index(f"{part}_{unit}")
                    points = [(int(r[1]), float(r[index])) for r in rows if r[0] == study and r[index]]
                    if points:
                        name = study.replace(word, "").strip(", ")
                        axis.plot(*zip(*points), "--s" if part == "render" and len(parts) > 1 else "-o", markersize=4,
                                  label=name if len(parts) == 1 else f"{name} {part}".strip())  # fmt: skip
            axis.set(xlabel=label, ylabel="CPU seconds" if unit == "s" else "megabytes")
            if axis.lines:
                axis.set_xscale("log")
                axis.set_yscale("log" if unit == "s" else "symlog")
                axis.grid(alpha=0.3)
                axis.legend(fontsize=7, framealpha=0.5)
            else:
                axis.set_visible(False)
    figure.suptitle("What Lamina costs as work grows: making the materials (bakes included), and a first render of them")
    save_picture(figure, path, report)
