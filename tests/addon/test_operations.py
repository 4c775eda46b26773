# SPDX-License-Identifier: GPL-3.0-or-later
"""Whatever is done in whatever order: panel, sockets and stack agree, and textures and keyframes stay with their layer.

250 random operations; `LAMINA_OPERATIONS=1000` (make operations) does as many as it says.
"""

import os

import pytest

bpy = pytest.importorskip("bpy")

from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from lamina.addon.check import check
from lamina.addon.material import material as materials
from lamina.addon.material.elements import node_of
from lamina.addon.material.roles import EEVEE, node_with
from lamina.addon.material.shader_node import shader_of
from lamina.reference_py.material.coverage import MAX_COVERED
from lamina.reference_py.material.stack import Stack

pytestmark = pytest.mark.blender

_SEQUENCE = 25
_COUNT = int(os.environ.get("LAMINA_OPERATIONS", "250"))
_MOST_LAYERS = 6
START = Stack.from_dict(
    {
        "name": "Start",
        "layers": [{"kind": "dielectric", "name": "Coat", "roughness": 0.1}, {"kind": "dielectric"}],
        "base": {"kind": "conductor", "metal": "gold", "roughness": 0.3},
    }
)

OPERATIONS = st.one_of(
    st.tuples(st.just("add"), st.sampled_from(["dielectric", "frost", "glazed_pigment"])),
    st.tuples(st.just("move"), st.sampled_from(["UP", "DOWN"])),
    st.tuples(st.just("rename"), st.sampled_from(["Paint", "Coat", '\N{LATIN SMALL LETTER O WITH DIAERESIS}l "1"'])),
    st.tuples(st.just("value"), st.sampled_from([0.0, 0.25, 0.75])),
    st.tuples(st.just("select"), st.integers(0, _MOST_LAYERS)),
    st.tuples(st.just("solo"), st.integers(0, _MOST_LAYERS)),
    *(st.tuples(st.just(name)) for name in ("undo", "undo", "redo", "remove", "duplicate", "paste", "hide", "texture", "keyframe", "save_and_load")),
)


def the_material():
    """References die with every undo and load, so it is looked up anew."""
    return bpy.data.materials["random"]


def observed() -> dict:
    """All that an operation may change, as plain data. Raises LaminaError if nodes and structure do not agree."""
    material = the_material()
    lamina, tree = material.lamina, material.node_tree
    curves = {}
    if tree.animation_data is not None and tree.animation_data.action is not None:
        for layer in tree.animation_data.action.layers:
            for bag in [bag for strip in layer.strips for bag in strip.channelbags]:
                curves |= {curve.data_path: tuple(tuple(key.co) for key in curve.keyframe_points) for curve in bag.fcurves}
    rows = []
    for layer in lamina.layers:
        node = node_of(layer)
        roughness, tint = node.inputs["Roughness"], node.inputs["Tint"]
        rows.append({
            "name": layer.name, "node": layer.node, "visible": layer.visible, "roughness": roughness.default_value,
            "texture": tint.links[0].from_node.name if tint.is_linked else "",
            "keys": curves.pop(roughness.path_from_id("default_value"), ()),
        })  # fmt: skip
    assert not curves, "keyframes of no layer"
    return {"layers": rows, "solo": lamina.solo, "stack": materials.stack_of(material, hidden=True).to_dict()}


def kept(row: dict) -> dict:
    """What a copy of a layer has of it."""
    return {key: row[key] for key in ("visible", "roughness", "texture", "keys")}


