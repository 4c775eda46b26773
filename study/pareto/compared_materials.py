# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials of the ways that are compared, besides Lamina's own."""

import bpy
import numpy as np

from ...addon.blender.versions import node_tree
from ...addon.material.script_node import set_script
from ...addon.shader.nodes.node_groups import lobe_group
from ...addon.shader.osl.generate import Shader, generate
from ...reference_py.lobes.made import Made
from ...reference_py.lobes.view_table import TableLobes
from ...reference_py.material.stack import Stack
from ...reference_py.models.baselines.principled_coat import PrincipledCoat
from ...reference_py.optics.bases import ConductorBase, DiffuseBase
from ...reference_py.optics.diffuse import fujii_roughness
from ...reference_py.optics.optical_stack import OpticalStack


def node_material(kind: str, output: str = "Surface") -> tuple[bpy.types.Material, bpy.types.Node, bpy.types.Node]:
    """A material of one shader node that feeds its output node."""
    material = bpy.data.materials.new("Pareto")
    tree = node_tree(material)
    tree.nodes.clear()
    node, end = tree.nodes.new(kind), tree.nodes.new("ShaderNodeOutputMaterial")
    if node.outputs:
        tree.links.new(node.outputs[0], end.inputs[output])
    return material, node, end


def script_material(name: str, text: str, closures: int = 1) -> bpy.types.Material:
    """A material of a Script node with this text, a shader called `name` without inputs."""
    material, node, end = node_material("ShaderNodeScript")
    set_script(node, Shader(name, text, (), closures))
    material.node_tree.links.new(node.outputs["BSDF"], end.inputs["Surface"])
    return material


def table_material(lobe_set: TableLobes, stack: Stack, name: str) -> bpy.types.Material:
    """A lobe set in tables as Lamina writes it in OSL, its shader called `name`."""
    shader = generate(Made("baked", stack, lobe_set))
    return script_material(name, shader.text.replace(shader.name, name), shader.lobe_count)


def group_material(lobe_set: TableLobes) -> bpy.types.Material:
    """A lobe set of `tabulate` as Lamina writes it in stock nodes."""
    material, node, end = node_material("ShaderNodeGroup")
    node.node_tree = lobe_group(lobe_set)
    material.node_tree.links.new(node.outputs["BSDF"], end.inputs["Surface"])
    return material


def glossy_material(color: np.ndarray, alpha: float) -> bpy.types.Material:
    """A plain Glossy node."""
    material, node, _ = node_material("ShaderNodeBsdfAnisotropic")
    node.distribution = "GGX"
    node.inputs["Color"].default_value = (*color, 1.0)
    node.inputs["Roughness"].default_value = alpha**0.5
    return material


def principled_material(model: PrincipledCoat) -> bpy.types.Material:
    """A Principled node with the model's settings."""
    material, node, _ = node_material("ShaderNodeBsdfPrincipled")
    for name, value in model.settings().items():
        node.inputs[name].default_value = (*value, 1.0) if isinstance(value, tuple) else value
    return material


def layer_text(stack: Stack, name: str) -> str:
    """The stack as a user of OSL's layer() would write it."""
    text = base_closure(stack)
    for s in reversed(OpticalStack.of(stack).interfaces):
        top = f"dielectric_bsdf(N, U, color(1), color(0), {s.alpha:.9g}, {s.alpha:.9g}, {s.eta:.9g}, {_distribution(s.distribution)})"
        text = f"layer({top}, {_triple(np.exp(-2.0 * s.tau))} * {text})"
    return f"shader {name}(output closure color BSDF = 0) {{ vector U = vector(0); BSDF = {text}; }}"


def base_closure(stack: Stack) -> str:
    """OSL of the base under its medium; U is a tangent."""
    base = OpticalStack.of(stack).base
    match base:
        case DiffuseBase(sigma_deg=0.0):
            return f"{_triple(base.color)} * diffuse(N)"
        case DiffuseBase():
            return f"oren_nayar_diffuse_bsdf(N, {_triple(base.color)}, {fujii_roughness(base.sigma_deg):.9g})"
        case ConductorBase():
            (eta, k), alpha = base.relative_index, base.facets.alpha
            return f"conductor_bsdf(N, U, {alpha:.9g}, {alpha:.9g}, {_triple(eta)}, {_triple(k)}, {_distribution(base.facets.distribution)})"


def _distribution(distribution: str) -> str:
    return '"multi_ggx"' if distribution == "ggx" else f'"{distribution}"'


def _triple(values) -> str:
    return "color(" + ", ".join(f"{v:.9g}" for v in values) + ")"
