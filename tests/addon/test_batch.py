# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina batch` as its user meets it: what it leaves, and what it makes of all that goes wrong meanwhile."""

import csv
import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from support.commands import RUN, lamina

from lamina.reference_py.errors import LaminaError
from lamina.reference_py.material import presets
from lamina.reference_py.version import version

pytest.importorskip("bpy")

pytestmark = pytest.mark.blender

JOB = {"stacks": ["clean_copper"], "qualities": ["weidlich_wilkie"], "backend": "nodes", "frames": "1-3", "size": 16, "samples": 2}


def write_job(folder, **keys):
    path = folder / "job.json"
    path.write_text(json.dumps(JOB | keys))
    return path


def table(folder) -> list[dict]:
    with open(folder / "batch.csv", newline="") as file:
        return list(csv.DictReader(file))


def pixels(folder) -> dict:
    return {row["id"]: (row["state"], row["inputs"], row["pixels"]) for row in table(folder)}


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """A job that was done without disturbance in a folder of a long name, and what was said."""
    folder = tmp_path_factory.mktemp("batch") / ("Größe & Lack, 漆 " + "x" * 183)
    folder.mkdir()
    _, said = lamina("batch", write_job(folder), "-o", folder / "out", "--processes", 1)
    return folder, said


@pytest.fixture
def copy(done, tmp_path):
    """A copy of what `done` left."""
    shutil.copytree(done[0], tmp_path / "copy")
    return tmp_path / "copy"


def test_a_batch_leaves_pictures_with_their_origin_a_table_and_a_sheet(done, registered_lamina):
    from lamina.addon.blender.images import read_exr, read_png

    folder, said = done
    rows = table(folder / "out")
    assert [row["state"] for row in rows] == ["done"] * 3 and "3/3, 100 %, about 0 s left" in said
    assert sorted(f.name for f in (folder / "out").iterdir()) == sorted(["batch.csv", "sheet.png", *(r["id"] + ".exr" for r in rows)])
    for row in rows:
        picture = read_exr(folder / "out" / f"{row['id']}.exr")
        texts = picture.metadata
        assert set(picture.channels) == set("RGBA") and picture.channels["R"].shape == (16, 16)
        assert json.loads(texts["lamina:stack"]) == presets.load("clean_copper").to_dict()
        assert texts["lamina:version"] == version() and texts["lamina:tier"] == "weidlich_wilkie"
        assert texts["lamina:seed"] == row["frame"] == row["seed"] and texts["lamina:samples"] == "2"
        assert texts["lamina:blender"][0] in "45" and texts["lamina:inputs"] == row["inputs"]
        assert 0.0 < float(row["soft_light_error"]) < 1.0 and "soft_light " + row["soft_light_error"] in texts["lamina:error"]
        assert float(row["mean_r"]) == pytest.approx(float(picture.channels["R"].mean()), rel=1e-4) and float(row["mean_r"]) > 0.01
    worst = max(max(float(row["albedo_error"]), float(row["soft_light_error"])) for row in rows)
    assert worst > 0.02 and f"3 of 3 pictures miss the tolerance of 2 %, the worst {rows[0]['id']}" in said and f"error of {100 * worst:.1f} %" in said
    assert len({row["pixels"] for row in rows}) == 3  # each frame has its own noise
    assert min(read_png(folder / "out" / "sheet.png")[0].shape[:2]) > 192


def test_whole_pictures_are_kept_and_damaged_ones_made_anew(done, copy, registered_lamina):
    """Truncated, bent and missing ones; dates that a clock running backwards leaves do not matter."""
    from lamina.addon.blender import oiio

    out = copy / "out"
    first, second, third = (out / f"{row['id']}.exr" for row in table(out))
    os.utime(first, (4e9, 4e9))
    third.unlink()
    second.write_bytes(second.read_bytes()[:-200])
    _, said = lamina("batch", copy / "job.json", "-o", out, "--processes", 1)
    assert "3 pictures, 1 of them are there and whole" in said
    assert first.stat().st_mtime == 4e9
    assert pixels(out) == pixels(done[0] / "out")
    channels, texts = oiio.read(second)
    channels["G"][3, 3] += 1e-3
    oiio.write(second, channels, texts)  # a bit that turned, with a header that looks right
    from lamina.addon.batch.task import problem

    assert problem(second, texts["lamina:inputs"])[0] == "has other pixels than were written"


