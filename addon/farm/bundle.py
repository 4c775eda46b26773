# SPDX-License-Identifier: GPL-3.0-or-later
"""A job's scenes, materials and item list in one folder, with the script that renders them in any Blender."""

import hashlib
import json
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path

from ...reference_py.atomic import replacing, write_text
from ..batch.items import Item
from ..batch.scene import Stage, own_texts
from ..blender.blend_files import save_material
from ..jobs.prefetch import prefetch
from ..material.hand_over import WantedHandOver
from ..material.state import Wanted
from .bundle_names import ITEMS, SCRIPT
from .scene_files import SceneFiles

_ADDON = Path(__file__).resolve().parents[1]
# name in the bundle: the module it is a copy of
_SCRIPTS = {SCRIPT: _ADDON / "batch" / "task.py", **{name: _ADDON / "blender" / name for name in ("oiio.py", "dependencies.py")}}


def write_files(items: Sequence[Item], limit: float | None, allow_missing: bool, folder: Path, report: Callable[[str], None]) -> None:
    """Write scenes, what they read, materials, scripts and, last, the list of the items into `folder`. Raises LaminaError, OSError.

    A task ends when one of its pictures takes longer than `limit` seconds, and before the first when its scene lacks a file, unless `allow_missing`.

    What takes a worker Lamina is done here: bakes, shaders and their compilation.
    """
    for name in ("scenes", "materials"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    for name, source in _SCRIPTS.items():
        with replacing(folder / name) as temporary:
            shutil.copyfile(source, temporary)
    prefetch([Wanted(item.stack, item.tier) for item in items], [WantedHandOver(item.stack, False) for item in items], report)
    stage, scenes, rows = Stage(), SceneFiles(folder, _digest, allow_missing, report), []
    scene_file = material_file = ""
    shown = material = None
    for i, item in enumerate(items):
        stage.show(item)
        if shown != (item.blend, item.scene.object):
            shown = (item.blend, item.scene.object)
            for notice in stage.notices:
                report(notice)
            scene_file = scenes.save(item.blend, json.dumps(shown))
        if material != stage.material:
            material = stage.material
            material_file = f"materials/{_digest(item.stack.to_json() + item.tier + item.backend)}.blend"
            save_material(folder / material_file, material)
            report(f"{100 * i // len(items):3} % {item.look}, {item.words}")
        rows.append({
            "id": item.id, "file": item.file, "blend": scene_file, "scene": stage.scene.name, "object": stage.target.name, "slot": stage.slot,
            "material_file": material_file, "material": material.name, "view": item.view, "frame": item.frame, "seed": item.seed,
            "samples": item.samples, "size": item.size, "inputs": item.inputs, "texts": stage.texts | own_texts(item),
        })  # fmt: skip
    scenes.verify()
    write_text(folder / ITEMS, json.dumps({"time_limit": limit, "allow_missing": allow_missing, "items": rows}, indent=1) + "\n")


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:12]
