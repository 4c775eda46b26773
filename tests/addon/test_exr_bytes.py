# SPDX-License-Identifier: GPL-3.0-or-later
"""OpenEXR files in memory: what Blender reads of them, packed, saved and opened again."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from lamina.addon.blender.exr_bytes import exr_bytes
from lamina.addon.shader.nodes.table_image import TableImage
from lamina.reference_py.lobes.view_table import KNOTS

pytestmark = pytest.mark.blender


def packed(pixels):
    image = bpy.data.images.new("numbers", pixels.shape[1], pixels.shape[0], float_buffer=True, is_data=True, alpha=True)
    image.alpha_mode = "CHANNEL_PACKED"
    data = exr_bytes(pixels)
    image.pack(data=data, data_len=len(data))
    image.source = "FILE"
    return image


def read(image):
    pixels = np.empty(4 * image.size[0] * image.size[1], np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(image.size[1], image.size[0], 4)


# lines that are no multiple of a chunk's, a single texel, and noise that no zip shortens
@pytest.mark.parametrize(("height", "width"), [(1, 1), (16, 3), (37, 50)])
def test_blender_reads_every_bit(blender, height, width):
    bits = np.random.default_rng(1).integers(0x00800000, 0x7F000000, (height, width, 4), dtype=np.uint32)
    pixels = bits.view(np.float32)
    assert np.array_equal(read(packed(pixels)).view(np.uint32), bits)


def test_smooth_numbers_are_shortened():
    pixels = np.tile(np.linspace(0.0, 1.0, 200)[None, :, None], (64, 1, 4))
    assert len(exr_bytes(pixels)) < 0.1 * pixels.astype(np.float32).nbytes


def test_tables_keep_their_numbers_through_a_file(blender, tmp_path):
    numbers = [np.random.default_rng(n).random((9, 5, KNOTS)) for n in range(4)]
    table = TableImage(4, 9, 5)
    table.add(numbers)
    image = table.make()
    image.use_fake_user = True
    wanted = np.stack(numbers, axis=-1).reshape(9, 5 * KNOTS, 4).astype(np.float32)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "tables.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "tables.blend"))
    opened = bpy.data.images["Lamina Tables"]
    assert (opened.is_float, opened.file_format, opened.colorspace_settings.name) == (True, "OPEN_EXR", "Non-Color")
    assert np.array_equal(read(opened), wanted)
