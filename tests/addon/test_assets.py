# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets as assets: thumbnails, the asset library, what is dropped from it, and presets that users save."""

import re
import uuid
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from support.stacks import assert_same

from lamina.addon.blender import user_folders
from lamina.reference_py.errors import LaminaError
from lamina.reference_py.material import presets
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.optics.frame import spherical
from lamina.reference_py.registry import make_model

pytestmark = pytest.mark.blender


@pytest.fixture
def catalogue(blender):
    from lamina.addon.library import preset_catalogues

    return preset_catalogues


@pytest.fixture
def own(blender, tmp_path, monkeypatch):
    """The user's presets, in a folder of this test."""
    from lamina.addon.library import user_presets

    monkeypatch.setenv(user_folders.PRESETS_VARIABLE, str(tmp_path / "own"))
    return user_presets


@pytest.fixture
def layered(blender):
    """A selected plane with a layered material."""
    import bpy

    from lamina.addon.material.material import apply_stack

    bpy.ops.mesh.primitive_plane_add()
    material = bpy.data.materials.new("Layered")
    bpy.context.object.data.materials.append(material)
    apply_stack(material, presets.load("piano_lacquer"), "analytic")
    return material


class Icons(dict):
    """Blender numbers icons only where there is a window; this does so everywhere."""

    def load(self, key, path, kind):
        assert Path(path).is_file() and kind == "IMAGE" and key not in self
        self[key] = SimpleNamespace(icon_id=len(self) + 1)


@pytest.fixture
def icons(blender, monkeypatch):
    from lamina.addon.library import preset_icons

    monkeypatch.setattr(preset_icons, "_icons", Icons())
    return preset_icons


def libraries() -> list:
    import bpy

    return list(bpy.context.preferences.filepaths.asset_libraries)


def appended(name: str):
    """A preset as a drop from the library with `Append` brings it."""
    import bpy

    from lamina.addon.library.preset_catalogues import ASSETS

    with bpy.data.libraries.load(str(ASSETS), link=False, assets_only=True) as (there, here):
        assert presets.label(name) in there.materials
        here.materials = [presets.label(name)]
    return here.materials[0]


def rendered_albedo(material) -> np.ndarray:
    """(2, 3) what Cycles reflects at 0 and 60 degrees in a white furnace."""
    from lamina.addon.rendering.measure import render_furnace

    return render_furnace(material, [0.0, 60.0], samples=64, size=16)[0]


def test_every_preset_is_in_one_catalogue_and_has_a_picture(catalogue):
    from lamina.addon.blender.images import read_png

    members = [name for names in catalogue.CATALOGUES.values() for name in names]
    assert sorted(members) == presets.names()
    for name in members:
        pixels, _ = read_png(catalogue.thumbnail_of(name))
        assert pixels.shape == (128, 128, 3) and pixels.std() > 10.0, name
        assert catalogue.thumbnail_of(name).stat().st_size < 24_000
    assert {path.stem for path in catalogue.FOLDER.glob("*.png")} == set(members)


def test_the_library_holds_every_preset_as_it_is_now(catalogue):
    """What is committed is not stale: names, stacks, catalogues, previews."""
    import bpy

    from lamina.addon.material.material import stack_of
    from lamina.addon.material.state import is_settled

    assert catalogue.CATALOGUE_FILE.read_text() == catalogue.catalogue_text()
    with bpy.data.libraries.load(str(catalogue.ASSETS), link=False, assets_only=True) as (there, here):
        here.materials = list(there.materials)
    found = {material.name: material for material in here.materials}
    assert set(found) == {presets.label(name) for name in presets.names()}
    for group, names in catalogue.CATALOGUES.items():
        for name in names:
            material = found[presets.label(name)]
            assert_same(stack_of(material), presets.load(name))
            assert is_settled(material), name
            assert material.asset_data.catalog_id == catalogue.catalogue_id(group)
            assert tuple(material.preview.image_size) == (128, 128)
    assert catalogue.ASSETS.stat().st_size < 3_500_000, "with what EEVEE shows, images that follow two textures, and films in what exporters find"


