# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene with libraries, sequences, tiles and shared meshes through batch, farm and apply: nothing is wrong in silence."""

import contextlib
import io
import json
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from support import commands, production_scene, wheel_blender

pytest.importorskip("bpy")

pytestmark = pytest.mark.blender

JOB = {"stacks": ["clean_copper"], "qualities": ["weidlich_wilkie"], "size": 16, "samples": 1}
READ = {  # what a changed one of these makes of a picture: another one, or the same
    production_scene.LIBRARY: True, production_scene.PARTS: True, "tex/lid.png": True, production_scene.PICTURE: True,
    "tex/tiles.1002.png": True, "tex/dirt_0002.png": True, production_scene.FONT: True, production_scene.SOUND: False,
}  # fmt: skip


def lamina(*arguments, code: int = 0) -> tuple[str, str]:
    """What a command says, in this process, as a Blender's start costs more than most; the pictures of a batch have processes of their own."""
    from lamina.addon.cli.main import run

    with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.redirect_stderr(io.StringIO()) as said:
        assert run([str(word) for word in arguments]) == code, said.getvalue()
    return out.getvalue(), said.getvalue()


@pytest.fixture(scope="module")
def built(tmp_path_factory, registered_lamina) -> Path:
    folder = tmp_path_factory.mktemp("production") / "Größe & Lack, 漆"
    production_scene.build(folder, backend="nodes", osl=False)
    return folder


@pytest.fixture
def scene(built, tmp_path) -> Path:
    """A copy of the scene's folder, with a job file."""
    home = tmp_path / "Küche 漆"
    shutil.copytree(built, home)
    write_job(home)
    return home


def write_job(home: Path, target: str = production_scene.CUP, **keys) -> Path:
    (home / "job.json").write_text(json.dumps(JOB | {"scenes": [{"blend": production_scene.SCENE, "object": target}]} | keys))
    return home / "job.json"


def test_the_scene_is_what_it_says(built, blender):
    blender.ops.wm.open_mainfile(filepath=str(built / production_scene.SCENE))
    materials = [m for m in blender.data.materials if m.lamina.is_layered]
    assert len(blender.context.scene.objects) == production_scene.OBJECTS and len(blender.data.materials) == production_scene.MATERIALS
    assert len(materials) == production_scene.LAMINA
    assert sum(any(n.bl_idname == "ShaderNodeTexImage" for n in m.node_tree.nodes) for m in materials) == production_scene.TEXTURED
    assert sum(f.stat().st_size for f in built.rglob("*") if f.suffix != ".blend1") < 2e6


def test_a_picture_depends_on_every_file_that_a_render_reads(scene, registered_lamina):
    from lamina.addon.batch import reads
    from lamina.addon.batch.items import expand
    from lamina.addon.batch.job import Job

    items = expand(Job.load(scene / "job.json"))
    found = reads.reads_of(items)
    (read,) = found.values()
    assert {Path(f).relative_to(scene).as_posix() for f in read.files} == {name for name, is_read in READ.items() if is_read} | {
        "tex/tiles.1001.png", production_scene.SEQUENCE}  # fmt: skip
    assert not read.missing

    def inputs():
        return reads.with_reads(items, found, pytest.fail)[0].inputs

    before = inputs()
    for name, is_read in READ.items():
        path = scene / name
        content = path.read_bytes()
        path.write_bytes(content[:-1] + b"\1")
        assert (inputs() != before) == is_read, name
        path.write_bytes(content)
        assert inputs() == before