def test_pictures_of_other_inputs_are_replaced_only_on_demand(copy):
    out = copy / "out"
    before = {file.name: file.read_bytes() for file in out.iterdir()}
    (copy / "job.json").write_text(json.dumps(JOB | {"samples": 1, "frames": "1-4"}))
    _, said = lamina("batch", copy / "job.json", "-o", out, code=2)
    assert len(said.splitlines()) == 1 and "3 pictures of other inputs" in said and "clean_copper-" in said and "--replace" in said
    assert {file.name: file.read_bytes() for file in out.iterdir()} == before
    lamina("batch", copy / "job.json", "-o", out, "--replace", "--processes", 1)
    assert [(row["state"], row["samples"]) for row in table(out)] == [("done", "1")] * 4


def test_killed_while_rendering_it_goes_on_where_it_was(done, tmp_path):
    out = tmp_path / "out"
    process = subprocess.Popen([*RUN, "batch", str(done[0] / "job.json"), "-o", str(out), "--processes", "1"], stderr=subprocess.PIPE, text=True)
    for line in process.stderr:
        if line.startswith("lamina batch: 1/3"):
            break
    process.send_signal(signal.SIGSTOP)  # on a busy machine it would be done before its workers are listed
    children = subprocess.run(["pgrep", "-P", str(process.pid)], capture_output=True, text=True).stdout.split()
    assert children
    process.kill()
    process.wait()
    limit = time.monotonic() + 10.0
    while any(alive(int(child)) for child in children):  # without their batch the workers leave at once
        assert time.monotonic() < limit
        time.sleep(0.05)
    (out / ".half.exr").write_bytes(b"what a kill within a write leaves")
    (out / ".work").mkdir(exist_ok=True)
    _, said = lamina("batch", done[0] / "job.json", "-o", out, "--processes", 1)
    assert "3 pictures, 0 of them" not in said
    assert pixels(out) == pixels(done[0] / "out")
    assert sorted(f.name for f in out.iterdir()) == sorted(f.name for f in (done[0] / "out").iterdir())


