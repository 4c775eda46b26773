# SPDX-License-Identifier: GPL-3.0-or-later
"""A preset that is saved from a window: the picture comes from a process, and what is cancelled or fails leaves nothing."""

import time

import pytest

bpy = pytest.importorskip("bpy")

from lamina.addon.blender import user_folders
from lamina.addon.blender.images import read_png
from lamina.addon.jobs import saving
from lamina.addon.library import preset_process, user_presets
from lamina.addon.material import material, reading
from lamina.addon.material.backend import NODES
from lamina.reference_py.errors import LaminaError
from lamina.reference_py.material.stack import Stack

pytestmark = pytest.mark.blender

STACK = Stack.from_dict({"name": "Mine", "layers": [{"kind": "dielectric"}], "base": {"kind": "lambert", "color": [0.5, 0.2, 0.1]}})
# A picture of the worker's that takes less than a second.
QUICK = """
from lamina.addon.library import preset_process
render = preset_process.render_thumbnail
preset_process.render_thumbnail = lambda material, path: render(material, path, 32, 2)
main(folder)
"""
CATALOGUE = "00000000-0000-0000-0000-000000000000"


@pytest.fixture
def folder(blender, tmp_path, monkeypatch):
    """The folder of own presets, of this test alone."""
    monkeypatch.setenv(user_folders.PRESETS_VARIABLE, str(tmp_path / "own"))
    yield tmp_path / "own"
    saving.stop()


def begin() -> None:
    made = bpy.data.materials.new("Mine")
    material.apply_stack(made, STACK, "analytic", NODES)
    saving.start(made, "Mine", reading.stack_of(made), CATALOGUE)


def until_done() -> None:
    while saving.running() is not None:
        time.sleep(0.05)
        saving.tick()


def test_the_picture_comes_from_a_process(folder, monkeypatch):
    monkeypatch.setattr(preset_process, "_START", preset_process._START.replace("main(folder)\n", QUICK))
    begin()
    temporary = saving.running().folder
    assert not folder.exists(), "nothing is there before all is"
    with pytest.raises(LaminaError, match="Mine is being saved"):
        begin()
    until_done()
    assert sorted(path.name for path in folder.iterdir()) == ["blender_assets.cats.txt", "mine.blend", "mine.json", "mine.png"]
    pixels, _ = read_png(user_presets.picture_of("mine"))
    assert pixels.std() > 10.0
    with bpy.data.libraries.load(str(user_presets.asset_of("mine")), assets_only=True) as (there, here):
        here.materials = list(there.materials)
    kept = here.materials[0]
    assert kept.name.startswith("Mine") and kept.lamina.is_layered and kept.asset_data.catalog_id == CATALOGUE
    assert tuple(kept.preview.image_size) == pixels.shape[1::-1] and not temporary.exists()
    assert reading.stack_of(kept) == user_presets.load("mine")


def test_progress_is_what_cycles_says(capsys):
    preset_process._tell(bpy.context.scene, "Mem: 8M | Scene | Sample 8/32")
    assert capsys.readouterr().out == "progress 0.250\n"


def test_what_is_cancelled_leaves_nothing(folder):
    begin()
    temporary = saving.running().folder
    saving.cancel()
    assert saving.running() is None and not temporary.exists() and not folder.exists()


def test_a_process_that_fails_leaves_a_preset_without_a_picture(folder, monkeypatch, capfd):
    monkeypatch.setattr(preset_process, "_START", "import sys; sys.exit(3)")
    begin()
    until_done()
    assert "the preset has no picture: its process ended with code 3" in capfd.readouterr().out
    assert user_presets.names() == ["mine"] and not user_presets.picture_of("mine").exists() and user_presets.asset_of("mine").is_file()


def test_a_name_that_was_taken_meanwhile_is_said(folder, capfd):
    begin()
    folder.mkdir()
    STACK.save(folder / "mine.json")
    before = (folder / "mine.json").read_bytes()
    saving.running().cancel()
    until_done()
    assert "the preset is not saved: preset name 'Mine' is taken" in capfd.readouterr().out
    assert [path.name for path in folder.iterdir()] == ["mine.json"] and (folder / "mine.json").read_bytes() == before
