# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panel's buttons do. Each operator is one undo step; an error is reported and leaves nothing half-made."""

import re
from functools import cache

import bpy
from bpy.props import EnumProperty
from bpy_extras.io_utils import ExportHelper, ImportHelper

from ...reference_py.errors import LaminaError
from ...reference_py.material import presets
from ...reference_py.material.schema import LAMBERT, SCHEMA
from ...reference_py.material.stack import Stack
from ..blender.translation import rpt_, tip_
from ..jobs import bakes
from ..library import user_presets
from ..material import chosen, entry, live_values, osl_setting, reading, replaced
from ..material import material as materials
from ..material.holders import can_hold_material

_JSON = "*.json"
_UNNAMED = "Lamina"
_NEW = "Lamina Material"


def why_no_material(context: bpy.types.Context) -> str:
    """Why there is no surface material to work on, and none can be made for the active object; empty if there is or can."""
    item, material = getattr(context, "object", None), material_of(context)
    if material is not None and material.is_grease_pencil:
        return tip_("{material} is a Grease Pencil material: it shows strokes and no surface").format(material=material.name)
    if item is not None and (material is None or item.active_material == material) and hasattr(item.data, "materials") and not can_hold_material(item):
        return tip_("{object} shows no surface: choose a mesh, curve, text, metaball, hair or point cloud").format(object=item.name)
    if material is not None:
        return ""
    if not can_hold_material(item):
        return tip_("Select an object that can have a material")
    if not (item.is_editable and item.data.is_editable):
        return tip_("The object is linked from another file: make it local to give it a material")
    return ""


def what_gives_way(material: bpy.types.Material) -> str:
    """What a stack takes the place of, in words: textures and animation of former layers, or more or less than the Principled node at the surface."""
    if lost := replaced.lost_with_layers(material):
        return lost.told(rpt_)
    if material.node_tree is None or material.lamina.is_layered:
        return ""
    found = entry.find_entry(entry.surface_output(material.node_tree))
    if found.former is None:
        return ""
    words = {"node": found.former.label or found.former.name, "count": found.bodies}
    if found.is_mixed:
        sentence = (
            rpt_("{node}, one of {count} surfaces that are mixed, gives way; the others stay")
            if found.bodies > 1
            else rpt_("{node} gives way; what it is mixed with stays")
        )
    elif found.former.bl_idname != "ShaderNodeBsdfPrincipled":
        sentence = rpt_("{node} gives way as a whole; it stays in the node tree without a link")
    else:
        return ""
    return sentence.format(**words)


def material_of(context: bpy.types.Context) -> bpy.types.Material | None:
    """The material that the Properties editor shows, else the active object's."""
    shown = getattr(context, "material", None)
    item = getattr(context, "object", None)
    return shown or (item.active_material if item is not None else None)


class LaminaOperator:
    """An operator's `execute` that calls `run` and turns a LaminaError into a report."""

    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        try:
            self.run(context)
        except LaminaError as error:
            self.report({"ERROR"}, error.told(rpt_))
            return {"CANCELLED"}
        return {"FINISHED"}


class LayeredOperator(LaminaOperator):
    """An operator on a material that has a stack."""

    @classmethod
    def poll(cls, context):
        material = material_of(context)
        if material is None or not material.lamina.is_layered:
            cls.poll_message_set(tip_("The active material has no Lamina stack"))
            return False
        return True


@cache
def _names_of_presets() -> set[str]:
    """What Lamina's presets call their stacks, which becomes the name of a new material."""
    return {presets.load(name).name for name in presets.names()}


def _is_name_of_preset(name: str) -> bool:
    return name in _names_of_presets() or name in map(presets.label, user_presets.names())


class StackOperator(LaminaOperator):
    """An operator that gives the active material, made if there is none, a new stack."""

    @classmethod
    def poll(cls, context):
        if why := why_no_material(context):
            cls.poll_message_set(why)
        return not why

    def target(self, context: bpy.types.Context) -> bpy.types.Material | None:
        """The material that gets the stack; None for a new one."""
        return material_of(context)

    def apply(self, material: bpy.types.Material, stack: Stack) -> None:
        materials.apply_stack(material, stack, *chosen.for_new(material))

    def run(self, context):
        stack = self.stack()
        material = self.target(context)
        made = material is None
        if made:
            material = bpy.data.materials.new(stack.name or _UNNAMED)
        former, level = material.lamina.stack_name, "WARNING" if material.lamina.is_layered else "INFO"
        gave_way = what_gives_way(material)
        try:
            self.apply(material, stack)
        except LaminaError:
            if made:
                bpy.data.materials.remove(material)
            raise
        if gave_way:
            self.report({level}, f"Lamina: {gave_way}")
        if made:
            context.object.active_material = material
        elif re.fullmatch(rf"{re.escape(former)}(\.\d+)?", material.name) and _is_name_of_preset(former):
            material.name = stack.name or _UNNAMED  # it had the former preset's name, not one that a user gave it
        for message in stack.unknown_keys():
            self.report({"WARNING"}, f"Lamina: {message}")
        for notice in materials.make_renderable(material, context.scene):
            self.report({"INFO"}, f"Lamina: {notice.told(rpt_)}")


