# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders items of a batch from scenes that are ready, each to a whole EXR with its origin in the header, or to none.

Also a script for farms, where Lamina is not installed: a copy of this file, with `oiio.py` and `dependencies.py` beside it, runs as

    blender -b SCENE.blend --python render_items.py -- --items items.json --range 0-9 --output FOLDER
"""

import contextlib
import hashlib
import importlib.util
import json
import os
import shutil
import sys
import tempfile
import threading
import time
from pathlib import Path

import bpy
from mathutils import Matrix

WITH_CAMERA = "lamina_with_camera"
OTHER_INPUTS = "is of other inputs"

if __package__:
    from ..blender import dependencies, oiio
else:

    def _beside(name: str):
        spec = importlib.util.spec_from_file_location(name, Path(__file__).with_name(f"{name}.py"))
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module

    dependencies, oiio = _beside("dependencies"), _beside("oiio")


def render_item(scene: bpy.types.Scene, target: bpy.types.Object, item: dict, texts: dict[str, str], folder: Path) -> None:
    """Render one item, its material already on `target`, into `folder`.

    `item` has file, view, frame, seed, samples and size (None: the scene's own), as `Item.to_dict` gives them; `texts`
    go into the header. Raises OSError, ValueError or RuntimeError, and then no file was written or changed.
    """
    started = time.monotonic()
    _set_up(scene, item)
    _require_osl(scene)
    oiio.module()  # whatever is missing is told before the render
    with _camera_around(scene, target, item["view"]), tempfile.TemporaryDirectory() as work:
        picture = Path(work, "picture.exr")
        scene.render.filepath = str(picture)
        bpy.ops.render.render(write_still=True, scene=scene.name)
        if not picture.is_file():  # render() says FINISHED even then
            raise RuntimeError("Blender wrote no picture")
        channels, stamps = oiio.read(picture)
    channels = {name: channels[name] for name in "RGBA"}
    height, width = channels["R"].shape
    texts = (
        stamps
        | texts
        | {
            "lamina:scene": scene.name,
            "lamina:object": target.name,
            "lamina:view_deg": f"{item['view']:g}",
            "lamina:frame": str(item["frame"]),
            "lamina:size": f"{width} x {height}",
            "lamina:device": device_of(scene),
            "lamina:inputs": item["inputs"],
            "lamina:pixels": pixel_hash(channels),
            "lamina:blender": bpy.app.version_string,
            "lamina:samples": str(scene.cycles.samples),
            "lamina:seed": str(item["seed"]),
            "lamina:seconds": f"{time.monotonic() - started:.2f}",
            "lamina:view": json.dumps(view_of(scene)),
        }
    )
    _write(folder / item["file"], channels, texts)


def device_of(scene) -> str:
    """What renders, and whether it reads OSL scripts."""
    import _cycles

    cycles = bpy.context.preferences.addons.get("cycles")
    kind = cycles.preferences.compute_device_type if cycles else "NONE"
    device = f"GPU {kind}" if scene.cycles.device == "GPU" and kind != "NONE" else "CPU"
    return f"{device}, {'with' if _cycles.with_osl and scene.cycles.shading_system and device in ('CPU', 'GPU OPTIX') else 'without'} OSL"


def view_of(scene) -> dict:
    """How the scene shows linear light, which an EXR does not hold: for contact sheets."""
    view = scene.view_settings
    return {
        "display_device": scene.display_settings.display_device,
        "view_transform": view.view_transform,
        "look": view.look,
        "exposure": view.exposure,
        "gamma": view.gamma,
    }


def pixel_hash(channels: dict) -> str:
    """Of the values as float32, channel after channel."""
    digest = hashlib.sha256()
    for name in "RGBA":
        digest.update(channels[name].astype("<f4").tobytes())
    return digest.hexdigest()


def _require_osl(scene) -> None:
    """A Blender without OSL renders a script that has no stock nodes beside it as nothing and says nothing."""
    import _cycles

    if _cycles.with_osl:
        return
    for material in {slot.material for thing in dependencies.shown_objects(scene) for slot in thing.material_slots}:
        nodes = material.node_tree.nodes if material is not None and material.node_tree else ()
        if any(node.bl_idname == "ShaderNodeScript" and {s.name for s in node.outputs if s.is_linked} == {"BSDF"} for node in nodes):
            raise RuntimeError(
                f"the material {material.name} is an OSL script alone, and this Blender was built without OSL; give the job the backend auto or nodes"
            )


def _set_up(scene, item: dict) -> None:
    if scene.render.engine != "CYCLES":
        raise RuntimeError(f"the scene {scene.name} renders with {scene.render.engine}, not with Cycles")
    scene.frame_set(item["frame"])
    scene.render.use_persistent_data = True  # a shader's start in Cycles takes seconds
    scene.cycles.seed, scene.cycles.use_animated_seed = item["seed"], False
    if item["samples"]:
        scene.cycles.samples = item["samples"]
    if item["size"]:
        scene.render.resolution_x, scene.render.resolution_y = item["size"]
        scene.render.resolution_percentage = 100
    image = scene.render.image_settings
    if hasattr(image, "media_type"):  # Blender 5.0
        image.media_type = "IMAGE"
    image.file_format, image.color_mode, image.color_depth, image.exr_codec = "OPEN_EXR", "RGBA", "32", "ZIP"
    scene.render.use_file_extension = scene.render.use_overwrite = True


@contextlib.contextmanager
def _camera_around(scene, target, degrees: float):
    """The scene's camera moved around the vertical through the target's origin; its own place and animation stay as they are.

    What the scene's property `WITH_CAMERA` names, one name a line, goes along, such as a studio's backdrop.
    """
    own = scene.camera
    if own is None:
        raise RuntimeError(f"the scene {scene.name} has no camera")
    if not degrees:
        yield
        return
    scene.view_layers[0].update()  # nothing else does, in a scene that no window shows
    axis = Matrix.Translation(target.matrix_world.translation)
    turn = axis @ Matrix.Rotation(degrees * 3.141592653589793 / 180.0, 4, "Z") @ axis.inverted()
    along = [scene.objects[name] for name in scene.get(WITH_CAMERA, "").splitlines()]
    # exactly, which a matrix that is taken apart again would not be
    places = [(item.location.copy(), item.rotation_euler.copy(), item.scale.copy()) for item in along]
    moved = bpy.data.objects.new("Lamina View", own.data)
    scene.collection.objects.link(moved)
    try:
        moved.matrix_world = turn @ own.matrix_world
        for item in along:
            item.matrix_world = turn @ item.matrix_world
        scene.camera = moved
        yield
    finally:
        scene.camera = own
        bpy.data.objects.remove(moved)
        for item, place in zip(along, places):
            item.location, item.rotation_euler, item.scale = place


def _write(path: Path, channels: dict, texts: dict[str, str]) -> None:
    needed, free = sum(plane.nbytes for plane in channels.values()), shutil.disk_usage(path.parent).free
    try:
        _replace(path, channels, texts)
    except OSError as error:
        if free > needed:
            raise
        raise OSError(f"the disk is full: a picture takes up to {needed / 1e6:.2f} MB, and {free / 1e6:.2f} MB were free") from error


def _replace(path: Path, channels: dict, texts: dict[str, str]) -> None:
    handle, name = tempfile.mkstemp(prefix=".", suffix=".exr", dir=path.parent)
    os.close(handle)
    try:
        oiio.write(name, channels, texts)
        os.chmod(name, 0o644)
        os.replace(name, path)
    finally:
        with contextlib.suppress(FileNotFoundError):
            os.unlink(name)


def _farm(arguments: list[str]) -> int:
    """Render a range of the items of a bundle. Returns the exit code."""
    import argparse

    parser = argparse.ArgumentParser(prog="render_items.py")
    parser.add_argument("--items", type=Path, required=True)
    parser.add_argument("--range", required=True, help="such as 0-9, 3 or 0-9,12")
    parser.add_argument("--output", type=Path, required=True)
    options = parser.parse_args(arguments)
    listed = json.loads(options.items.read_text(encoding="utf-8"))
    items = listed["items"]
    ends = [part.partition("-") for part in options.range.split(",")]
    wanted = [items[i] for first, _, last in ends for i in range(int(first), int(last or first) + 1)]
    options.output.mkdir(parents=True, exist_ok=True)
    failed = []
    for i, item in enumerate(wanted):
        print(f"openjd_status: {item['id']}", flush=True)
        try:
            what, _ = problem(options.output / item["file"], item["inputs"])
            if not what:
                print(f"{item['id']}: is there already", flush=True)
            elif what == OTHER_INPUTS:
                raise RuntimeError(f"{item['file']} is there already and {what}; choose another folder, or delete it")
            else:
                with _within(listed["time_limit"], item["id"]):
                    scene, target = _shown(item, options.items.parent, listed["allow_missing"])
                    render_item(scene, target, item, item["texts"], options.output)
        except Exception as error:  # one picture must not cost the others
            failed.append(item["id"])
            print(f"openjd_status: {item['id']} failed: {' '.join(str(error).split())}", flush=True)
        print(f"openjd_progress: {100.0 * (i + 1) / len(wanted):.1f}", flush=True)
    if failed:
        print(f"lamina: failed: {', '.join(failed)}", flush=True)
    return 1 if failed else 0


@contextlib.contextmanager
def _within(limit: float | None, name: str):
    """Ends the process when the block takes longer than `limit` seconds: nothing else stops a render that hangs."""

    def end() -> None:
        print(f"openjd_status: {name} failed: took longer than the job's time_limit of {limit:g} s, which ends this task", flush=True)
        os._exit(1)

    watch = threading.Timer(limit or 0.0, end)
    watch.daemon = True
    if limit:
        watch.start()
    try:
        yield
    finally:
        watch.cancel()


def _shown(item: dict, folder: Path, allow_missing: bool):
    """The item's scene and its object, with its material. Raises RuntimeError when the scene asks for what is not there."""
    path = folder / item["blend"]
    if not bpy.data.filepath or not os.path.samefile(bpy.data.filepath, path):
        bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False)
    if lost := dependencies.missing([item["frame"]]):
        if not allow_missing:
            raise RuntimeError(f"{dependencies.named(lost)}; `lamina farm --allow-missing` makes a bundle that goes on without")
        print(f"lamina: goes on without what is missing: {dependencies.named(lost)}", flush=True)
    scene = bpy.data.scenes[item["scene"]]
    target = scene.objects[item["object"]]
    slot, wanted = target.material_slots[item["slot"]], item["material_file"]
    if slot.material is None or slot.material.get("lamina_file") != wanted:
        with bpy.data.libraries.load(str(folder / wanted), link=False) as (_, chosen):
            chosen.materials = [item["material"]]
        former, slot.material = slot.material, chosen.materials[0]
        slot.material["lamina_file"] = wanted
        if former is not None and former.get("lamina_file"):
            bpy.data.materials.remove(former)
    return scene, target


def problem(path: Path, inputs: str) -> tuple[str, dict[str, str]]:
    """What is wrong with an output, empty if nothing, and the texts in its header."""
    try:
        channels, texts = oiio.read(path)
    except FileNotFoundError:
        return "is not there", {}
    except (OSError, ValueError, MemoryError) as error:
        return f"cannot be read: {' '.join(str(error).split())}", {}
    if texts.get("lamina:inputs") != inputs:
        return OTHER_INPUTS, texts
    if not all(name in channels for name in "RGBA") or pixel_hash(channels) != texts.get("lamina:pixels"):
        return "has other pixels than were written", texts
    return "", texts


if __name__ == "__main__":
    code = _farm(sys.argv[sys.argv.index("--") + 1 :])
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)  # some versions hang in their exit handlers