def test_catalogues_are_in_the_form_that_blender_reads(catalogue):
    lines = [line for line in catalogue.catalogue_text().splitlines() if line and line[0] not in "#V"]
    for line in lines:
        identity, path, simple = line.split(":")
        assert str(uuid.UUID(identity)) == identity and path.startswith("Lamina") and simple == path.replace("/", "-")
    assert len({line.split(":")[0] for line in lines}) == len(lines) == len(catalogue.CATALOGUES) + 1


def test_a_dropped_preset_renders_as_it_should_and_can_be_edited(catalogue):
    from lamina.addon.material.elements import node_of
    from lamina.addon.material.layers import add_layer
    from lamina.addon.material.material import stack_of

    # one without tilted lobes, of which a white world sees more in 4.5 (test_tilted_lobes.py)
    dropped = appended("glazed_mug")
    assert dropped.library is None
    truth = make_model("adding", presets.load("glazed_mug")).albedo(spherical(np.radians([0.0, 60.0]), 0.0))
    assert rendered_albedo(dropped) == pytest.approx(truth, rel=0.02, abs=0.002)
    dropped.lamina.tier = "analytic"
    node_of(dropped.lamina.base).inputs["Color"].default_value = (0.02, 0.02, 0.5, 1.0)
    add_layer(dropped, "dielectric", 0)
    edited = stack_of(dropped)
    assert len(edited.layers) == 2 and edited.base["color"] == pytest.approx((0.02, 0.02, 0.5))
    truth = make_model("adding", edited).albedo(spherical(np.radians([0.0, 60.0]), 0.0))
    assert rendered_albedo(dropped) == pytest.approx(truth, rel=0.03, abs=0.002)


def test_two_drops_are_two_materials(catalogue):
    from lamina.addon.material.elements import node_of

    first, second = appended("glossy_plastic"), appended("glossy_plastic")
    node_of(first.lamina.base).inputs["Color"].default_value = (0.0, 1.0, 0.0, 1.0)
    assert tuple(node_of(second.lamina.base).inputs["Color"].default_value) != (0.0, 1.0, 0.0, 1.0)


def test_the_library_comes_and_goes_with_the_extension(catalogue):
    import bpy

    from lamina.addon.library import asset_library

    asset_library.unregister()
    others = bpy.context.preferences.filepaths.asset_libraries
    theirs = others.new(name="Lamina", directory=str(Path.home()))
    try:
        before = [(library.name, library.path) for library in libraries()]
        asset_library.register()
        asset_library.register()
        added = [library for library in libraries() if Path(library.path) == catalogue.FOLDER]
        assert len(added) == 1 and added[0].import_method == "APPEND" and len(libraries()) == len(before) + 1
        asset_library.unregister()
        asset_library.unregister()
        assert [(library.name, library.path) for library in libraries()] == before
        gone = others.new(name="Old", directory=str(Path("/nowhere", *catalogue.FOLDER.parts[-3:])))
        assert gone.name == "Old"
        asset_library.register()  # one that a deleted Lamina left behind goes
        assert len(libraries()) == len(before) + 1
    finally:
        others.remove(theirs)
        asset_library.register()


def test_icons_are_those_of_the_pictures_and_missing_ones_are_none(icons):
    ids = [icons.preset_icon(name) for name in presets.names()]
    assert 0 not in ids and len(set(ids)) == len(ids)
    assert icons.preset_icon(presets.names()[0]) == ids[0]
    assert icons.preset_icon("no_such_preset") == 0


