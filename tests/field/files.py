# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials that travel: between files, between materials, through saves, and without the add-on."""

import shutil
from contextlib import contextmanager
from pathlib import Path
from unittest import mock

import bpy
import numpy as np

import lamina
from lamina.addon.blender import environment, versions
from lamina.addon.material import material as materials
from lamina.addon.rendering import settings
from lamina.addon.rendering.settings import add_object
from lamina.reference_py.material import presets

from .case import case
from .trial import BLUE, GLAZE, LIVE, METAL, PAINT, RED, Picture, Trial, image_of

SHIPPED = Path(lamina.__file__).parent / "addon" / "presets" / "lamina_presets.blend"


def shelf(trial: Trial) -> tuple[str, Picture]:
    """A library with PAINT as "subject" on the object "item", and its picture. Leaves an empty stage."""
    path = str(trial.folder / "library.blend")
    picture = trial.plain()
    trial.show(trial.material()).data.materials[0].asset_mark()
    bpy.ops.wm.save_as_mainfile(filepath=path)
    trial.stage()
    return path, picture


def brought(path: str, *, link: bool, name: str = "subject", kind: str = "materials", **options):
    with bpy.data.libraries.load(path, link=link, **options) as (_, wanted):
        setattr(wanted, kind, [name])
    return getattr(wanted, kind)[0]


