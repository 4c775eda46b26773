# SPDX-License-Identifier: GPL-3.0-or-later
"""Full and read-only disks, kills within a bake or a write, missing OSL: nothing lost, nothing half-written, one clear line each.

Where each hard condition is done for real:
kill -9 while rendering: test_batch (killed_while_rendering), 200 pictures in `make killed-batch`; while baking and writing: here
a disk that is full, a read-only output: here; two batches in one folder: test_batch (one_batch_at_a_time)
broken EXR: test_batch (damaged_ones_made_anew); broken .blend, an object that is not there, `ulimit -v`: test_batch (what_fails_is_named)
a render that hangs: test_batch (hangs), test_farm (takes_too_long)
JSON that is truncated, of 10 MB, deeply nested; paths that climb out; a newer schema; names of any kind: test_batch_job
folders and stacks whose names have 200 letters, spaces, umlauts and kanji: the fixtures of test_batch and test_farm
names of presets that climb out: test_assets; an OSL text that was edited by hand, in a .blend: here, mended in test_check
missing OSL: here; a Blender built without OSL: test_real_blender
a clock that goes backwards: here for the cache, test_batch (damaged_ones_made_anew) for pictures
all readers under 100,000 broken inputs: `make fuzz`
"""

import json
import os
import subprocess
import sys
import time

import numpy as np
import pytest
from support.commands import RUN, lamina

from lamina.reference_py.atomic import write_text
from lamina.reference_py.errors import LaminaError
from lamina.reference_py.lobes import cache
from lamina.reference_py.material import presets


@pytest.fixture
def mounted(tmp_path):
    """Mounts a file system of a few bytes; only root of its own machine may."""
    places = []

    def mount(name: str, size: str = "64k"):
        place = tmp_path / name
        place.mkdir()
        if subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "lamina", place], capture_output=True).returncode:
            pytest.skip("no right to mount a small file system")
        places.append(place)
        return place

    yield mount
    for place in places:
        subprocess.run(["umount", "-l", place], check=True)


def test_a_full_disk_keeps_what_was_there(mounted, registered_lamina):
    """Every kind of file that Lamina writes."""
    from lamina.addon.batch import task
    from lamina.addon.blender import images, oiio
    from lamina.addon.blender.blend_files import save_copy

    disk, noise = mounted("disk"), np.random.default_rng(1).random((120, 120)).astype(np.float32)
    channels = dict.fromkeys("RGBA", noise)

    def farmed(path, _):
        task._write(path, channels, {"lamina:pixels": task.pixel_hash(channels)})

    writers = {
        "a.exr": lambda path, _: images.write_exr(path, channels), "b.png": lambda path, _: images.write_png(path, np.frombuffer(noise.tobytes()[:57600], np.uint8).reshape(120, 160, 3)),
        "c.json": write_text, "d.blend": lambda path, _: save_copy(path), "e.exr": farmed,
    }  # fmt: skip
    for name, write in writers.items():
        (disk / name).write_bytes(b"the former file")
    filler = disk / "filler"
    filler.write_bytes(b"x" * 40_000)
    for name, write in writers.items():
        with pytest.raises((LaminaError, OSError)) as raised:
            write(disk / name, "text" * 20_000)
        assert "\n" not in str(raised.value).strip() and str(raised.value)
        assert (disk / name).read_bytes() == b"the former file"
    assert sorted(f.name for f in disk.iterdir()) == sorted([*writers, "filler"])
    filler.unlink()
    oiio.write(disk / "a.exr", {"R": noise[:8, :8]}, {})


def test_a_batch_on_a_full_disk_names_what_failed_and_goes_on_later(mounted, tmp_path, registered_lamina):
    disk = mounted("disk", "4k")
    job = tmp_path / "job.json"
    job.write_text(json.dumps({"stacks": ["clean_copper"], "qualities": ["weidlich_wilkie"], "backend": "nodes", "size": 16, "samples": 1}))
    _, said = lamina("batch", job, "-o", disk / "out", code=2)
    assert "choose another disk, or make room" in said and not list(disk.glob("out/*.exr")), said
    subprocess.run(["mount", "-o", "remount,size=90m", disk], check=True)
    lamina("batch", job, "-o", disk / "out", "--no-sheet")
    assert len(list((disk / "out").glob("*.exr"))) == 1