def test_large_files_count_by_size_and_time_and_are_named(tmp_path, registered_lamina, monkeypatch):
    from lamina.addon.batch import reads
    from lamina.addon.batch.items import expand
    from lamina.addon.batch.job import Job

    (tmp_path / "s.blend").write_bytes(b"")
    large = tmp_path / "Wolke 雲.vdb"
    large.write_bytes(b"0" * 2000)
    (tmp_path / "job.json").write_text(json.dumps(JOB | {"scenes": [{"blend": "s.blend", "object": "Cup"}]}))
    items, said = expand(Job.load(tmp_path / "job.json")), []
    found = {items[0].blend: reads.Reads((str(large),), ())}
    small = reads.with_reads(items, found, said.append)[0].inputs
    monkeypatch.setattr(reads, "LARGE", 1000)
    by_time = reads.with_reads(items, found, said.append)[0].inputs
    assert small != by_time and len(said) == 1 and "1 of 1 files" in said[0] and "count by size and time: Wolke 雲.vdb" in said[0]
    about = large.stat()
    large.write_bytes(b"1" * 2000)
    os.utime(large, ns=(about.st_atime_ns, about.st_mtime_ns))
    assert reads.with_reads(items, found, said.append)[0].inputs == by_time
    os.utime(large, ns=(about.st_atime_ns, about.st_mtime_ns + 1))
    assert reads.with_reads(items, found, said.append)[0].inputs != by_time


