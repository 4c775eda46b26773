# SPDX-License-Identifier: GPL-3.0-or-later
"""What there is to say of one value of a layer or base beside its number: a unit, a mean, an interface that vanishes."""

from dataclasses import dataclass

import bpy

from ...reference_py.material.schema import DIELECTRIC, Parameter
from ...reference_py.optics.microfacet import slope_deg_from_roughness
from ..blender.translation import tip_
from ..material.elements import find_node
from ..material.means import kept_mean, mean_name

# By the schema's unit.
UNITS = {"nm": "In nanometers, millionths of a millimeter", "degrees": "In degrees", "turns": "In turns"}
_AIR = 1.0
_SAME = 1e-3  # of two indices: what is left of the reflection, 2.5e-7, nobody sees


@dataclass(frozen=True)
class Note:
    """A sentence for a tooltip, and whether it is of something that an artist would want to change."""

    text: str
    is_warning: bool = False

    @property
    def icon(self) -> str:
        return "ERROR" if self.is_warning else "INFO"


def note_of(element, node: bpy.types.Node, parameter: Parameter) -> Note | None:
    """What there is to say of a value; None where its name and tooltip say all."""
    socket = node.inputs[parameter.label]
    mean = kept_mean(socket)
    if mean is not None:
        text = f"{mean:.3g}" if isinstance(mean, float) else " ".join(f"{v:.3g}" for v in mean)
        return Note(tip_("Mean of {source}: {value}").format(source=mean_name(socket), value=text))
    if socket.is_linked:
        return None
    if parameter.name == "ior" and (above := _same_above(element, socket.default_value)) is not None:
        return Note(tip_("{above} above has the same IOR, so nothing is reflected between the two").format(above=above), is_warning=True)
    if parameter.name == "roughness":
        slope = slope_deg_from_roughness(socket.default_value, element.distribution)
        return Note(tip_("Mean slope {degrees}\N{DEGREE SIGN}").format(degrees=f"{slope:.1f}"))
    return Note(tip_(UNITS[parameter.unit])) if parameter.unit else None


def _same_above(element, ior: float) -> str | None:
    """Name of what lies on a clear layer, the air or a medium, if it has the same index: then the layer's interface vanishes."""
    above: tuple[str, float | None] = (tip_("Air"), _AIR)
    for layer in element.id_data.lamina.shown_layers:
        if layer == element:
            return above[0] if above[1] is not None and abs(above[1] - ior) < _SAME else None
        node = find_node(layer)
        if layer.kind == DIELECTRIC.name and node is not None:
            index = node.inputs["IOR"]
            above = (layer.name, None if index.is_linked else index.default_value)
    return None