def reopened(trial: Trial, **options) -> bpy.types.Material:
    """The material "subject" after a save and an open."""
    path = str(trial.folder / "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, **options)
    bpy.ops.wm.open_mainfile(filepath=path)
    return next(m for m in bpy.data.materials if m.name == "subject" and m.library is None)


@case("link a material", osl_off=True)
def link(trial):
    """A linked material's picture beside its own file's; Check says only that it is linked."""
    path, picture = shelf(trial)
    material = brought(path, link=True)
    trial.show(material)
    trial.compare_pictures("linked", trial.picture(), picture, trial.within)
    trial.sound(material, "not_editable")


@case("link an object")
def link_object(trial):
    """A linked object's picture beside its own file's."""
    path, picture = shelf(trial)
    bpy.context.scene.collection.objects.link(brought(path, link=True, name="item", kind="objects"))
    trial.compare_pictures("linked", trial.picture(), picture)


@case("link, then a preset")
def link_then_preset(trial):
    """A preset on a linked material is refused with the way out; a Principled cannot be changed either."""
    path, picture = shelf(trial)
    material = brought(path, link=True)
    trial.show(material)
    if trial.is_lamina:
        trial.require("refused, with 'local'", "local" in refusal(lambda: bpy.ops.lamina.apply_preset(preset="clean_copper")))
    trial.compare_pictures("picture", trial.picture(), picture)


def refusal(act) -> str:
    """What an operator says instead of doing it; empty when it did it."""
    try:
        act()
    except RuntimeError as error:
        return str(error)
    return ""


@case("make a linked object local", quick=False)
def make_local(trial):
    """After Make Local the material renders the same, can be edited, and is sound."""
    path, picture = shelf(trial)
    item = brought(path, link=True, name="item", kind="objects")
    bpy.context.scene.collection.objects.link(item)
    bpy.context.view_layer.objects.active = item
    bpy.ops.object.make_local(type="ALL")
    material = bpy.context.scene.objects["item"].active_material
    trial.require("local", material.library is None)
    trial.compare_pictures("local", trial.picture(), picture)
    trial.set_color(material, BLUE)
    trial.sound(material)
    got = trial.picture()
    trial.compare_pictures("edited", got, trial.plain(PAINT.with_color(BLUE)))


@case("library override, edited")
def override_edited(trial):
    """A color that is set on an override shows, or Check says to make the material local."""
    path, _ = shelf(trial)
    trial.show(brought(path, link=True))
    material = bpy.data.materials["subject"].override_create(remap_local_usages=True)
    trial.socket(material, "color").default_value = (*BLUE, 1.0)
    got = trial.picture()
    if trial.is_lamina:
        said = [f.text() for f in trial.findings(material)]
        if any("local" in text and "can be edited" not in text and "to edit its values" not in text for text in said):
            trial.excuse(material, "not_editable")
    trial.compare_pictures("edited", got, trial.plain(PAINT.with_color(BLUE)))


@case("library override, saved and opened", osl_off=True)
def override_saved(trial):
    """Blender drops an override's values of nodes; after that the picture is that of the value which the socket shows."""
    path, picture = shelf(trial)
    trial.show(brought(path, link=True))
    material = bpy.data.materials["subject"].override_create(remap_local_usages=True)
    trial.socket(material, "color").default_value = (*BLUE, 1.0)
    material = reopened(trial)
    shown = tuple(trial.socket(material, "color").default_value)[:3]
    trial.sound(material, "not_editable")
    got = trial.picture()
    expected = picture if np.allclose(shown, RED, atol=1e-5) else trial.plain(PAINT.with_color(shown))
    trial.compare_pictures("opened", got, expected, trial.within)


@case("library override, operators", beside=False)
def override_operators(trial):
    """Every operator that would change an override refuses and names the way out."""
    path, _ = shelf(trial)
    trial.show(brought(path, link=True))
    bpy.data.materials["subject"].override_create(remap_local_usages=True)
    for name in ("regenerate", "retry_bake", "set_base", "apply_preset"):
        options = {"set_base": {"kind": "oren_nayar"}, "apply_preset": {"preset": "clean_copper"}}.get(name, {})
        trial.require(f"{name} refuses, with 'make it local'", "make it local" in refusal(lambda: getattr(bpy.ops.lamina, name)(**options)))


@case("append a material", osl_off=True)
def append(trial):
    """An appended material's picture beside its own file's; nothing is wrong with it."""
    path, picture = shelf(trial)
    bpy.ops.wm.append(filename="subject", directory=f"{path}/Material/")
    material = bpy.data.materials["subject"]
    trial.show(material)
    trial.compare_pictures("appended", trial.picture(), picture, trial.within)
    trial.sound(material)


@case("append twice, edit one", quick=False)
def append_twice(trial):
    """Two appended materials share nothing: one is edited, the other stays."""
    path, picture = shelf(trial)
    first, second = brought(path, link=False), brought(path, link=False)
    trial.set_color(first, BLUE)
    item = trial.show(second)
    trial.compare_pictures("other", trial.picture(), picture)
    item.active_material = first
    edited = trial.picture()
    trial.compare_pictures("edited", edited, trial.plain(PAINT.with_color(BLUE)))


@case("append an object, reuse what is here")
def append_object(trial):
    """An object appended with Reuse Local Data beside its own file's picture."""
    path, picture = shelf(trial)
    brought(path, link=False)
    bpy.ops.wm.append(filename="item", directory=f"{path}/Object/", do_reuse_local_id=True)
    trial.compare_pictures("appended", trial.picture(), picture)
    trial.sound(bpy.data.objects["item"].active_material)


@case("link a collection, instance it", quick=False)
def collection_instance(trial):
    """A linked collection's instance beside its own file's picture."""
    path, picture = shelf(trial)
    group = brought(path, link=True, name="Collection", kind="collections") if "Collection" in listed(path) else None
    if group is None:  # an empty file has no collection of its own: make one in the library
        bpy.ops.wm.open_mainfile(filepath=path)
        group = bpy.data.collections.new("Props")
        group.objects.link(bpy.data.objects["item"])
        group.use_fake_user = True
        bpy.ops.wm.save_mainfile()
        trial.stage()
        group = brought(path, link=True, name="Props", kind="collections")
    place = add_object(bpy.context.scene, "place", None)
    place.instance_type, place.instance_collection = "COLLECTION", group
    trial.compare_pictures("instance", trial.picture(), picture)


def listed(path: str) -> list[str]:
    with bpy.data.libraries.load(path, link=True) as (there, _):
        return list(there.collections)


@case("reload a library that has changed", quick=False)
def reload_library(trial):
    """A library is edited and saved elsewhere; after Reload the linked material shows the edit."""
    path, picture = shelf(trial)
    bpy.ops.wm.open_mainfile(filepath=path)
    trial.set_color(bpy.data.materials["subject"], BLUE)
    edited = str(trial.folder / "edited.blend")
    bpy.ops.wm.save_as_mainfile(filepath=edited, copy=True)
    trial.stage()
    trial.show(brought(path, link=True))
    trial.compare_pictures("before", trial.picture(), picture)
    shutil.copy(edited, path)
    bpy.data.libraries[0].reload()
    got = trial.picture()
    trial.compare_pictures("after", got, trial.plain(PAINT.with_color(BLUE)))


@case("link and pack", least=(5, 0))
def link_packed(trial):
    """A material that is linked and packed, its library deleted, the file saved and opened: the same picture."""
    path, picture = shelf(trial)
    trial.show(brought(path, link=True, pack=True))
    Path(path).unlink()
    saved = str(trial.folder / "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=saved)
    bpy.ops.wm.open_mainfile(filepath=saved)
    trial.compare_pictures("packed", trial.picture(), picture)


@case("shipped asset appended, OSL off", quick=False, beside=False)
def asset_appended(trial):
    """A preset from the asset library in a Cycles scene as Blender makes it, without OSL: as with OSL."""
    _shipped(trial, bpy.ops.wm.append)


@case("shipped asset linked, OSL off", quick=False, beside=False)
def asset_linked(trial):
    """The same, linked."""
    _shipped(trial, bpy.ops.wm.link)


def _shipped(trial: Trial, bring) -> None:
    name = presets.load("clean_copper").name
    trial.stage()
    expected = bpy.data.materials.new("expected")
    materials.apply_stack(expected, presets.load("clean_copper"))
    trial.settle(expected)
    trial.show(expected)
    picture = trial.picture(osl=True)
    trial.stage().cycles.shading_system = False
    bring(filename=name, directory=f"{SHIPPED}/Material/")
    trial.show(bpy.data.materials[name])
    trial.compare_pictures("asset", trial.picture(), picture, 0.05)


@case("own asset, marked and appended")
def own_asset(trial):
    """A material marked as an asset keeps the mark and its picture when it is appended."""
    path, picture = shelf(trial)
    material = brought(path, link=False)
    trial.require("still an asset", material.asset_data is not None)
    trial.show(material)
    trial.compare_pictures("asset", trial.picture(), picture)


@case("copy a material, edit the copy")
def copy(trial):
    """The original's picture and layers after its copy was edited; the copy shows the edit."""
    picture = trial.plain()
    original = trial.material()
    duplicate = original.copy()
    trial.set_color(duplicate, BLUE)
    item = trial.show(original)
    trial.compare_pictures("original", trial.picture(), picture)
    trial.is_same("the original", original, PAINT)
    trial.sound(duplicate)
    item.active_material = duplicate
    got = trial.picture()
    trial.compare_pictures("copy", got, trial.plain(PAINT.with_color(BLUE)))


@case("duplicate an object with its material")
def duplicate_object(trial):
    """Duplicate with the preference Duplicate Data: Material; the new material is edited, the old one stays."""
    picture = trial.plain()
    item = trial.show(trial.material())
    edit = bpy.context.preferences.edit
    former, edit.use_duplicate_material = edit.use_duplicate_material, True
    try:
        bpy.ops.object.duplicate()
    finally:
        edit.use_duplicate_material = former
    twin = bpy.context.object
    trial.require("another material", twin.active_material != item.active_material)
    trial.set_color(twin.active_material, BLUE)
    twin.hide_render = True
    trial.compare_pictures("old", trial.picture(), picture)
    twin.hide_render, item.hide_render = False, True
    trial.sound(twin.active_material)
    got = trial.picture()
    trial.compare_pictures("new", got, trial.plain(PAINT.with_color(BLUE)))


@case("make single user")
def single_user(trial):
    """Two objects with one material; after Make Single User one is edited, the other stays."""
    picture = trial.plain()
    first = trial.show(trial.material())
    second = trial.show(first.active_material, name="second")
    bpy.ops.object.make_single_user(type="SELECTED_OBJECTS", object=True, obdata=True, material=True)
    trial.require("two materials", first.active_material != second.active_material)
    trial.set_color(second.active_material, BLUE)
    second.hide_render = True
    trial.sound(first.active_material)
    trial.compare_pictures("other", trial.picture(), picture)


def paste(source: bpy.types.Material, item: bpy.types.Object) -> None:
    """Blender's own Copy Material, and Paste Material on what the object has."""
    for material, operator in ((source, bpy.ops.material.copy), (item.active_material, bpy.ops.material.paste)):
        with bpy.context.temp_override(material=material, object=item, active_object=item):
            operator()


@case("copy and paste onto a new material", osl_off=True)
def paste_new(trial):
    """Blender's Copy and Paste Material onto a plain material: the same picture, layers that can be edited."""
    picture = trial.plain()
    item = trial.show(bpy.data.materials.new("target"))
    versions.node_tree(item.active_material)
    paste(trial.material(), item)
    target = item.active_material
    trial.compare_pictures("pasted", trial.picture(), picture, trial.within)
    trial.is_same("the pasted one", target, PAINT)
    trial.sound(target)


@case("copy and paste onto such a material")
def paste_over(trial):
    """Pasted over a material of the same kind with other layers: the source's layers, and a later edit shows."""
    picture = trial.plain()
    item = trial.show(trial.material(METAL, "target"))
    paste(trial.material(), item)
    target = item.active_material
    trial.compare_pictures("pasted", trial.picture(), picture)
    trial.is_same("the pasted one", target, PAINT)
    trial.sound(target)
    trial.set_color(target, BLUE)
    got = trial.picture()
    trial.compare_pictures("edited", got, trial.plain(PAINT.with_color(BLUE)))


@case("paste, then save and open")
def paste_saved(trial):
    """A pasted material after a save: layers and picture are there, and nothing is wrong with it."""
    picture = trial.plain()
    item = trial.show(trial.material(METAL))
    paste(trial.material(PAINT, "source"), item)
    material = reopened(trial)
    trial.compare_pictures("opened", trial.picture(), picture)
    trial.is_same("the opened one", material, PAINT)
    trial.sound(material)


@case("replace a material by another (Remap Users)")
def remap(trial):
    """Every user of another material gets this one: its picture."""
    picture = trial.plain()
    other = trial.material(METAL, "other")
    trial.show(other)
    material = trial.material()
    other.user_remap(material)
    trial.compare_pictures("remapped", trial.picture(), picture)
    trial.sound(material)


@case("purge unused data", quick=False)
def purge(trial):
    """After Purge the picture stays and an edit still shows."""
    picture = trial.plain()
    material = trial.material()
    trial.show(material)
    bpy.ops.outliner.orphans_purge(do_recursive=True)
    trial.compare_pictures("purged", trial.picture(), picture)
    trial.set_color(material, BLUE)
    trial.sound(material)
    got = trial.picture()
    trial.compare_pictures("edited", got, trial.plain(PAINT.with_color(BLUE)))


@case("fake user, saved twice")
def fake_user(trial):
    """A material that nothing uses, with a fake user, after two saves."""
    picture = trial.plain()
    trial.material().use_fake_user = True
    reopened(trial)
    material = reopened(trial)
    trial.show(material)
    trial.compare_pictures("kept", trial.picture(), picture)
    trial.sound(material)


@case("save compressed and open", osl_off=True)
def save_compressed(trial):
    """A compressed file, opened: the same picture."""
    picture = trial.plain()
    trial.show(trial.material())
    material = reopened(trial, compress=True)
    trial.compare_pictures("opened", trial.picture(), picture, trial.within)
    trial.is_same("the opened one", material, PAINT)
    trial.sound(material)


@case("save with unfinished edits")
def save_edited(trial):
    """A color is changed and the file saved at once; opened, the new color renders."""
    expected = trial.plain(PAINT.with_color(BLUE))
    material = trial.material()
    trial.show(material)
    trial.socket(material, "color").default_value = (*BLUE, 1.0)
    reopened(trial)
    trial.compare_pictures("opened", trial.picture(), expected)


@case("move a folder with its textures", osl_off=True)
def move(trial):
    """A file with a relative texture in a folder that is moved: the texture's color."""
    expected = trial.plain(PAINT.with_color(BLUE))
    home = trial.folder / "project"
    (home / "textures").mkdir(parents=True)
    material = trial.material()
    image = material.node_tree.nodes.new("ShaderNodeTexImage")
    image.image = image_of(home / "textures" / "blue.exr", BLUE)
    material.node_tree.links.new(image.outputs["Color"], trial.socket(material, "color"))
    trial.settle(material)
    trial.show(material)
    bpy.ops.wm.save_as_mainfile(filepath=str(home / "a.blend"))
    bpy.ops.file.make_paths_relative()
    bpy.ops.wm.save_mainfile()
    shutil.move(home, trial.folder / "moved")
    bpy.ops.wm.open_mainfile(filepath=str(trial.folder / "moved" / "a.blend"))
    trial.excuse_textures(bpy.data.materials["subject"])
    trial.compare_pictures("moved", trial.picture(), expected, LIVE)


@contextmanager
def without_addon():
    """Lamina switched off, as in the preferences."""
    lamina.unregister()
    try:
        yield
    finally:
        lamina.register()


@case("add-on off", quick=False, osl_off=True)
def addon_off(trial):
    """A file opened without the add-on, as a farm has it: the same picture."""
    picture = trial.plain()
    trial.show(trial.material())
    path = str(trial.folder / "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    with without_addon():
        bpy.ops.wm.open_mainfile(filepath=path)
        got = trial.picture()
    trial.compare_pictures("without the add-on", got, picture, trial.within)


@case("add-on off, save, on", quick=False)
def addon_off_and_on(trial):
    """Saved twice without the add-on and copied there; with it again, both are whole and an edit shows."""
    path = str(trial.folder / "saved.blend")
    trial.show(trial.material())
    bpy.ops.wm.save_as_mainfile(filepath=path)
    with without_addon():
        for _ in range(2):
            bpy.ops.wm.open_mainfile(filepath=path)
            bpy.ops.wm.save_mainfile()
        made = bpy.data.materials["subject"].copy()
        made.name, made.use_fake_user = "copy", True
        bpy.ops.wm.save_mainfile()
    bpy.ops.wm.open_mainfile(filepath=path)
    for name in ("subject", "copy"):
        trial.is_same(name, bpy.data.materials[name], PAINT)
        trial.sound(bpy.data.materials[name])
    trial.set_color(bpy.data.materials["copy"], BLUE)
    bpy.data.objects["item"].active_material = bpy.data.materials["copy"]
    got = trial.picture()
    trial.compare_pictures("copy, edited", got, trial.plain(PAINT.with_color(BLUE)))


@case("two scenes, the second without OSL")
def two_scenes(trial):
    """One object in two scenes of a file, OSL on in one and off in the other: both as with OSL."""
    picture = trial.plain()
    trial.show(trial.material())
    second = bpy.context.scene.copy()
    second.cycles.shading_system = False
    trial.compare_pictures("first", trial.picture(), picture)
    trial.compare_pictures("second", trial.picture(second), picture, 0.05)


@case("background scene (Set)", quick=False)
def background_set(trial):
    """An object that is rendered as another scene's background set: the same picture."""
    picture = trial.plain()
    trial.show(trial.material())
    stage = bpy.context.scene
    front = bpy.data.scenes.new("front")
    settings.measurement_settings(front, 16, 48, max_bounces=2)
    front.render.film_transparent, front.world, front.camera, front.background_set = True, stage.world, stage.camera, stage
    front.render.threads_mode, front.render.threads = "FIXED", 1
    trial.compare_pictures("as a set", trial.picture(front), picture)


@contextmanager
def blender_without_osl():
    """What Lamina is told by a Blender that was built without OSL."""
    missing = (False, environment.NO_OSL)
    with mock.patch.object(environment, "osl_available", lambda: missing), mock.patch.object(settings, "osl_available", lambda: missing):
        with mock.patch.object(environment, "renders_osl", lambda: False):
            yield


@case("file made in a Blender without OSL", osl_off=True)
def made_without_osl(trial):
    """Made and saved where there is no OSL, opened where there is, saved there and opened again: as if made here."""
    picture = trial.plain()
    path = str(trial.folder / "saved.blend")
    with blender_without_osl():
        trial.stage()
        trial.show(trial.material())
        bpy.ops.wm.save_as_mainfile(filepath=path)
    for what in ("opened", "saved again"):
        bpy.ops.wm.open_mainfile(filepath=path)
        bpy.context.scene.cycles.shading_system = trial.osl
        trial.compare_pictures(what, trial.picture(), picture, 0.05 if trial.is_lamina else trial.within)
        bpy.ops.wm.save_mainfile()


@case("file edited in a Blender without OSL", osl_off=True)
def edited_without_osl(trial):
    """Made with OSL, its color changed where there is none, opened with OSL: the new color, never the old one."""
    expected = trial.plain(PAINT.with_color(BLUE))
    path = str(trial.folder / "saved.blend")
    trial.show(trial.material())
    bpy.ops.wm.save_as_mainfile(filepath=path)
    with blender_without_osl():
        bpy.ops.wm.open_mainfile(filepath=path)
        trial.socket(bpy.data.materials["subject"], "color").default_value = (*BLUE, 1.0)
        bpy.ops.wm.save_mainfile()
    bpy.ops.wm.open_mainfile(filepath=path)
    bpy.context.scene.cycles.shading_system = trial.osl
    trial.compare_pictures("opened", trial.picture(), expected, 0.05 if trial.is_lamina else trial.within)


@case("undo a preset", quick=False)
def undo(trial):
    """A preset over a material, undone: the former layers and picture."""
    picture = trial.plain(GLAZE)
    trial.show(trial.material(GLAZE))
    bpy.ops.ed.undo_push(message="before")
    if trial.is_lamina:
        bpy.ops.lamina.apply_preset(preset="clean_copper")
    else:
        trial.set_color(bpy.data.materials["subject"], BLUE)
    bpy.ops.ed.undo_push(message="after")
    bpy.ops.ed.undo()
    material = bpy.context.scene.objects["item"].active_material
    trial.is_same("the former one", material, GLAZE)
    trial.sound(material)
    trial.compare_pictures("undone", trial.picture(), picture)


def set_working_space(space: str) -> None:
    """The file's working space, its colors converted, as Blender's button does it."""
    bpy.ops.wm.set_working_color_space(working_space=space, convert_colors=True)


@case("append into an ACEScg file", quick=False, least=(5, 0), osl_off=True)
def append_across_spaces(trial):
    """Appended from a Rec.709 file into an ACEScg one: the same light, converted, to 1 %."""
    path, picture = shelf(trial)
    set_working_space("ACEScg")
    material = brought(path, link=False)
    trial.settle(material)
    _in_acescg(trial, material, picture)


@case("link into an ACEScg file", quick=False, least=(5, 0), osl_off=True)
def link_across_spaces(trial):
    """Linked from a Rec.709 file into an ACEScg one: the same light, converted, to 1 %."""
    path, picture = shelf(trial)
    set_working_space("ACEScg")
    _in_acescg(trial, brought(path, link=True), picture)


def _in_acescg(trial: Trial, material: bpy.types.Material, picture: Picture) -> None:
    from mathutils import Color

    trial.show(material)
    got = trial.picture()
    # a uniform grey is the same in both, and the sun and the world are grey
    as_rec709 = np.array([Color(c).from_scene_linear_to_rec709_linear() for c in got.quarters])
    trial.compare("picture, as Rec.709", as_rec709, picture.quarters, 0.01 if trial.osl else trial.within)
