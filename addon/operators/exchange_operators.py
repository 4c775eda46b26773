# SPDX-License-Identifier: GPL-3.0-or-later
"""Buttons that convert materials. Every report goes to a text of the file and, with a window, to a popup."""

import textwrap
from pathlib import Path

import bpy
from bpy_extras.io_utils import ExportHelper, ImportHelper

from ...reference_py.atomic import write_text
from ...reference_py.errors import LaminaError, Sentence
from ...reference_py.exchange import SUFFIX, materialx, openpbr
from ...reference_py.exchange import report as reports
from ..blender.translation import rpt_, tip_
from ..exchange import conversion, materialx_import, selection_export, sources
from ..material import chosen, reading
from ..material import material as materials
from ..material.holders import can_hold_material
from . import material_operators as ops

REPORT_TEXT = "Lamina Conversion"
_POPUP_WIDTH = 110
SIZES = (64, 128, 256, 512, 1024, 2048, 4096)
"""Pixels of a picture."""
_FORMATS = (
    ("openpbr", "OpenPBR", "A MaterialX file with the surface OpenPBR"),
    ("standard_surface", "Standard Surface", "A MaterialX file with Autodesk's standard surface"),
    ("gltf_pbr", "glTF PBR", "A MaterialX file with glTF's surface"),
    ("layers", "Graph of Layers", "A MaterialX file that says the stack itself; textures become their means"),
    ("principled", "Principled Values", "Values of Blender's Principled BSDF as text (.json)"),
)


def tell(operator: bpy.types.Operator, title: str, report: "reports.Report", notes: list[str] = ()) -> None:
    """Write a report into the text, say its summary, and show all of it where there is a window."""
    tell_lines(operator, title, [*notes, *report.lines()], f": {report.summary.told(rpt_)}")


def tell_lines(operator: bpy.types.Operator, title: str, lines: list[str], summary: str = "") -> None:
    """The same with any lines; sentences are told in the user's language."""
    spoken = [line.told(rpt_) if isinstance(line, Sentence) else line for line in lines]
    text = bpy.data.texts.get(REPORT_TEXT) or bpy.data.texts.new(REPORT_TEXT)
    text.clear()
    text.write("\n".join([title, *spoken]) + "\n")
    for line, said in zip(lines, spoken):
        if line.startswith(reports.LOST):
            operator.report({"WARNING"}, f"Lamina: {said}")
    operator.report({"INFO"}, f"Lamina: {title}{summary}")
    if bpy.app.background:
        return

    def draw(popup, _context):
        for line in (part for whole in spoken for part in textwrap.wrap(whole, _POPUP_WIDTH, subsequent_indent="    ")):
            popup.layout.label(text=line, translate=False)
        popup.layout.label(text=rpt_("All of it is in the text {name}").format(name=REPORT_TEXT), translate=False)

    bpy.context.window_manager.popup_menu(draw, title=title, icon="INFO")


class LAMINA_OT_convert_principled(ops.LaminaOperator, bpy.types.Operator):
    bl_idname = "lamina.convert_principled"
    bl_label = "Convert to Lamina"
    bl_description = "Put a stack of layers in the place of the material's Principled node, as bright as it is; textures stay linked"

    @classmethod
    def poll(cls, context):
        material = ops.material_of(context)
        try:
            if material is None:
                raise LaminaError(tip_("Select a material"))
            if why := ops.why_no_material(context):
                raise LaminaError(why)
            sources.principled_of(material)
        except LaminaError as error:
            cls.poll_message_set(error.told(tip_))
            return False
        return True

    def run(self, context):
        material = ops.material_of(context)
        report, notes = conversion.to_lamina(material, *chosen.for_new(material))
        tell(self, rpt_("{material} to Lamina").format(material=material.name), report, notes)
        for notice in materials.make_renderable(material, context.scene):
            self.report({"INFO"}, f"Lamina: {notice.told(rpt_)}")


class LAMINA_OT_principled_copy(ops.LayeredOperator, bpy.types.Operator):
    bl_idname = "lamina.principled_copy"
    bl_label = "Make a Principled Copy"
    bl_description = "Make a new material with a Principled node, as bright as this one and with its textures; this one stays"

    def run(self, context):
        copy, report, notes = conversion.principled_copy(ops.material_of(context))
        copy.use_fake_user = True  # no object has it yet
        tell(self, copy.name, report, notes)