class LAMINA_OT_apply_preset(StackOperator, bpy.types.Operator):
    bl_idname = "lamina.apply_preset"
    bl_label = "Apply Preset"
    bl_description = "Make the material a stack of layers, in place of what it shows"

    preset: EnumProperty(name="Preset", items=[(name, presets.label(name), "") for name in presets.names()])

    @classmethod
    def description(cls, _context, properties):
        return presets.load(properties.preset).source

    def stack(self) -> Stack:
        return presets.load(self.preset)


class LAMINA_OT_new_material(StackOperator, bpy.types.Operator):
    bl_idname = "lamina.new_material"
    bl_label = "New Lamina Material"
    bl_description = "Give the object a new material that is a base alone, to put layers on; the former material stays in the file"

    @classmethod
    def poll(cls, context):
        if not super().poll(context):
            return False
        if getattr(context, "object", None) is None:
            cls.poll_message_set(tip_("Select an object that can have a material"))
            return False
        return True

    def target(self, _context):
        return None

    def stack(self) -> Stack:
        return Stack.from_dict({"name": _NEW, "base": {"kind": LAMBERT.name}})


class LAMINA_OT_import_stack(StackOperator, ImportHelper, bpy.types.Operator):
    bl_idname = "lamina.import_stack"
    bl_label = "Import Stack"
    bl_description = "Read the material's layers from a JSON file, in place of what it shows"

    filename_ext = ".json"
    filter_glob: bpy.props.StringProperty(default=_JSON, options={"HIDDEN"})

    def stack(self) -> Stack:
        return Stack.load(self.filepath)


class LAMINA_OT_export_stack(LayeredOperator, ExportHelper, bpy.types.Operator):
    bl_idname = "lamina.export_stack"
    bl_label = "Export Stack"
    bl_description = "Write the material's visible layers and base to a JSON file"
    bl_options = {"REGISTER"}

    filename_ext = ".json"
    filter_glob: bpy.props.StringProperty(default=_JSON, options={"HIDDEN"})

    def invoke(self, context, event):
        if not self.filepath:
            name = material_of(context).lamina.stack_name or material_of(context).name
            self.filepath = bpy.path.clean_name(name).lower() + self.filename_ext
        return super().invoke(context, event)

    def run(self, context):
        material = material_of(context)
        reading.measured_stack(material).save(self.filepath)
        hidden = len(material.lamina.layers) - len(material.lamina.shown_layers)
        sentence = rpt_("Lamina: stack written to {path}").format(path=self.filepath)
        if hidden:
            sentence = rpt_("{sentence}; hidden layers left out: {count}").format(sentence=sentence, count=hidden)
        if moved := len(live_values.live_values(material)):
            sentence = rpt_("{sentence}; values whose texture or animation is left out: {count}").format(sentence=sentence, count=moved)
        self.report({"INFO"}, sentence)


class LAMINA_OT_set_base(LayeredOperator, bpy.types.Operator):
    bl_idname = "lamina.set_base"
    bl_label = "Set Base Kind"
    bl_description = "Replace the opaque base below the layers; what both kinds have keeps value, texture and animation"

    kind: EnumProperty(name="Kind", items=[(k.name, k.label, k.help) for k in SCHEMA.bases.values()])

    def run(self, context):
        lost = materials.set_base(material_of(context), self.kind)
        if lost:
            words = {"": "", "texture": f" ({rpt_('texture')})", "animation": f" ({rpt_('animation')})"}
            names = ", ".join(rpt_(label) + words[moved] for label, moved in lost)
            sentence = rpt_("Lamina: {kind} has no {lost}: that is gone").format(kind=rpt_(SCHEMA.bases[self.kind].label), lost=names)
            self.report({"WARNING" if any(moved for _, moved in lost) else "INFO"}, sentence)


class LAMINA_OT_regenerate(LayeredOperator, bpy.types.Operator):
    bl_idname = "lamina.regenerate"
    bl_label = "Regenerate Shader"
    bl_description = "Make the shader node anew, for instance after it was deleted"

    def run(self, context):
        materials.regenerate(material_of(context))


class LAMINA_OT_cancel_bake(LayeredOperator, bpy.types.Operator):
    bl_idname = "lamina.cancel_bake"
    bl_label = "Cancel Computing"
    bl_description = "Stop computing the final look; the material stays a preview until a value changes"
    bl_options = {"REGISTER"}

    def run(self, context):
        bakes.cancel(material_of(context))


class LAMINA_OT_retry_bake(LayeredOperator, bpy.types.Operator):
    bl_idname = "lamina.retry_bake"
    bl_label = "Compute Again"
    bl_description = "Compute the final look in the background"
    bl_options = {"REGISTER"}

    def run(self, context):
        bakes.retry(material_of(context))


class LAMINA_OT_enable_osl(LaminaOperator, bpy.types.Operator):
    bl_idname = "lamina.enable_osl"
    bl_label = "Use Cycles with OSL"
    bl_description = "Switch the scene to Cycles and Open Shading Language on"

    def run(self, context):
        for notice in osl_setting.enable_osl(context.scene):
            self.report({"INFO"}, f"Lamina: {notice.told(rpt_)}")


CLASSES = (
    LAMINA_OT_apply_preset,
    LAMINA_OT_new_material,
    LAMINA_OT_import_stack,
    LAMINA_OT_export_stack,
    LAMINA_OT_set_base,
    LAMINA_OT_regenerate,
    LAMINA_OT_cancel_bake,
    LAMINA_OT_retry_bake,
    LAMINA_OT_enable_osl,
)
