# SPDX-License-Identifier: GPL-3.0-or-later
"""Which parameters of a stack's elements a live shader reads through sockets."""

from collections.abc import Sequence
from dataclasses import dataclass

from ...reference_py.errors import LaminaError
from ...reference_py.material.coverage import Patch
from ...reference_py.material.place import Place
from ...reference_py.material.schema import ANISOTROPY, LAMBERT, NORMAL, OREN_NAYAR, SCHEMA, VECTOR, Parameter, Schema
from ...reference_py.material.stack import Base, Layer, Stack

BASE = "Base"
# The direction that anisotropy of rotation 0 follows: a node of the material gives it.
TANGENT = "Tangent"
# Parameters of every shader: Rec.709's primaries in the working space.
PRIMARIES = ("Rec709Red", "Rec709Green", "Rec709Blue")
# Blender 5.2 aborts on a shader of more than 128 parameters, both outputs among them.
MAX_INPUTS = 126 - len(PRIMARIES)


@dataclass(frozen=True)
class ShaderInput:
    """One shader parameter: its OSL name, whose it is ("Layer1", ..., "Base", "Tangent"), and its schema row."""

    osl_name: str
    owner: str
    parameter: Parameter


TANGENT_INPUT = ShaderInput(TANGENT, TANGENT, Parameter("tangent", VECTOR, (0.0, 0.0, 0.0), TANGENT, "Direction that anisotropic surfaces are rougher along"))


def layer_owner(index: int) -> str:
    return f"Layer{index + 1}"


def owners_of(patch: Patch) -> list[str]:
    """Whose the parameters of a patch's layers, from the top, and of its base are."""
    return [*map(layer_owner, patch.layers), BASE if patch.base is None else layer_owner(patch.base)]


def base_color_input(owner: str) -> ShaderInput:
    """The color of a Lambert base, which is the material's or an opaque layer."""
    return ShaderInput(owner + LAMBERT.parameter("color").osl_name, owner, LAMBERT.parameter("color"))


def base_slopes_input(owner: str) -> ShaderInput:
    """The slope deviation of an Oren-Nayar base, which is the material's or an opaque layer."""
    return ShaderInput(owner + OREN_NAYAR.parameter("sigma_deg").osl_name, owner, OREN_NAYAR.parameter("sigma_deg"))


def normal_input(place: Place, owners: Sequence[str]) -> ShaderInput:
    """The own normal of one of these owners' layers, or of the base."""
    owner, (parameter,) = owners[-1 if place.layer is None else place.layer], NORMAL.parameters
    return ShaderInput(owner + parameter.osl_name, owner, parameter)


def place_input(stack: Stack, place: Place, owners: Sequence[str]) -> ShaderInput:
    """The parameter of a value of a stack whose layers and base are these owners'."""
    owner = owners[-1] if place.layer is None else owners[place.layer]
    kinds = SCHEMA.bases if place.layer is None else SCHEMA.layers
    parameter = kinds[place.element(stack).kind].parameter(place.name)
    return ShaderInput(owner + parameter.osl_name, owner, parameter)


def used_sockets(element: Layer | Base, kind) -> tuple[Parameter, ...]:
    """The socket parameters that a shader of this element reads. A named metal is read as eta and k."""
    given = set(element.values)
    if "metal" in given:
        given |= {"eta", "k"}
    return tuple(p for p in kind.sockets if p.name in given)


def shader_inputs(stack: Stack, schema: Schema = SCHEMA) -> tuple[ShaderInput, ...]:
    """Every parameter of the shader of this stack, layers from the top, then the base, then the tangent.

    Raises LaminaError for more layers than Cycles can take.
    """
    owners = [(layer_owner(i), layer, schema.layers[layer.kind]) for i, layer in enumerate(stack.layers)]
    owners.append((BASE, stack.base, schema.bases[stack.base.kind]))
    inputs = [ShaderInput(owner + p.osl_name, owner, p) for owner, element, kind in owners for p in used_sockets(element, kind)]
    if any(element.has(ANISOTROPY) for _, element, _ in owners):
        inputs.append(TANGENT_INPUT)
    if len(inputs) > MAX_INPUTS:
        raise LaminaError(
            "{count} layers need {inputs} shader parameters, and Cycles takes {most}; choose fewer layers",
            count=len(stack.layers),
            inputs=len(inputs),
            most=MAX_INPUTS,
        )
    return tuple(inputs)
