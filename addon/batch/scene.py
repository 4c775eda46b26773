# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene and the material of each item, in the Blender that runs: made once for all items that share them."""

import json
from pathlib import Path

import bpy

from ...reference_py.errors import LaminaError
from ...reference_py.version import version
from ..jobs.staleness import shown_wrong
from ..material.backend import OSL, branches_here
from ..material.holders import give, holder_named, slots_of
from ..material.material import apply_stack, make_renderable
from ..material.shader_node import remove_material
from ..rendering.studio import build_ball_scene
from .estimate import estimate
from .items import BALL_SAMPLES, Item
from .task import WITH_CAMERA, render_item


class SceneError(LaminaError):
    """What is wrong with a scene or its object, and so with every item that names them."""


class Stage:
    """Shows one item after the other and renders it."""

    def __init__(self, threads: int = 0):
        self._threads = threads
        self._scene_key = self._material_key = None
        self.scene: bpy.types.Scene | None = None
        self.target: bpy.types.Object | None = None
        self.material: bpy.types.Material | None = None
        self.slot = 0
        self.texts: dict[str, str] = {}
        self.notices: list[str] = []

    def render(self, item: Item, folder: Path) -> None:
        """Render an item into the folder. Raises LaminaError."""
        self.show(item)
        try:
            render_item(self.scene, self.target, item.to_dict(), self.texts | own_texts(item), folder)
        except (OSError, ValueError, RuntimeError) as error:
            raise LaminaError(f"{item.file}: {' '.join(str(getattr(error, 'strerror', None) or error).split())}") from None

    def show(self, item: Item) -> None:
        """Make the item's scene and material the present ones. Raises LaminaError."""
        key = (item.blend, item.scene.object)
        if self._scene_key != key:
            self._scene_key = self._material_key = None
            self._open(item)
            self._scene_key = key
        key = (item.stack.to_json(), item.tier, item.backend)
        if self._material_key != key:
            self._material_key = None
            former = self.material
            self.material = self._made(item)
            self.slot = put_on(self.target, self.material)
            if former is not None:
                remove_material(former)
            self.texts = estimate(item.stack, item.tier, OSL in branches_here(item.backend))
            self._material_key = key

    def _open(self, item: Item) -> None:
        self.material, self.notices = None, []
        if not item.blend:
            if bpy.data.filepath:
                bpy.ops.wm.read_homefile(use_empty=True)
            studio = build_ball_scene(None, item.size, BALL_SAMPLES)
            studio.scene[WITH_CAMERA] = "Backdrop\nHalo"
            self.scene, self.target = studio.scene, studio.ball
        else:
            self.scene, self.target = open_scene(item)
            self.notices = [f"{item.scene.blend}: {sentence}" for sentence in shown_wrong(self.scene)]
        if self._threads:
            self.scene.render.threads_mode, self.scene.render.threads = "FIXED", self._threads

    def _made(self, item: Item) -> bpy.types.Material:
        material = bpy.data.materials.new(item.look)
        try:
            apply_stack(material, item.stack, item.tier, item.backend, settle=True)
            make_renderable(material, self.scene)
        except Exception:
            bpy.data.materials.remove(material)
            raise
        return material


def own_texts(item: Item) -> dict[str, str]:
    """What an item's picture says of its origin."""
    return {
        "lamina:id": item.id,
        "lamina:version": version(),
        "lamina:stack": json.dumps(item.stack.to_dict()),
        "lamina:tier": item.tier,
        "lamina:sweep": json.dumps(dict(item.values)),
        "lamina:backend": item.backend,
        "lamina:job": item.job,
        "lamina:blend": f"{item.scene.blend} sha256 {item.digest}" if item.blend else "none, the studio's ball",
    }


def open_scene(item: Item):
    """The active scene of an item's .blend file and the item's object in it. Raises SceneError."""
    try:
        bpy.ops.wm.open_mainfile(filepath=item.blend, load_ui=False)
    except RuntimeError as error:
        raise SceneError(f"{item.scene.blend}: Blender cannot open it: {' '.join(str(error).split())}") from None
    scene = bpy.context.scene
    try:
        target = holder_named(scene.objects, item.scene.object)
    except LaminaError as error:
        raise SceneError(f"{item.scene.blend}: {error}") from None
    if scene.camera is None:
        raise SceneError(f"{item.scene.blend}: the scene {scene.name} has no camera")
    if scene.render.engine != "CYCLES":
        raise SceneError(f"{item.scene.blend}: the scene {scene.name} renders with {scene.render.engine}; choose Cycles in it")
    return scene, own_object(scene, target)


def own_object(scene: bpy.types.Scene, target: bpy.types.Object) -> bpy.types.Object:
    """The object as one of the open file's, if it is a library's: then nothing of it can be changed. The file on the disk stays as it is."""
    if target.library is None:
        return target
    for collection in scene.collection.children_recursive:
        if collection.library is not None and target.name in collection.all_objects:
            collection.make_local()
    return target.make_local()


def put_on(target: bpy.types.Object, material: bpy.types.Material) -> int:
    """Give an object the material in its active slot, the first if it has none. Returns the slot's index.

    A mesh of a library's keeps its materials: the object alone shows the new one.
    """
    (index,) = slots_of(target, None)
    give(target, material, [index], object_level=not target.data.is_editable)
    return index