def test_what_else_a_render_reads(blender, tmp_path):
    """Caches, volumes, an external OSL script; not texts, nor what is packed; a sequence of volumes with its frames."""
    from lamina.addon.blender.dependencies import files_read

    bpy = blender
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "s.blend"))
    for name in ("v_0001.vdb", "v_0002.vdb", "v_no.vdb", "own.osl", "t.py", "blendcache_s/a/1.bphys", "fluid/data/1.vdb", "baked/1/2.json", "cache.abc"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes(b"x")
    volume = bpy.data.volumes.new("v")
    volume.filepath, volume.is_sequence = "//v_0001.vdb", True
    item = bpy.data.objects.new("o", bpy.data.meshes.new("m"))
    bpy.context.scene.collection.objects.link(item)
    fluid = item.modifiers.new("f", "FLUID")
    fluid.fluid_type = "DOMAIN"
    fluid.domain_settings.cache_directory = "//fluid"
    item.modifiers.new("n", "NODES").bake_directory = "//baked"
    material = bpy.data.materials.new("m")
    from lamina.addon.blender.versions import node_tree

    script = node_tree(material).nodes.new("ShaderNodeScript")
    script.mode, script.filepath = "EXTERNAL", "//own.osl"
    bpy.data.texts.new("t").filepath = "//t.py"
    packed = bpy.data.images.new("packed", 4, 4)
    packed.pack()
    packed.filepath = "//packed.png"
    assert [Path(f).relative_to(tmp_path).as_posix() for f in files_read()] == sorted(
        ["v_0001.vdb", "v_0002.vdb", "own.osl", "blendcache_s/a/1.bphys", "fluid/data/1.vdb", "baked/1/2.json"])  # fmt: skip


@pytest.mark.parametrize(
    "start, duration, offset, cyclic, lost",
    [
        (1, 5, 0, False, {1: None, 2: 2, 3: None, 4: 4, 9: None}),
        (3, 3, 2, False, {1: 2, 3: None, 4: 4, 5: None}),
        (1, 2, 1, True, {1: 2, 2: None, 3: 2, 4: None}),
    ],
)
def test_a_sequence_lacks_the_pictures_of_its_frames(blender, tmp_path, start, duration, offset, cyclic, lost):
    """A gap within a sequence was no missing file, and its frame was rendered pink. Numbers as Cycles shows them, by pictures of one value each."""
    from lamina.addon.blender.dependencies import missing
    from lamina.addon.blender.versions import node_tree

    bpy = blender
    for i in (1, 3, 5):
        production_scene.write_picture(tmp_path / f"dirt {i:03}.png", i)
    node = node_tree(bpy.data.materials.new("m")).nodes.new("ShaderNodeTexImage")
    node.image = bpy.data.images.load(str(tmp_path / "dirt 001.png"))
    node.image.source = "SEQUENCE"
    user = node.image_user
    user.frame_start, user.frame_duration, user.frame_offset, user.use_cyclic, user.use_auto_refresh = start, duration, offset, cyclic, True
    assert missing() == []
    for frame, number in lost.items():
        assert missing([frame]) == ([] if number is None else [f"{tmp_path / f'dirt {number:03}.png'} is not there"]), frame


@pytest.mark.parametrize(
    "name", ["shot_0001.jp2", "shot_0001.png", "shot.v1.png", "v1_0001b.jp2", "a.0001.b.jp2", "shot_001..jp2", "0001", ".0001", "shot0001."]
)
def test_a_sequences_number_is_before_the_ending_as_blender_has_it(blender, tmp_path, name):
    from lamina.addon.blender.dependencies import files_read, frame_file
    from lamina.addon.blender.versions import node_tree

    node = node_tree(blender.data.materials.new("m")).nodes.new("ShaderNodeTexImage")
    node.image = image = blender.data.images.new("i", 4, 4)
    image.source, image.filepath = "SEQUENCE", str(tmp_path / name)
    node.image_user.frame_duration = 2
    pair = [tmp_path / name, Path(frame_file(image, node.image_user, 2))]
    assert pair[1].name == name[: (at := name.rindex("1"))] + "2" + name[at + 1 :] and frame_file(image, node.image_user, 1) == str(pair[0])
    assert frame_file(image, node.image_user, 0) == image.filepath_from_user(image_user=node.image_user)
    for path in pair:
        path.write_bytes(b"x")
    (tmp_path / "shot_0001.jp3").write_bytes(b"x")
    assert files_read() == sorted(map(str, pair))


@pytest.mark.parametrize("name", ["shot.jp2", "shot.0001"])
def test_a_number_in_the_ending_is_that_of_no_frame(blender, tmp_path, name):
    from lamina.addon.blender.dependencies import files_read, frame_file
    from lamina.addon.blender.versions import node_tree

    node = node_tree(blender.data.materials.new("m")).nodes.new("ShaderNodeTexImage")
    node.image = image = blender.data.images.new("i", 4, 4)
    image.source, image.filepath = "SEQUENCE", str(tmp_path / name)
    assert frame_file(image, node.image_user, 7) == image.filepath_from_user(image_user=node.image_user) == str(tmp_path / name)
    assert files_read() == [str(tmp_path / name)]


def test_changed_files_are_noticed_and_missing_ones_refused(scene):
    """The whole way: a batch, a changed library; then one that is gone; then a loop of libraries and a folder in place of a file."""
    arguments = ("batch", scene / "job.json", "-o", scene / "out", "--no-sheet")
    lamina(*arguments)
    _, said = lamina(*arguments)
    assert "1 of them are there and whole" in said
    picture = scene / production_scene.PICTURE
    picture.write_bytes(picture.read_bytes() + b"\0")
    _, said = lamina(*arguments, code=2)
    assert "1 pictures of other inputs" in said.splitlines()[-1]
    picture.unlink()
    picture.mkdir()
    (scene / production_scene.LIBRARY).unlink()
    before = {f.name: f.read_bytes() for f in (scene / "out").iterdir()}
    _, said = lamina(*arguments, code=2)
    assert len(said.splitlines()) == 1 and "lib/set.blend is not there; " in said and "wood 漆.png is a folder and no file; mend that" in said
    assert {f.name: f.read_bytes() for f in (scene / "out").iterdir()} == before
    for command in ("apply", "farm"):
        given = (
            (scene / production_scene.SCENE, "--stack", "clean_copper", "--object", "Cup", "--tier", "weidlich_wilkie")
            if command == "apply"
            else (scene / "job.json",)
        )
        _, said = lamina(command, *given, "-o", scene / "new.blend", code=2)
        assert "lib/set.blend is not there" in said.splitlines()[-1] and not (scene / "new.blend").exists()
    _, said = lamina(*arguments, "--allow-missing", "--replace")
    assert "goes on without what is missing" in said and "1 of 1 pictures are done" in said


def task(blender_program: str, bundle: Path, out: Path, pictures: str = "0") -> subprocess.CompletedProcess:
    files = bundle / "files"
    command = [blender_program, "-b", "--python", files / "render_items.py", "--", "--items", files / "items.json", "--range", pictures, "--output", out]
    return subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=300)