class Session:
    """What was done so far, and what should be seen: `past` are the steps of the undo stack, `at` where we are in it."""

    def __init__(self, path: str):
        self.path, self.serial = path, 0
        self.past, self.at = [observed()], 0

    def step(self, name: str, argument=None) -> None:
        before = self.past[self.at]
        changed = getattr(self, name)(*([] if argument is None else [argument]))
        after = observed()
        if name not in ("undo", "redo", "save_and_load"):
            if changed:
                self.past[self.at + 1 :] = [after]
                self.at += 1
            else:
                assert after == before
        assert after == self.past[self.at]
        consistent(after)

    def _layers(self):
        return the_material().lamina.layers

    def _has_room(self, layers: int, covered: int) -> bool:
        """Whether so many layers more, some of them with a coverage, are allowed, also when all are shown."""
        return len(self._layers()) + layers <= _MOST_LAYERS and sum(e.use_coverage for e in self._layers()) + covered <= MAX_COVERED

    def add(self, kind):
        if not self._has_room(1, kind == "rust"):
            return False
        names = [e.name for e in self._layers()]
        call = bpy.ops.lamina.layer_add if kind == "dielectric" else bpy.ops.lamina.layer_add_ready
        call("EXEC_DEFAULT", True, **{"kind" if kind == "dielectric" else "ready": kind})
        added = [e.name for e in self._layers()][the_material().lamina.active_layer :][: len(self._layers()) - len(names)]
        assert not set(added) & set(names) and len(set(added)) == len(added)
        return True

    def move(self, direction):
        lamina = the_material().lamina
        if len(lamina.layers) < 2 or lamina.active_layer >= len(lamina.layers):
            return False
        if lamina.active_layer == 0:
            direction = "DOWN"
        elif lamina.active_layer == len(lamina.layers) - 1:
            direction = "UP"
        to = lamina.active_layer + (-1 if direction == "UP" else 1)
        rows = observed()["layers"]
        bpy.ops.lamina.layer_move("EXEC_DEFAULT", True, direction=direction)
        rows.insert(to, rows.pop(to + (1 if direction == "UP" else -1)))
        assert observed()["layers"] == rows
        return True

    def remove(self):
        rows, active = observed()["layers"], the_material().lamina.active_layer
        if not rows or active >= len(rows):
            return False
        bpy.ops.lamina.layer_remove("EXEC_DEFAULT", True)
        assert observed()["layers"] == rows[:active] + rows[active + 1 :]
        return True

    def duplicate(self):
        rows, active = observed()["layers"], the_material().lamina.active_layer
        if active >= len(rows) or not self._has_room(1, self._layers()[active].use_coverage):
            return False
        bpy.ops.lamina.layer_duplicate("EXEC_DEFAULT", True)
        seen = observed()["layers"]
        twin = seen.pop(active)
        assert seen == rows
        assert kept(twin) == kept(rows[active])
        return True

    def paste(self):
        rows = observed()["layers"]
        if not rows or not self._has_room(len(rows), sum(e.use_coverage for e in self._layers())):
            return False
        bpy.ops.lamina.layer_copy("EXEC_DEFAULT", all_layers=True)
        bpy.ops.lamina.layer_paste("EXEC_DEFAULT", True)
        seen, active = observed()["layers"], the_material().lamina.active_layer
        pasted = seen[active : active + len(rows)]
        assert seen[:active] + seen[active + len(rows) :] == rows
        assert [kept(row) for row in pasted] == [kept(row) for row in rows]
        return True

    def _set(self, change) -> bool:
        """As the panel does when a property or a socket is edited: the change, then an undo step."""
        lamina = the_material().lamina
        if lamina.active_layer >= len(lamina.layers):
            return False
        before = observed()
        change(lamina.layers[lamina.active_layer])
        if observed() == before:
            return False
        bpy.ops.ed.undo_push(message="set")
        return True

    def rename(self, name):
        return self._set(lambda layer: setattr(layer, "name", name))

    def value(self, roughness):
        active = the_material().lamina.active_layer
        if any(row["keys"] for row in observed()["layers"][active : active + 1]):
            return False  # keyframes take an edited value back when the file is next read or the frame changes
        return self._set(lambda layer: setattr(node_of(layer).inputs["Roughness"], "default_value", roughness))

    def hide(self):
        return self._set(lambda layer: setattr(layer, "visible", not layer.visible))

    def select(self, index):
        if index % max(len(self._layers()), 1) == the_material().lamina.active_layer:
            return False
        the_material().lamina.active_layer = index % len(self._layers())
        return False  # it is of the window and not of the file

    def solo(self, index):
        if not self._layers():
            return False
        bpy.ops.lamina.layer_solo("EXEC_DEFAULT", True, index=index % len(self._layers()))
        return True

    def texture(self):
        tree = the_material().node_tree
        self.serial += 1

        def link(layer):
            texture = tree.nodes.new("ShaderNodeTexNoise")
            texture.name = f"Noise {self.serial}"
            tree.links.new(texture.outputs["Color"], node_of(layer).inputs["Tint"])

        return self._set(link)

    def keyframe(self):
        return self._set(lambda layer: node_of(layer).inputs["Roughness"].keyframe_insert("default_value", frame=1))

    def undo(self):
        if self.at > 0:
            bpy.ops.ed.undo()
            self.at -= 1

    def redo(self):
        if self.at < len(self.past) - 1:
            bpy.ops.ed.redo()
            self.at += 1

    def save_and_load(self):
        bpy.ops.wm.save_as_mainfile(filepath=self.path)
        bpy.ops.wm.open_mainfile(filepath=self.path)
        bpy.ops.ed.undo_push(message="loaded")
        self.past, self.at = [self.past[self.at]], 0


def consistent(seen: dict) -> None:
    """Structure, nodes and shader agree: Check finds nothing, and the shader's text and its wires are of the shown layers."""
    material = the_material()
    found = [finding for finding in check.find(material, bpy.context.scene, bpy.context.preferences) if finding.level != check.NOTE]
    assert not found, [finding.text() for finding in found]
    assert material.lamina.problem == ""
    shaders = (node_with(material, "nodes"), node_with(material, EEVEE))
    nodes = [node for node in material.node_tree.nodes if node.bl_idname == "ShaderNodeGroup" and node not in shaders]
    assert len(nodes) == len(seen["layers"]) + 1
    assert {node.name: node.label for node in nodes} == {e.node: e.name for e in (*material.lamina.layers, material.lamina.base)}
    shown = [row["node"] for row in seen["layers"] if (row["node"] == seen["solo"] if seen["solo"] else row["visible"])]
    script = shader_of(material)
    wired = [s.links[0].from_node.name for s in script.inputs if s.identifier.endswith("Roughness")]
    assert wired == [*shown, material.lamina.base.node]


# a failing sequence is printed as it is: to shorten it takes longer than to read it
@settings(max_examples=max(_COUNT // _SEQUENCE, 1), deadline=None, derandomize=True, database=None,
          phases=[Phase.generate], suppress_health_check=list(HealthCheck))  # fmt: skip
@given(st.lists(OPERATIONS, min_size=_SEQUENCE, max_size=_SEQUENCE))
def test_any_order_leaves_all_consistent(registered_lamina, tmp_path_factory, operations):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.preferences.edit.undo_steps = 2 * _SEQUENCE
    item = bpy.data.objects.new("object", bpy.data.meshes.new("mesh"))
    bpy.context.collection.objects.link(item)
    bpy.context.view_layer.objects.active = item
    item.data.materials.append(bpy.data.materials.new("random"))
    materials.apply_stack(item.active_material, START, tier="weidlich_wilkie")
    bpy.ops.lamina.enable_osl()
    bpy.ops.ed.undo_push(message="start")
    session = Session(str(tmp_path_factory.mktemp("random") / "random.blend"))
    for operation in operations:
        session.step(*operation)