def test_a_saved_preset_is_in_the_menu_and_comes_back(layered, own, icons):
    import bpy

    from lamina.addon.material.elements import node_of
    from lamina.addon.material.material import stack_of

    node_of(layered.lamina.base).inputs["Color"].default_value = (0.5, 0.25, 0.125, 1.0)
    saved = stack_of(layered)
    assert bpy.ops.lamina.save_preset(name="My Own Lacquer") == {"FINISHED"}
    assert own.names() == ["my_own_lacquer"] and own.picture_of("my_own_lacquer").is_file()
    assert icons.user_preset_icon("my_own_lacquer") != 0
    assert len(bpy.data.scenes) == 1  # the thumbnail's studio is gone
    assert {item["text"] for item in menu() if item["id"] == "lamina.apply_user_preset"} == {"My Own Lacquer"}
    assert bpy.ops.lamina.apply_preset(preset="clean_copper") == {"FINISHED"}
    assert bpy.ops.lamina.apply_user_preset(name="my_own_lacquer") == {"FINISHED"}
    back = stack_of(layered)
    assert back.name == "My Own Lacquer" and back.source == f"Own preset, begun from: {saved.source}"
    assert replace(back, name=saved.name, source=saved.source).to_dict() == saved.to_dict()
    assert bpy.ops.lamina.remove_preset(name="my_own_lacquer") == {"FINISHED"}
    assert own.names() == [] and not own.picture_of("my_own_lacquer").exists()
    assert not [item for item in menu() if item["id"] == "lamina.apply_user_preset"]


class Menu:
    """A layout that notes the operators drawn into it."""

    def __init__(self, noted: list):
        self.noted = noted

    def row(self):
        return self

    column = row

    def separator(self):
        pass

    def label(self, **options):
        pass

    def menu(self, _name, **options):
        pass

    def operator(self, identity, text="", **options):
        self.noted.append({"id": identity, "text": text, **options})
        return type("Properties", (), {})()


def menu() -> list[dict]:
    from lamina.addon.operators.preset_operators import draw_presets

    noted = []
    draw_presets(Menu(noted))
    return noted


def test_the_menu_shows_every_preset_with_its_icon(icons, own):
    drawn = [item for item in menu() if item["id"] == "lamina.apply_preset"]
    assert len(drawn) == len(presets.names()) and all(item["icon_value"] for item in drawn)


STACK = Stack.from_dict({"base": {"kind": "lambert"}})
WRITTEN = (lambda path: path.write_bytes(b"picture"), lambda path: path.write_bytes(b"asset"))


@pytest.mark.parametrize(
    "label, told",
    [
        ("", "a preset needs a name"),
        ("../out", "'.' cannot be"),
        ("a/b", "'/' cannot be"),
        ("C:\\x", "':' cannot be"),
        (".hidden", "'.' cannot be"),
        ("x" * 61, "at most 60"),
        ("CON", "a device's"),
        ("Clean Copper", "one of Lamina's own"),
        ("taken", "taken by a preset of yours"),
        ("TAKEN ", "taken by a preset of yours"),
    ],
)
def test_names_that_climb_or_clash_are_refused(own, label, told):
    own.save("taken", STACK, *WRITTEN)
    before = sorted(path.name for path in user_folders.presets_folder().parent.rglob("*"))
    with pytest.raises(LaminaError, match=re.escape(told)) as error:
        own.save(label, STACK, *WRITTEN)
    assert "\n" not in str(error.value)
    assert sorted(path.name for path in user_folders.presets_folder().parent.rglob("*")) == before


@pytest.mark.parametrize("name", ["../x", "/etc/passwd", "", "nope"])
def test_only_presets_of_ones_own_are_read_or_removed(own, tmp_path, name):
    (tmp_path / "x.json").write_text("{}")
    for act in (own.load, own.remove):
        with pytest.raises(LaminaError, match="unknown preset"):
            act(name)
    assert (tmp_path / "x.json").exists()


def test_a_picture_that_fails_is_said_and_a_failing_asset_leaves_no_preset(own):
    def fail(path: Path) -> None:
        path.write_bytes(b"half")
        raise LaminaError("no room")

    assert own.save("plain", STACK, fail, WRITTEN[1]) == ("plain", "no room")
    assert not own.picture_of("plain").exists() and own.load("plain") == STACK
    before = sorted(path.name for path in user_folders.presets_folder().iterdir())
    with pytest.raises(LaminaError, match="no room"):
        own.save("half", STACK, WRITTEN[0], fail)
    assert sorted(path.name for path in user_folders.presets_folder().iterdir()) == before