def alive(pid: int) -> bool:
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.parametrize("number, code", [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_leaves_no_process_and_nothing_half_done(done, tmp_path, number, code):
    process = subprocess.Popen([*RUN, "batch", str(done[0] / "job.json"), "-o", str(tmp_path / "out")], stderr=subprocess.PIPE, text=True)
    assert "0 of them" in process.stderr.readline()
    time.sleep(1.0)
    children = subprocess.run(["pgrep", "-P", str(process.pid)], capture_output=True, text=True).stdout.split()
    process.send_signal(number)
    _, error = process.communicate(timeout=60)
    assert process.returncode == code and error.strip().splitlines()[-1] == "lamina: cancelled" and "Traceback" not in error
    time.sleep(0.3)
    assert children and not any(alive(int(child)) for child in children)
    assert not list((tmp_path / "out").iterdir())


def test_one_batch_at_a_time_in_a_folder(copy):
    from lamina.addon.batch.lock import sole_owner

    before = pixels(copy / "out")
    with sole_owner(copy / "out"):
        _, said = lamina("batch", copy / "job.json", "-o", copy / "out", code=2)
    assert len(said.splitlines()) == 1 and f"another batch works there, process {os.getpid()}" in said
    assert pixels(copy / "out") == before and not (copy / "out" / ".lamina-batch").exists()


def test_a_lock_that_its_owner_just_removed_is_nobodys(tmp_path, monkeypatch):
    """Opened before the former owner removed it, locked after: a third batch may hold the new file by then."""
    from lamina.addon.batch import lock

    real = lock._lock

    def late(handle):
        (tmp_path / ".lamina-batch").unlink()
        real(handle)

    monkeypatch.setattr(lock, "_lock", late)
    with pytest.raises(LaminaError, match="another batch works there"), lock.sole_owner(tmp_path):
        pass


def test_what_fails_is_named_and_the_rest_is_done(tmp_path, blender):
    """A broken .blend, one without the object, and one that needs more memory than `ulimit -v` grants."""
    bpy = blender
    from lamina.addon.rendering.settings import add_object
    from lamina.addon.rendering.studio import build_ball_scene

    bpy.context.window.scene = build_ball_scene(None, 16, 1, name="Small").scene
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "good one.blend"))
    scene = bpy.context.scene
    scene.render.resolution_x = scene.render.resolution_y = 11_000
    scene.cycles.use_auto_tile = False  # which would keep it in memory's bounds; Blender 5 does so for its tiles all the same
    add_object(scene, "Other", bpy.data.objects["Ball"].data)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "huge.blend"))
    (tmp_path / "broken.blend").write_bytes((tmp_path / "huge.blend").read_bytes()[:3000])
    scenes = [{"blend": b, "object": o} for b, o in (("broken.blend", "Ball"), ("good one.blend", "Cup"), ("huge.blend", "Ball"), ("good one.blend", "Ball"))]
    job = write_job(tmp_path, scenes=scenes, frames="1", size=None, samples=None)
    limit = 2_500_000_000
    _, said = lamina(
        "batch", job, "-o", tmp_path / "out", "--processes", 1, "--no-sheet", code=1, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    )
    rows = {row["scene"]: row for row in table(tmp_path / "out")}
    assert {scene: row["state"] for scene, row in rows.items()} == {
        "broken_Ball": "failed",
        "good one_Cup": "failed",
        "huge_Ball": "failed",
        "good one_Ball": "done",
    }
    assert "broken.blend: Blender cannot open it" in rows["broken_Ball"]["problem"]
    assert "no object 'Cup' that takes a surface material; the nearest are Backdrop, Stand, Ball" in rows["good one_Cup"]["problem"]
    assert rows["huge_Ball"]["problem"]
    failed = [line for line in said.splitlines() if line.startswith("lamina batch: failed: ")]
    assert len(failed) == 3 and "1 of 4 pictures are done" in said
    assert all(rows[scene]["id"] in said and not (tmp_path / "out" / f"{rows[scene]['id']}.exr").exists() for scene in ("broken_Ball", "huge_Ball"))


# Answers like a worker, but hangs in the second frame.
HANGS = """
import json, sys, time
print('{"ready": true}', flush=True)
for line in sys.stdin:
    item = json.loads(line)
    if item["frame"] == 2:
        time.sleep(1000)
    open(sys.argv[1] + "/" + item["file"], "w").close()
    print(json.dumps({"id": item["id"]}), flush=True)
"""


def test_a_picture_that_hangs_is_ended_and_the_rest_is_done(tmp_path, monkeypatch):
    from lamina.addon.batch import run, worker
    from lamina.addon.batch.items import expand
    from lamina.addon.batch.job import Job
    from lamina.addon.batch.outputs import Output

    monkeypatch.setattr(worker, "command", lambda folder, threads: [sys.executable, "-c", HANGS, str(folder)])
    monkeypatch.setattr(run, "verified", lambda item, folder: Output(item, "" if (folder / item.file).exists() else "is not there", {}))
    job = Job.load(write_job(tmp_path, frames="1-4", time_limit=0.5))
    items, said = expand(job), []
    outputs = run.run_items(items, tmp_path, 1, job.time_limit, said.append)
    assert [o.problem for o in outputs] == ["", "took longer than the job's time_limit of 0.5 s", "", ""]
    assert any(f"{items[1].id} failed: took longer" in line for line in said)


# Answers like a worker that grows by 300 MB with each picture.
GROWS = """
import json, sys
open(sys.argv[1] + "/starts", "a").write(".")
print('{"ready": true}', flush=True)
for i, line in enumerate(sys.stdin):
    item = json.loads(line)
    open(sys.argv[1] + "/" + item["file"], "w").close()
    print(json.dumps({"id": item["id"], "megabytes": 1000.0 + 300.0 * i, "notices": []}), flush=True)
"""