def test_a_bundle_has_all_that_its_scene_reads_along(scene, tmp_path):
    """Copied elsewhere, with the scene gone: the same pixels as the batch's own; without one of its files its task fails and says so."""
    program = wheel_blender.blender_program(tmp_path)
    _, said = lamina("farm", scene / "job.json", "-o", scene / "bundle")
    assert "copied 9 files that the scenes read, 0." in said
    lamina("batch", scene / "job.json", "-o", tmp_path / "here", "--no-sheet")
    shutil.copytree(scene / "bundle", tmp_path / "elsewhere 漆")
    scene.rename(tmp_path / "gone")
    ran = task(program, tmp_path / "elsewhere 漆", tmp_path / "farmed")
    assert ran.returncode == 0, ran.stdout + ran.stderr
    (tmp_path / "gone").rename(scene)
    _, said = lamina("batch", scene / "job.json", "-o", tmp_path / "farmed", "--no-sheet")
    assert "1 of them are there and whole" in said
    assert _pixels(tmp_path / "farmed") == _pixels(tmp_path / "here")
    next((tmp_path / "elsewhere 漆").rglob("lid.png")).unlink()
    scene.rename(tmp_path / "gone")
    ran = task(program, tmp_path / "elsewhere 漆", tmp_path / "again")
    assert ran.returncode == 1 and "lid.png is not there" in ran.stdout and not list((tmp_path / "again").iterdir())


def _pixels(folder: Path) -> dict[str, bytes]:
    """Those of each picture, by its name."""
    from lamina.addon.blender import oiio

    def bytes_of(picture):
        channels, _ = oiio.read(picture)
        return np.stack([channels[c] for c in "RGB"]).tobytes()

    return {picture.name: bytes_of(picture) for picture in folder.glob("*.exr")}


def test_batch_and_farm_take_linked_objects_as_they_are(scene, tmp_path):
    """An object of the library's and one whose mesh is; beside one of the scene's own."""
    targets = (production_scene.LINKED, production_scene.HALF, production_scene.CUP)
    job = write_job(scene, scenes=[{"blend": production_scene.SCENE, "object": target, "name": target} for target in targets])
    before = {f: f.read_bytes() for f in scene.rglob("*.blend")}
    lamina("farm", job, "-o", tmp_path / "bundle")
    lamina("batch", job, "-o", tmp_path / "here", "--no-sheet", "--processes", 1)
    ran = task(wheel_blender.blender_program(tmp_path), tmp_path / "bundle", tmp_path / "farmed", "0-1")
    assert ran.returncode == 0, ran.stdout + ran.stderr
    here, farmed = _pixels(tmp_path / "here"), _pixels(tmp_path / "farmed")
    assert len(farmed) == 2 and farmed.items() <= here.items()
    assert len(set(here.values())) == len(here) == 3
    assert all(f.read_bytes() == content for f, content in before.items())


def apply(scene: Path, target: str, *options, code: int = 0) -> str:
    """What `lamina apply` says."""
    given = ("--stack", "clean_copper", "--tier", "weidlich_wilkie", "--backend", "nodes", "--object", target, "-o", scene / "new.blend")
    return lamina("apply", scene / production_scene.SCENE, *given, *options, code=code)[1]


def slots_in(bpy, path: Path) -> dict[str, list[tuple[str, str]]]:
    bpy.ops.wm.open_mainfile(filepath=str(path))
    return {o.name: [(s.link, s.name) for s in o.material_slots] for o in bpy.data.objects if hasattr(o.data, "materials")}


def test_apply_offers_only_what_it_can_change(scene, blender):
    said = apply(scene, production_scene.LINKED, code=2)
    assert "object Linked Cup is the library //../lib/set.blend's" in said and "make it local, or make a library override of the object and its mesh" in said
    said = apply(scene, production_scene.HALF, code=2)
    assert "the mesh Linked Cup of object Half Cup is the library //../lib/set.blend's" in said and "--object-level or --single-user" in said
    assert not (scene / "new.blend").exists()
    (before,) = slots_in(blender, scene / production_scene.SCENE)[production_scene.HALF]
    apply(scene, production_scene.HALF, "--object-level")
    (after,) = slots_in(blender, scene / "new.blend")[production_scene.HALF]
    assert (before, after) == (("DATA", "Linked"), ("OBJECT", "Clean Copper"))
    apply(scene, production_scene.HALF, "--single-user")
    found = slots_in(blender, scene / "new.blend")
    assert found[production_scene.HALF] == [("DATA", "Clean Copper")] and found[production_scene.LINKED] == [("DATA", "Linked")]