class LAMINA_OT_principled_copies(ops.LaminaOperator, bpy.types.Operator):
    bl_idname = "lamina.principled_copies"
    bl_label = "Principled Copies"
    bl_description = "Make a material with a Principled node of every Lamina material of the file, as bright and with its textures; those stay"

    @classmethod
    def poll(cls, _context):
        if any(material.lamina.is_layered for material in bpy.data.materials):
            return True
        cls.poll_message_set(tip_("No material of this file has a Lamina stack"))
        return False

    def run(self, _context):
        notes = [(copy, sentence) for copy, sentence in conversion.principled_copies(replacing=False)]
        made = sum(not copy.lamina.is_layered for copy, _ in notes)
        for left, sentence in notes:
            if left.lamina.is_layered:
                self.report({"WARNING"}, f"Lamina: {left.name}: {sentence.told(rpt_)}")
        tell_lines(
            self, rpt_("{count} Principled copies").format(count=made), [Sentence("{name}: {line}", name=copy.name, line=sentence) for copy, sentence in notes]
        )


class LAMINA_OT_export_mtlx(ops.LayeredOperator, ExportHelper, bpy.types.Operator):
    bl_idname = "lamina.export_mtlx"
    bl_label = "Export MaterialX"
    bl_description = "Write the material as OpenPBR to a MaterialX file, without textures, and say what was lost"
    bl_options = {"REGISTER"}

    filename_ext = SUFFIX
    filter_glob: bpy.props.StringProperty(default=f"*{SUFFIX}", options={"HIDDEN"})

    def run(self, context):
        material = ops.material_of(context)
        converted = openpbr.to_openpbr(reading.measured_stack(material))
        write_text(self.filepath, materialx.to_mtlx(converted.values, material.name))
        tell(self, Path(self.filepath).name, converted.report, materialx_import.lost_textures(material))