def test_a_worker_that_grows_is_started_anew_and_that_is_told(tmp_path, monkeypatch):
    from lamina.addon.batch import run, worker
    from lamina.addon.batch.items import expand
    from lamina.addon.batch.job import Job
    from lamina.addon.batch.outputs import Output

    monkeypatch.setattr(worker, "command", lambda folder, threads: [sys.executable, "-c", GROWS, str(folder)])
    monkeypatch.setattr(run, "verified", lambda item, folder: Output(item, "" if (folder / item.file).exists() else "is not there", {}))
    items, said = expand(Job.load(write_job(tmp_path, frames="1-7"))), []
    outputs = run.run_items(items, tmp_path, 1, None, said.append)
    assert not any(o.problem for o in outputs) and (tmp_path / "starts").read_text() == "..."
    assert sum("a worker grew by 600 MB in 2 pictures, above 512 MB, and is started anew" in line for line in said) == 1  # two, told once
    assert 20.0 < worker.memory() < 20_000.0


# Answers like a worker whose .blend lacks the object Cup.
LACKS = """
import json, sys
print('{"ready": true}', flush=True)
for line in sys.stdin:
    item = json.loads(line)
    if item["scene"]["object"] == "Cup":
        print(json.dumps({"id": item["id"], "error": "no object 'Cup'", "scene": True}), flush=True)
    else:
        open(sys.argv[1] + "/" + item["file"], "w").close()
        print(json.dumps({"id": item["id"]}), flush=True)
"""


def test_a_scene_that_fails_is_tried_and_named_once(tmp_path, monkeypatch):
    from lamina.addon.batch import run, worker
    from lamina.addon.batch.items import expand
    from lamina.addon.batch.job import Job
    from lamina.addon.batch.outputs import Output

    monkeypatch.setattr(worker, "command", lambda folder, threads: [sys.executable, "-c", LACKS, str(folder)])
    monkeypatch.setattr(run, "verified", lambda item, folder: Output(item, "" if (folder / item.file).exists() else "is not there", {}))
    (tmp_path / "s.blend").write_bytes(b"")
    cup, ball = ({"blend": "s.blend", "object": name} for name in ("Cup", "Ball"))
    items, said = expand(Job.load(write_job(tmp_path, stacks=["clean_copper", "glazed_mug"], scenes=[cup, ball]))), []
    outputs = run.run_items(items, tmp_path, 1, None, said.append)
    assert [(o.problem, o.scene_failed) for o in outputs] == [("no object 'Cup'", True)] * 6 + [("", False)] * 6
    assert [line.partition(" left: ")[2] for line in said if "failed" in line] == ["6 pictures of scene s_Cup failed"]
    with pytest.raises(LaminaError, match="^no object 'Cup'$"):
        run.run_items(items[:6], tmp_path, 1, None, said.append)


def test_a_scene_without_cycles_is_bad_input(tmp_path, blender):
    blender.context.scene.camera = blender.data.objects.new("Camera", blender.data.cameras.new("Camera"))
    blender.context.scene.collection.objects.link(blender.context.scene.camera)
    blender.context.scene.collection.objects.link(blender.data.objects.new("Cup", blender.data.meshes.new("Cup")))
    blender.context.scene.render.engine = "BLENDER_WORKBENCH"
    blender.ops.wm.save_as_mainfile(filepath=str(tmp_path / "s.blend"))
    job = write_job(tmp_path, stacks=["clean_copper", "glazed_mug"], scenes=[{"blend": "s.blend", "object": "Cup"}])
    _, said = lamina("batch", job, "-o", tmp_path / "out", "--processes", 1, code=2)
    assert said.count("renders with BLENDER_WORKBENCH; choose Cycles") == 1
    assert "6 pictures of scene s_Cup failed" in said and not list((tmp_path / "out").iterdir())


def test_each_object_of_one_file_is_shown_in_its_turn(tmp_path, blender):
    from lamina.addon.batch.items import expand
    from lamina.addon.batch.job import Job
    from lamina.addon.batch.scene import Stage
    from lamina.addon.rendering.settings import add_object
    from lamina.addon.rendering.studio import build_ball_scene

    blender.context.window.scene = build_ball_scene(None, 16, 1, name="Two").scene
    add_object(blender.context.scene, "Other", blender.data.objects["Ball"].data.copy())
    blender.ops.wm.save_as_mainfile(filepath=str(tmp_path / "s.blend"))
    stage, shown = Stage(), []
    for item in expand(Job.load(write_job(tmp_path, frames=1, scenes=[{"blend": "s.blend", "object": name} for name in ("Ball", "Other")]))):
        stage.show(item)
        shown.append((stage.target.name, stage.target.material_slots[0].material.name, stage.scene.objects["Ball"].material_slots[0].material))
    assert [name for name, _, _ in shown] == ["Ball", "Other"] and shown[1][1] == "clean_copper" and shown[1][2] is None