def test_a_read_only_folder_is_named_before_work_starts(mounted, tmp_path):
    disk = mounted("disk")
    job = tmp_path / "job.json"
    job.write_text('{"stacks": ["clean_copper"]}')
    subprocess.run(["mount", "-o", "remount,ro", disk], check=True)
    _, said = lamina("batch", job, "-o", disk, code=2)
    assert f"{disk}: cannot write into this folder: Read-only" in said
    for command in (["batch", job, "-o", disk / "new"], ["farm", job, "-o", disk / "new"],
                    ["render", "clean_copper", "-o", disk / "a.png"]):  # fmt: skip
        _, said = lamina(*command, code=2)
        assert len(said.splitlines()) == 1 and str(disk) in said and "Read-only file system" in said


def test_a_bake_that_is_killed_leaves_a_cache_that_works(tmp_path):
    """Kill -9 at several moments of computing and writing; then the same bake succeeds, from a cache without broken files."""
    environment = os.environ | {"LAMINA_CACHE": str(tmp_path), "OMP_NUM_THREADS": "1"}
    command = [*RUN, "explain", "clean_copper", "--json"]
    for moment in (0.6, 1.4, 2.2):
        process = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(moment)
        process.kill()
        process.wait()
        for file in tmp_path.glob("[!.]*.json"):
            json.loads(file.read_text())
    assert json.loads(subprocess.run(command, env=environment, capture_output=True, check=True).stdout)["chosen"]


# Writes the same files over and over, each time whole: with pixels of one value, and as long as it should be.
WRITES = """
import sys
from pathlib import Path
import numpy as np
from lamina.addon.session import blender
from lamina.addon.material.shader_node import shader_of
with blender(lambda text: None):
    from lamina.addon.batch import task
    from lamina.reference_py.atomic import write_text
    folder = Path(sys.argv[1])
    for i in range(1_000_000):
        channels = dict.fromkeys("RGBA", np.full((400, 400), i, np.float32))
        task._write(folder / "a.exr", channels, {"lamina:inputs": "x", "lamina:pixels": task.pixel_hash(channels)})
        write_text(folder / "b.json", str(i) * 100_000)
        if not i:
            print("began", file=sys.stderr, flush=True)
"""