def test_a_shared_mesh_is_told_and_can_be_left_alone(scene, blender):
    said = apply(scene, production_scene.TWIN)
    assert "Twin B share the mesh" in said and "--single-user or --object-level gives it to Twin A alone" in said
    found = slots_in(blender, scene / "new.blend")
    assert found["Twin A"] == found["Twin B"] == [("DATA", "Clean Copper")]
    for option, link in (("--single-user", "DATA"), ("--object-level", "OBJECT")):
        said = apply(scene, production_scene.TWIN, option)
        found = slots_in(blender, scene / "new.blend")
        assert "share the mesh" not in said and found["Twin A"] == [(link, "Clean Copper")] and found["Twin B"][0][1] != "Clean Copper"


def test_a_slot_is_named_numbered_or_all(scene, blender):
    blender.ops.wm.open_mainfile(filepath=str(scene / production_scene.SCENE))
    mesh = blender.data.objects[production_scene.CUP].data
    for name in ("Lid 漆", "1"):
        mesh.materials.append(blender.data.materials.new(name))
    blender.ops.wm.save_mainfile()
    first = mesh.materials[0].name
    for wanted, changed in ((None, [0]), ("Lid 漆", [1]), ("1", [2]), ("0", [0]), ("all", [0, 1, 2])):
        apply(scene, production_scene.CUP, *(("--slot", wanted) if wanted else ()))
        names = [name for _, name in slots_in(blender, scene / "new.blend")[production_scene.CUP]]
        assert names == ["Clean Copper" if i in changed else name for i, name in enumerate((first, "Lid 漆", "1"))], wanted
    said = apply(scene, production_scene.CUP, "--slot", "3", code=2)
    assert f"object Cup has no slot '3'; choose all, or one of 0 ({first}), 1 (Lid 漆), 2 (1)" in said


def test_a_wrong_name_gets_the_nearest_five_once(scene, tmp_path, registered_lamina):
    said = apply(scene, "prop 07", code=2)
    told = said.strip().splitlines()[-1].partition("the nearest are ")[2].split(", ")
    assert len(told) == 5 and all(name.startswith("Prop ") for name in told)
    _, said = lamina("batch", write_job(scene, "Cub"), "-o", tmp_path / "out", code=2)
    assert said.count("no object 'Cub'") == 1 and "the nearest are Cup, " in said


def test_a_header_says_where_its_picture_comes_from(scene, tmp_path):
    """And `lamina info` prints it, and sees pixels that changed since."""
    import hashlib

    from lamina.addon.blender import oiio

    lamina("batch", write_job(scene, name="Küche"), "-o", tmp_path / "out", "--no-sheet")
    (picture,) = (tmp_path / "out").glob("*.exr")
    said, _ = lamina("info", picture)
    told = dict(line.split(": ", 1) for line in said.splitlines())
    digest = hashlib.sha256((scene / production_scene.SCENE).read_bytes()).hexdigest()
    expected = {
        "object": "Cup", "scene": "Scene", "blend": f"{production_scene.SCENE} sha256 {digest}", "view_deg": "0", "frame": "1", "backend": "auto",
        "size": "16 x 16", "job": "Küche, 1 picture",
    }  # fmt: skip
    assert {name: told[f"lamina:{name}"] for name in expected} == expected and told["lamina:device"].startswith("CPU, with")
    assert told["Camera"] == "Camera" and told["RenderTime"] and told["pixels"] == "as they were written"
    assert "Lamina" in told["Note"] and len(told["Note"].encode()) <= 511
    assert json.loads(lamina("info", picture, "--json")[0]) == told
    channels, texts = oiio.read(picture)
    channels["G"][0, 0] += 1.0
    oiio.write(picture, channels, texts)
    assert "pixels: NOT those that were written" in lamina("info", picture)[0]
    for bad in (tmp_path, tmp_path / "none.exr", scene / production_scene.SCENE):
        _, said = lamina("info", bad, code=2)
        assert len(said.splitlines()) == 1 and bad.name in said


