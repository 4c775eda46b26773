# SPDX-License-Identifier: GPL-3.0-or-later
"""Files live without Lamina: a process that never imported it opens them and renders the same."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import lamina

pytestmark = pytest.mark.blender

BUILT = Path(lamina.__file__).parent / "demo_blend" / "presets.blend"

# Runs in a Blender that has no Lamina. The wheel's OSL query module is off the path; a real Blender has it on.
STRANGER = """
import sys
from pathlib import Path
import bpy
python = Path(bpy.utils.resource_path("LOCAL")) / "python" / "lib"
sys.path.append(str(python / f"python{sys.version_info.major}.{sys.version_info.minor}" / "site-packages"))
bpy.ops.wm.open_mainfile(filepath=sys.argv[1])
scene = bpy.context.scene
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 160, 90, 100
scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.use_adaptive_sampling = 4, False, False
image = scene.render.image_settings
image.file_format, image.color_depth, image.exr_codec = "OPEN_EXR", "32", "ZIP"
scene.render.filepath, scene.render.use_file_extension = sys.argv[2], False
bpy.ops.render.render(write_still=True)
assert not any(name.split(".")[0] == "lamina" for name in sys.modules), "Lamina was imported"
import os
os._exit(0)
"""


def render_elsewhere(blend: Path, picture: Path) -> np.ndarray:
    from lamina.addon.blender.images import read_exr

    subprocess.run([sys.executable, "-c", STRANGER, str(blend), str(picture)], check=True, capture_output=True, timeout=300)
    channels = read_exr(picture).channels
    return np.stack([channels[c] for c in "RGB"], axis=-1)


@pytest.fixture(scope="module")
def committed(registered_lamina, tmp_path_factory) -> np.ndarray:
    """The committed file's picture."""
    return render_elsewhere(BUILT, tmp_path_factory.mktemp("committed") / "picture.exr")


def test_presets_blend_renders_the_same_without_lamina(blender, committed, tmp_path):
    """Against a copy that this Lamina builds now: the committed file is not stale either."""
    from lamina.addon.blender.blend_files import save_copy
    from lamina.demo_blend.build_presets import build

    build()
    save_copy(tmp_path / "fresh.blend")
    fresh = render_elsewhere(tmp_path / "fresh.blend", tmp_path / "fresh.exr")
    assert committed.max() > 0.5
    assert np.percentile(np.abs(committed - fresh), 99) <= 1e-3 * committed.mean()


def test_a_lost_shader_would_be_caught(blender, committed, tmp_path):
    """A deliberate fault: materials that lost the link to their shader must not compare equal."""
    import bpy

    from lamina.addon.blender.blend_files import save_copy

    bpy.ops.wm.open_mainfile(filepath=str(BUILT))
    for material in bpy.data.materials:
        for link in [k for k in material.node_tree.links if k.from_node.bl_idname == "ShaderNodeScript"]:
            material.node_tree.links.remove(link)
    save_copy(tmp_path / "broken.blend")
    broken = render_elsewhere(tmp_path / "broken.blend", tmp_path / "broken.exr")
    assert np.percentile(np.abs(committed - broken), 99) > 0.05 * committed.mean()