def test_a_write_that_is_killed_leaves_the_former_file_or_the_new_one(tmp_path, registered_lamina):
    from lamina.addon.batch.task import problem

    caught = kills = 0
    while kills < 2 or not caught:
        kills += 1
        assert kills < 10
        process = subprocess.Popen([sys.executable, "-c", WRITES, str(tmp_path)], stderr=subprocess.PIPE, text=True)
        assert process.stderr.readline() == "began\n"
        time.sleep(0.03 * kills)
        process.kill()
        process.wait()
        assert problem(tmp_path / "a.exr", "x")[0] == ""
        text = (tmp_path / "b.json").read_text()
        assert text == text[: len(text) // 100_000] * 100_000
        caught = len(list(tmp_path.iterdir())) - 2  # a half-made file beside them: a kill came within a write


def test_without_osl_stock_nodes_work_and_osl_is_refused_in_one_line(tmp_path, registered_lamina):
    """What Script nodes need is taken away, for this process and those that it starts."""
    (tmp_path / "without").mkdir()
    (tmp_path / "without" / "sitecustomize.py").write_text('import sys\nsys.modules["oslquery"] = None\n')
    environment = os.environ | {"PYTHONPATH": str(tmp_path / "without")}
    job = tmp_path / "job.json"
    job.write_text(json.dumps({"stacks": ["clean_copper"], "qualities": ["weidlich_wilkie"], "backend": "osl", "size": 8, "samples": 1}))
    stack = ("clean_copper", "--tier", "weidlich_wilkie", "--samples", 1, "--size", 8, "--scene", "sphere")
    _, said = lamina("batch", job, "-o", tmp_path / "out", code=2, env=environment)
    assert len(said.splitlines()) == 1 and "backend osl needs Cycles with OSL" in said and "choose backend auto or nodes" in said
    assert not (tmp_path / "out").exists()
    from lamina.addon.blender.images import read_exr

    pictures = []
    for backend in ("nodes", "auto"):
        lamina("render", *stack, "--backend", backend, "-o", tmp_path / f"{backend}.exr", env=environment)
        pictures.append(read_exr(tmp_path / f"{backend}.exr").channels["R"])
    # a Script node without sockets would be white, whatever the light
    assert np.array_equal(*pictures) and 0.0 < pictures[0].max() and pictures[0].min() == 0.0


def test_a_render_of_osl_where_there_is_none_is_announced(blender, monkeypatch, capsys):
    from lamina.addon.blender import environment
    from lamina.addon.jobs import staleness
    from lamina.addon.material import material

    for backend in ("osl", "nodes"):
        material.apply_stack(blender.data.materials.new(backend), presets.load("clean_copper"), "weidlich_wilkie", backend)
    blender.context.scene.render.engine, blender.context.scene.cycles.shading_system = "CYCLES", True
    staleness.announce()
    assert "OSL" not in capsys.readouterr().out
    monkeypatch.setattr(environment, "renders_osl", lambda: False)
    staleness.announce()
    said = [line for line in capsys.readouterr().out.splitlines() if "OSL script alone" in line]
    assert len(said) == 1 and said[0].startswith("Lamina: osl: renders black")


def test_a_file_whose_shader_was_edited_by_hand_opens_and_keeps_the_edit(tmp_path, blender):
    from lamina.addon.check import check
    from lamina.addon.material import material
    from lamina.addon.material.shader_node import shader_of

    owner = blender.data.materials.new("edited")
    owner.use_fake_user = True
    material.apply_stack(owner, presets.load("clean_copper"), "weidlich_wilkie", "osl")
    text = shader_of(owner).script
    edited = text.as_string().replace("BSDF = lobe_0;", "BSDF = 0.5 * lobe_0; // mine")
    text.from_string(edited)
    name = text.name
    blender.ops.wm.save_as_mainfile(filepath=str(tmp_path / "edited.blend"))
    blender.ops.wm.open_mainfile(filepath=str(tmp_path / "edited.blend"))
    owner = blender.data.materials["edited"]
    assert "shader_edited" in [finding.code for finding in check.find(owner, blender.context.scene, blender.context.preferences)]
    material.regenerate(owner)
    assert shader_of(owner).script.name != name
    assert blender.data.texts[name].as_string() == edited  # nothing of the user's is lost


@pytest.mark.parametrize(
    "text", ["", "{", "null", "[1]", '{"chosen": 99}', '{"chosen": 0, "lobe_set": {"a": []}, "tried": [{}], "reason": 1}', "[" * 100_000, "\x00"]
)
def test_a_broken_cache_counts_as_none(tmp_path, monkeypatch, text):
    from lamina.reference_py.lobes import methods

    monkeypatch.setattr(cache, "_memory", {})
    monkeypatch.setattr(cache, "_folder", tmp_path)
    stack = presets.load("clean_copper")
    cache._file(methods.key_of(stack, "auto")).write_text(text)
    assert not methods.is_cached(stack, "auto")


def test_the_clock_may_run_backwards(tmp_path, monkeypatch):
    """The cache drops its oldest files by their dates: what was just written stays, whatever the clock says."""
    monkeypatch.setattr(cache, "_memory", {})
    monkeypatch.setattr(cache, "_folder", tmp_path)
    monkeypatch.setattr(cache, "_FILES", 2)
    for i, date in enumerate((4e9, 3e9)):
        cache.cached(f"key {i}", lambda: i, lambda v: {"v": v}, lambda d: d["v"])
        os.utime(cache._file(f"key {i}"), (date, date))
    cache.cached("now", lambda: 7, lambda v: {"v": v}, lambda d: d["v"])
    cache._memory.clear()
    assert cache.get("now", lambda d: d["v"]) == 7