def test_processes_share_no_material_while_there_are_others(tmp_path):
    from lamina.addon.batch.items import expand
    from lamina.addon.batch.job import Job
    from lamina.addon.batch.run import _Left

    items = expand(Job.load(write_job(tmp_path, stacks=["clean_copper", "glazed_mug", "frosted_metal"], frames="1-2")))
    left = _Left(items)
    first, second = left.take(None), left.take(None)
    taken = [first, second, left.take(first), left.take(second), left.take(second), left.take(first)]
    assert [item.look for item in taken] == ["clean_copper", "glazed_mug", "clean_copper", "glazed_mug", "frosted_metal", "frosted_metal"]
    assert left.take(first) is None and {item.id for item in taken} == {item.id for item in items}


def test_bad_jobs_are_code_2_and_leave_nothing(tmp_path):
    for keys, words in (({"stack": []}, "unknown key 'stack'"), ({"backend": "cuda"}, "unknown backend 'cuda'")):
        _, said = lamina("batch", write_job(tmp_path, **keys), "-o", tmp_path / "out", code=2)
        assert len(said.splitlines()) == 1 and words in said and not (tmp_path / "out").exists()
    _, said = lamina("batch", write_job(tmp_path), "-o", "/proc/none", code=2)
    assert "/proc/none: cannot make this folder" in said
    keys, _ = lamina("batch", "--keys")
    assert all(key in keys for key in JOB)


def test_cells_hold_whole_pictures_of_any_shape():
    from lamina.addon.batch.outputs import fitted

    picture = np.zeros((10, 30, 3))
    picture[:, 15:] = 0.5
    for side, high in ((6, 2), (60, 20), (90, 30)):
        cell = fitted(picture, side)
        assert cell.shape == (high, side, 3) and np.all(cell[:, : side // 2] == 0.0) and np.allclose(cell[:, side // 2 :], 0.5)
    assert np.all(fitted(np.full((4, 4, 3), np.nan), 8) == 0) and fitted(np.ones((2, 16_000, 3)), 192).shape == (1, 192, 3)


def test_the_sheet_shows_what_render_shows(blender, tmp_path):
    """The same light through the scene's own view transform, which is not sRGB's curve alone."""
    from lamina.addon.batch.task import view_of
    from lamina.addon.blender import images
    from lamina.addon.rendering import settings, view
    from lamina.addon.rendering.studio import build_ball_scene

    studio = build_ball_scene(None, (24, 16), 4)
    pictures = {}
    for transform in ("Khronos PBR Neutral", "AgX"):
        studio.scene.view_settings.view_transform, studio.scene.view_settings.exposure = transform, 1.0
        settings.render_to(studio.scene, tmp_path / "a.png")
        pictures[transform] = images.read_png(tmp_path / "a.png")[0].astype(int)
        shown = view_of(studio.scene)
        studio.scene.render.image_settings.file_format, studio.scene.render.image_settings.color_depth = "OPEN_EXR", "32"
        settings.render_to(studio.scene, tmp_path / "a.exr")
        studio.scene.render.image_settings.file_format, studio.scene.render.image_settings.color_depth = "PNG", "8"
        channels = images.read_exr(tmp_path / "a.exr").channels
        told = view.displayed(np.stack([channels[c] for c in "RGB"], axis=-1), shown, pytest.fail)
        assert np.abs(told.astype(int) - pictures[transform]).max() <= 1
    studio.remove()
    assert np.abs(pictures["AgX"] - pictures["Khronos PBR Neutral"]).max() > 20
    said = []
    view.displayed(np.ones((2, 2, 3)), {"view_transform": "ACES 7"}, said.append)
    assert said == ["this Blender has no view transform 'ACES 7'; shown with 'Khronos PBR Neutral' instead"]