def test_a_stamp_has_what_fits_and_the_scene_gets_its_own_back(blender, tmp_path):
    from lamina.addon.blender.images import read_exr
    from lamina.addon.jobs import stamp_note
    from lamina.addon.material.material import apply_stack
    from lamina.addon.rendering.settings import render_to
    from lamina.addon.rendering.studio import build_ball_scene
    from lamina.reference_py.material import presets

    made = blender.data.materials.new("Kupfer 銅")
    apply_stack(made, presets.load("clean_copper"), "weidlich_wilkie", "nodes")
    studio = build_ball_scene(made, 8, 1)
    render = studio.scene.render
    render.image_settings.file_format = "OPEN_EXR"
    for own in ((False, "former"), (True, "mine")):
        render.use_stamp_note, render.stamp_note_text = own
        render_to(studio.scene, tmp_path / "a.exr")
        note = read_exr(tmp_path / "a.exr").metadata["Note"]
        assert note.startswith("mine; Lamina " if own[0] else "Lamina ") and "Kupfer 銅: weidlich_wilkie, error " in note
        assert (render.use_stamp_note, render.stamp_note_text) == own
    render.use_stamp_note, render.stamp_note_text = True, "x" * 505
    render_to(studio.scene, tmp_path / "a.exr")
    assert read_exr(tmp_path / "a.exr").metadata["Note"] == "x" * 505
    render.stamp_note_text = "é" * 383  # which 4.5 cuts within a character
    render_to(studio.scene, tmp_path / "a.exr")
    assert set("RGB") <= set(read_exr(tmp_path / "a.exr").channels)
    many = [made] * 40
    note = stamp_note.note_of(many)
    assert len(note.encode()) <= stamp_note.LONGEST and note.endswith(" more") and note.count("Kupfer") + int(note.split()[-2]) == 40
    made.lamina.base.node = ""
    render.use_stamp_note = False
    render_to(studio.scene, tmp_path / "a.exr")
    assert "Note" not in read_exr(tmp_path / "a.exr").metadata
    studio.remove()


def test_osl_alone_in_an_instanced_collection_is_seen_by_a_worker_without_osl(blender, monkeypatch):
    """And told before a missing OpenImageIO, which is told before the render."""
    import sys

    import _cycles

    from lamina.addon.batch import task
    from lamina.addon.material.material import apply_stack
    from lamina.addon.rendering.studio import build_ball_scene
    from lamina.reference_py.material import presets

    studio = build_ball_scene(None, 8, 1)
    made = blender.data.materials.new("Alone")
    apply_stack(made, presets.load("clean_copper"), "analytic", "osl")
    hidden = blender.data.objects.new("Hidden", blender.data.meshes.new("Hidden"))
    hidden.data.materials.append(made)
    inner, outer = (blender.data.collections.new(name) for name in ("inner", "outer"))
    inner.objects.link(hidden)
    for holder, shown in ((outer.objects, inner), (studio.scene.collection.objects, outer)):
        empty = blender.data.objects.new("Empty", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", shown
        holder.link(empty)
    item = {"frame": 1, "seed": 1, "samples": 1, "size": [8, 8], "view": 0.0, "file": "a.exr", "inputs": "i"}
    monkeypatch.setattr(_cycles, "with_osl", False)
    monkeypatch.setitem(sys.modules, "OpenImageIO", None)
    with pytest.raises(RuntimeError, match="the material Alone is an OSL script alone"):
        task.render_item(studio.scene, studio.ball, item, {}, Path("none"))
    monkeypatch.setattr(_cycles, "with_osl", True)
    with pytest.raises(ImportError, match="cannot import OpenImageIO"):
        task.render_item(studio.scene, studio.ball, item, {}, Path("none"))
    assert task.problem(Path("none.exr"), "i")[0] == "is not there"
    studio.remove()


def test_a_full_disk_is_told_with_what_was_needed(tmp_path, monkeypatch, registered_lamina):
    from collections import namedtuple

    from lamina.addon.batch import run, task
    from lamina.addon.batch.items import expand
    from lamina.addon.batch.job import Job
    from lamina.reference_py.errors import LaminaError

    free = namedtuple("usage", "free")
    (tmp_path / "job.json").write_text(json.dumps(JOB | {"size": 1000, "frames": "1-3"}))
    items, said = expand(Job.load(tmp_path / "job.json")), []
    monkeypatch.setattr(shutil, "disk_usage", lambda _: free(2_000_000))
    with pytest.raises(LaminaError, match="3 pictures take up to 48.0 MB, 16.00 MB each, and 2.00 MB are free"):
        run.run_items(items, tmp_path, 1, None, said.append)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: free(20_000_000))
    run._require_space(items, tmp_path, said.append)
    assert "48.0 MB" in said[-1]
    monkeypatch.setattr(shutil, "disk_usage", lambda _: free(10))
    monkeypatch.setattr(task.oiio, "write", lambda *_: (_ for _ in ()).throw(OSError("no words")))
    with pytest.raises(OSError, match="the disk is full: a picture takes up to 0.00 MB"):
        task._write(tmp_path / "a.exr", {"R": np.ones((4, 4), np.float32)}, {})
    assert [f.name for f in tmp_path.iterdir()] == ["job.json"]


