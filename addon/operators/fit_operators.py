# SPDX-License-Identifier: GPL-3.0-or-later
"""The buttons that fit a measurement and cancel that. Without a window the operator waits until the fit is done."""

from pathlib import Path

import bpy
from bpy_extras.io_utils import ImportHelper

from ...reference_py.errors import LaminaError, Sentence
from ...reference_py.fit import AUTO
from ...reference_py.fit.readers import SUFFIXES
from ...reference_py.material.schema import SCHEMA
from ..blender.translation import tip_
from ..jobs import fitting
from ..material import reading
from .material_operators import LaminaOperator, material_of, why_no_material

_AUTO_LAYERS = -1


class LAMINA_OT_fit_measurement(LaminaOperator, ImportHelper, bpy.types.Operator):
    bl_idname = "lamina.fit_measurement"
    bl_label = "Fit Measurement"
    bl_description = "Fit layers to measured reflectance (MERL, RGL, or a table) and give them to the material"

    filename_ext = ".binary"
    filter_glob: bpy.props.StringProperty(default=";".join(f"*{s}" for s in SUFFIXES), options={"HIDDEN"})
    layers: bpy.props.IntProperty(
        name="Layers", default=_AUTO_LAYERS, min=_AUTO_LAYERS, max=4, description="Count of layers; -1 takes the fewest that the data support",
    )  # fmt: skip
    base: bpy.props.EnumProperty(
        name="Base", items=[(AUTO, "Automatic", "The base that the data support")] + [(k.name, k.label, k.help) for k in SCHEMA.bases.values()],
    )  # fmt: skip
    cloudy: bpy.props.BoolProperty(name="Cloudy", description="Try a cloudy medium above the base too, which takes minutes")

    @classmethod
    def poll(cls, context):
        if why := why_no_material(context):
            cls.poll_message_set(why)
            return False
        if fitting.running() is not None:
            cls.poll_message_set(tip_("Another measurement is being fitted"))
            return False
        return True

    def run(self, context):
        material = material_of(context)
        if material is not None:
            reading.require_editable(material)
        path = Path(bpy.path.abspath(self.filepath))
        if path.suffix.lower() not in SUFFIXES:
            raise LaminaError("{path}: choose a file that ends in {choices}", path=path.name or Sentence("no file"), choices=", ".join(SUFFIXES))
        if not path.is_file():
            raise LaminaError("{path}: there is no such file", path=path)
        layers = AUTO if self.layers == _AUTO_LAYERS else self.layers
        fitting.start(material or context.object, str(path), layers, self.base, self.cloudy)
        if not bpy.app.background:
            bpy.app.timers.register(fitting.tick, first_interval=fitting.TICK, persistent=True)
            return
        for sentence in fitting.finish(context.scene):
            self.report({"INFO"}, f"Lamina: {sentence}")


class LAMINA_OT_cancel_fit(LaminaOperator, bpy.types.Operator):
    bl_idname = "lamina.cancel_fit"
    bl_label = "Cancel Fit"
    bl_description = "Stop fitting the measurement; the material stays as it is"
    bl_options = {"REGISTER"}

    def run(self, _context):
        fitting.cancel()


CLASSES = (LAMINA_OT_fit_measurement, LAMINA_OT_cancel_fit)
