# SPDX-License-Identifier: GPL-3.0-or-later
"""The viewport's chart: without a Blender that has EEVEE it says so before any work; its task renders what it is told."""

import json

import pytest

bpy = pytest.importorskip("bpy")

from lamina.reference_py.errors import LaminaError
from lamina.study.charts import viewport_chart
from lamina.study.pareto.ball_picture import Surroundings
from lamina.study.pareto.bench import ball, with_material
from lamina.study.viewport import compared, eevee_pictures

pytestmark = pytest.mark.blender


@pytest.mark.parametrize(("named", "said"), [("", "LAMINA_BLENDER names no Blender"), ("/no/blender", "/no/blender, which is no program")])
def test_without_a_blender_it_says_so_and_writes_nothing(blender, tmp_path, monkeypatch, named, said):
    monkeypatch.setenv("LAMINA_BLENDER", named)
    with pytest.raises(LaminaError, match=said):
        viewport_chart.chart(tmp_path, print, surface=["clean_copper"])
    assert list(tmp_path.iterdir()) == []


def test_the_other_blender_gets_a_file_with_all_that_it_needs(blender, tmp_path, monkeypatch):
    """A program in its place keeps the file and the task."""
    program = tmp_path / "blender"
    program.write_text(f'#!/bin/sh\ncp "$2" {tmp_path}/scenes.blend; for last; do :; done; cp "$last" {tmp_path}/task.json; echo no EEVEE; exit 3\n')
    program.chmod(0o755)
    monkeypatch.setenv("LAMINA_BLENDER", str(program))
    materials = [bpy.data.materials.new(name) for name in ("one", "two")]
    item = with_material(ball(), materials[0])
    with compared.lit_stage(16, Surroundings(height=16), item) as stage:
        with pytest.raises(LaminaError, match="failed: no EEVEE"):
            eevee_pictures.eevee_pictures(stage.scene, item, materials, 4, lambda text: None)
    task = json.loads((tmp_path / "task.json").read_text())
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "scenes.blend"), load_ui=False)
    scene = bpy.data.scenes[task["scene"]]
    assert scene.objects[task["object"]].material_slots and scene.camera
    assert [bpy.data.materials[name].name for name in task["materials"]] == ["one", "two"]
    assert all(image.packed_file for image in bpy.data.images if image.users)
