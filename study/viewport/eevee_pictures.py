# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures by EEVEE, which the bpy wheel cannot make, from the Blender that LAMINA_BLENDER names."""

import json
import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

import bpy
import numpy as np

from ...addon.blender.blend_files import save_copy
from ...addon.blender.images import read_exr
from ...reference_py.errors import LaminaError


def blender_program() -> str:
    """The Blender to ask. Raises LaminaError where LAMINA_BLENDER names none."""
    named = os.environ.get("LAMINA_BLENDER", "")
    program = shutil.which(named) if named else None
    if program is None:
        said = f"LAMINA_BLENDER is {named}, which is no program" if named else "LAMINA_BLENDER names no Blender"
        raise LaminaError(f"{said}; the module bpy has no EEVEE, so this chart needs a Blender's path there")
    return program


def blender_version() -> str:
    """Of `blender_program`."""
    done = subprocess.run([blender_program(), "--version"], capture_output=True, text=True, timeout=120, stdin=subprocess.DEVNULL)
    return done.stdout.split("\n")[0].removeprefix("Blender ").strip()


def eevee_pictures(
    scene: bpy.types.Scene, item: bpy.types.Object, materials: Sequence[bpy.types.Material], samples: int, report: Callable[[str], None]
) -> np.ndarray:
    """Radiance (materials, h, w, 3), the top row first, of each material on an object of a scene.

    The other Blender opens a copy of the file. Raises LaminaError when it leaves a picture out.
    """
    for material in materials:
        material.use_fake_user = True
    for image in bpy.data.images:
        if image.is_dirty:  # made here: it is saved only if it is packed
            image.pack()
    with tempfile.TemporaryDirectory() as folder:
        save_copy(Path(folder, "scenes.blend"))
        task = {"scene": scene.name, "object": item.name, "materials": [m.name for m in materials], "samples": samples, "folder": folder}
        Path(folder, "task.json").write_text(json.dumps(task), encoding="utf-8")
        command = [blender_program(), "-b", Path(folder, "scenes.blend"), "--python-exit-code", "1", "--python", Path(__file__).with_name("eevee_task.py"),
                   "--", Path(folder, "task.json")]  # fmt: skip
        _run([str(word) for word in command], len(materials), report)
        return np.array([_picture(Path(folder, f"{i}.exr")) for i in range(len(materials))])


def _run(command: list[str], count: int, report: Callable[[str], None]) -> None:
    lines: list[str] = []
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, text=True) as process:
        for line in process.stdout:
            lines.append(line)
            if line.startswith("EEVEE "):
                done = sum(said.startswith("EEVEE ") for said in lines)
                report(f"EEVEE, {100 * done // count:3} %")
    if process.returncode != 0:
        raise LaminaError(f"{command[0]} failed: {''.join(lines[-5:]).strip()}")


def _picture(path: Path) -> np.ndarray:
    channels = read_exr(path).channels
    return np.stack([channels[name] for name in "RGB"], axis=-1).astype(np.float64)