class LAMINA_OT_export_materials(ops.LaminaOperator, bpy.types.Operator):
    bl_idname = "lamina.export_materials"
    bl_label = "Export Lamina Materials"
    bl_description = "Write every Lamina material of the selected objects to a file of its own, for other programs, and say what was lost"
    bl_options = {"REGISTER"}

    directory: bpy.props.StringProperty(name="Folder", description="Folder that the files are written to", subtype="DIR_PATH")
    filter_folder: bpy.props.BoolProperty(default=True, options={"HIDDEN"})
    target: bpy.props.EnumProperty(name="Format", description="What each material becomes", items=_FORMATS, default="openpbr")
    pictures: bpy.props.BoolProperty(
        name="Textures", description="Bake what textures feed over the object's UV map, as pictures that the file names; without, their means are written"
    )
    size: bpy.props.EnumProperty(name="Size", description="Width and height of each picture", items=[(str(n), f"{n} px", "") for n in SIZES], default="1024")
    reports: bpy.props.BoolProperty(name="Write Reports", description="Write beside each file what was kept, approximated and lost", default=True)

    @classmethod
    def poll(cls, context):
        if selection_export.layered_materials(context.selected_objects):
            return True
        cls.poll_message_set(tip_("No selected object has a Lamina material"))
        return False

    def invoke(self, context, _event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def draw(self, _context):
        for name in ("target", "pictures", "size", "reports"):
            row = self.layout.row()
            row.active = name != "size" or self.pictures
            row.prop(self, name)

    def run(self, context):
        if not self.directory:
            raise LaminaError("choose a folder for the materials")
        wish = selection_export.Wish(self.target, self.pictures, int(self.size), self.reports)
        folder = Path(bpy.path.abspath(self.directory))
        done = list(selection_export.export(context.selected_objects, folder, wish))
        tell_lines(
            self,
            rpt_("{count} materials in {folder}").format(count=len(done), folder=folder),
            [Sentence("{name}: {line}", name=name, line=line) for name, lines in done for line in lines],
        )
        for name, lines in done:
            for line in lines:
                if line.startswith("lost: left out"):
                    self.report({"WARNING"}, f"Lamina: {name}: {line.told(rpt_)}")


class LAMINA_OT_import_mtlx(ops.LaminaOperator, ImportHelper, bpy.types.Operator):
    bl_idname = "lamina.import_mtlx"
    bl_label = "Import MaterialX"
    bl_description = "Read the first material of a MaterialX file as layers, in place of what the material shows, with its images"

    filename_ext = SUFFIX
    filter_glob: bpy.props.StringProperty(default=f"*{SUFFIX}", options={"HIDDEN"})

    @classmethod
    def poll(cls, context):
        return ops.StackOperator.poll.__func__(cls, context)

    def run(self, context):
        source, *others = materialx.load_mtlx(self.filepath)
        material = ops.material_of(context)
        target = material or bpy.data.materials.new(source.name or "Lamina")
        gave_way = ops.what_gives_way(target)
        try:
            imported = materialx_import.apply_material(target, source, *chosen.for_new(target))
        except Exception:
            if material is None:
                bpy.data.materials.remove(target)
            raise
        if material is None:
            context.object.active_material = target
        more = [reports.noted(reports.LOST, Sentence("{count} more materials of the file: File > Import reads them all", count=len(others)))] if others else []
        tell(self, Path(self.filepath).name, imported.report, [*filter(None, [gave_way]), *more, *imported.notes])
        for notice in materials.make_renderable(target, context.scene):
            self.report({"INFO"}, f"Lamina: {notice.told(rpt_)}")


class LAMINA_OT_import_materials(ops.LaminaOperator, ImportHelper, bpy.types.Operator):
    bl_idname = "lamina.import_materials"
    bl_label = "Import MaterialX Materials"
    bl_description = "Make a Lamina material of every material of a MaterialX file, with its images; an object without a material gets the first"

    filename_ext = SUFFIX
    filter_glob: bpy.props.StringProperty(default=f"*{SUFFIX}", options={"HIDDEN"})

    def invoke(self, context, event):
        if self.filepath:  # a file that was dropped
            return self.execute(context)
        return super().invoke(context, event)

    def run(self, context):
        made, lines = materialx_import.import_materials(self.filepath, chosen.for_new)
        item = context.object
        if can_hold_material(item) and item.is_editable and item.data.is_editable and item.active_material is None:
            item.active_material = made[0].material
        for imported in made:
            if not imported.material.users:
                imported.material.use_fake_user = True  # no object has it yet
            lines += [Sentence("{name}: {line}", name=imported.material.name, line=line) for line in (*imported.notes, *imported.report.lines())]
        tell_lines(self, rpt_("{count} materials of {file}").format(count=len(made), file=Path(self.filepath).name), lines)
        for notice in dict.fromkeys(n for imported in made for n in materials.make_renderable(imported.material, context.scene)):
            self.report({"INFO"}, f"Lamina: {notice.told(rpt_)}")


class LAMINA_FH_materialx(bpy.types.FileHandler):
    bl_idname = "LAMINA_FH_materialx"
    bl_label = "MaterialX as Lamina Materials"
    bl_import_operator = LAMINA_OT_import_materials.bl_idname
    bl_file_extensions = SUFFIX

    @classmethod
    def poll_drop(cls, context):
        return context.area is not None and context.area.type == "VIEW_3D"


def show_export(menu: bpy.types.Menu, _context) -> None:
    """Lamina's entry of File > Export."""
    menu.layout.operator(LAMINA_OT_export_materials.bl_idname, text="Lamina Materials (.mtlx, .json)")


def show_import(menu: bpy.types.Menu, _context) -> None:
    """Lamina's entry of File > Import."""
    menu.layout.operator(LAMINA_OT_import_materials.bl_idname, text="MaterialX as Lamina Materials (.mtlx)")


class LAMINA_MT_exchange(bpy.types.Menu):
    bl_label = "Convert"

    def draw(self, _context):
        layout = self.layout
        layout.operator(LAMINA_OT_convert_principled.bl_idname, icon="NODE_MATERIAL")
        layout.operator(LAMINA_OT_principled_copy.bl_idname, icon="DUPLICATE")
        layout.operator(LAMINA_OT_principled_copies.bl_idname)
        layout.separator()
        layout.operator(LAMINA_OT_import_mtlx.bl_idname, text="Import MaterialX...", icon="IMPORT")
        layout.operator(LAMINA_OT_export_mtlx.bl_idname, text="Export MaterialX...", icon="EXPORT")
        layout.operator(LAMINA_OT_export_materials.bl_idname, text="Export Selection...")
        layout.separator()
        layout.operator("lamina.bake_textures", text="Bake to Textures...", icon="RENDER_STILL")


CLASSES = (
    LAMINA_OT_convert_principled,
    LAMINA_OT_principled_copy,
    LAMINA_OT_principled_copies,
    LAMINA_OT_export_mtlx,
    LAMINA_OT_export_materials,
    LAMINA_OT_import_mtlx,
    LAMINA_OT_import_materials,
    LAMINA_FH_materialx,
    LAMINA_MT_exchange,
)