def test_an_unwritable_cache_is_told_once(tmp_path):
    (tmp_path / "file").write_text("")
    environment = os.environ | {"LAMINA_CACHE": str(tmp_path / "file" / "bakes")}
    (tmp_path / "job.json").write_text(json.dumps(JOB))
    for arguments in (
        ("batch", "job.json", "-o", "out", "--no-sheet"),
        ("render", "clean_copper", "--scene", "sphere", "--size", 8, "--samples", 1, "-o", "a.exr"),
    ):
        _, said = commands.lamina(*arguments, cwd=tmp_path, env=environment)
        assert said.count("what is baked cannot be kept in") == 1


def later(path: Path) -> None:
    """Make an uncompressed .blend one of a later Blender, by its header."""
    import re

    data = path.read_bytes()
    path.write_bytes(re.sub(rb"^(BLENDER.{1,5}?v\d+)\d\d", rb"\g<1>09", data[:20], count=1) + data[20:])


def test_a_blend_of_a_later_version_is_refused(blender, scene):
    """The scene's own, and a library's."""
    for name in (production_scene.SCENE, production_scene.LIBRARY):
        path = scene / name
        before = path.read_bytes()
        blender.ops.wm.open_mainfile(filepath=str(path))
        blender.ops.wm.save_mainfile(compress=False)
        later(path)
        said = apply(scene, production_scene.CUP, code=2).strip().splitlines()[-1]
        assert f"{path.name} was written by Blender " in said and ", later than this " in said and not (scene / "new.blend").exists()
        path.write_bytes(before)


def test_a_loop_of_libraries_ends(blender, scene):
    """Two that link to each other: Blender copes, and so does the list of what is read."""
    from lamina.addon.blender.dependencies import files_read, missing

    blender.ops.wm.open_mainfile(filepath=str(scene / production_scene.PARTS))
    with blender.data.libraries.load(str(scene / production_scene.LIBRARY), link=True, relative=True) as (_, chosen):
        chosen.objects = [production_scene.LINKED]
    blender.context.scene.collection.objects.link(chosen.objects[0])
    blender.data.objects["Lid"].parent = chosen.objects[0]
    blender.ops.wm.save_mainfile()
    blender.ops.wm.open_mainfile(filepath=str(scene / production_scene.SCENE))
    assert len(files_read()) == 9 and not missing()


def test_a_library_that_names_another_absolutely_cannot_be_bundled(blender, scene):
    """In the bundle it would go on reading the file outside, which a farm may not have."""
    blender.ops.wm.open_mainfile(filepath=str(scene / production_scene.LIBRARY))
    blender.ops.file.make_paths_absolute()
    blender.ops.wm.save_mainfile()
    _, said = lamina("farm", scene / "job.json", "-o", scene / "bundle", code=2)
    assert "by an absolute path cannot be taken along" in said and "lib/parts.blend" in said and "make the paths of that library relative" in said
    assert not (scene / "bundle").exists() and not list(scene.glob(".lamina*"))


def test_what_a_library_lacks_is_one_line(scene, tmp_path):
    (scene / production_scene.LIBRARY).write_bytes(b"no blend")
    _, said = lamina("batch", scene / "job.json", "-o", tmp_path / "out", "--no-sheet", code=2)
    assert len(said.splitlines()) == 1 and "object Linked Cup of " in said and not list(tmp_path.rglob("*.exr"))
