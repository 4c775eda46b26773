# SPDX-License-Identifier: GPL-3.0-or-later
"""A stack as explicit geometry: nested shells of glass with absorbing volumes between, over an opaque base.

What users do by brute force. Shells are so close that edges and curvature do not matter. A tinted medium is one object
with both its surfaces, because Cycles leaves a volume by the object and the shader that it was entered by.
"""

from collections.abc import Callable

import bpy
import numpy as np

from ...reference_py.material.stack import Stack
from ...reference_py.optics.interface import Interface
from ...reference_py.optics.optical_stack import OpticalStack
from .compared_materials import base_closure, node_material, script_material

# Between two surfaces, in radii of the ball.
GAP = 2e-3
# Where a tinted medium begins below another one.
_NEXT = 0.05
_GLASS = {"ggx": "MULTI_GGX", "beckmann": "BECKMANN"}
_INNER = "inner"

Surface = Callable[[float], bpy.types.Mesh]
"""Mesh of the surface at a depth below the top, facing out."""


def slab_objects(stack: Stack, surface: Surface) -> list[bpy.types.Object]:
    """Objects of the stack, in no scene yet, from the top."""
    levels = _merged(stack)
    objects, owned = [], False
    for k, level in enumerate(levels):
        tinted, depth = bool(np.any(level.tau > 0.0)), GAP * k
        below = levels[k + 1] if k + 1 < len(levels) else None
        outer = None if owned else level
        if tinted:
            start = depth + GAP * _NEXT * owned
            meshes = [surface(start)] + ([surface(depth + GAP)] if below else [])
            material = _medium(outer, below, level.tau / (GAP * (k + 1) - start))
            objects.append(_object(_joined(meshes), material))
        elif not owned:
            objects.append(_object(surface(depth), _medium(level, None, None)))
        owned = tinted and below is not None
    text = base_closure(stack)
    base = script_material("slab_base", f"shader slab_base(output closure color BSDF = 0) {{ vector U = vector(0); BSDF = {text}; }}")
    return [*objects, _object(surface(GAP * len(levels)), base)]


def _merged(stack: Stack) -> list[Interface]:
    """Interfaces that do something; the medium of one that does nothing belongs to the one above."""
    merged: list[Interface] = []
    for s in OpticalStack.of(stack).interfaces:
        if merged and s.eta == 1.0:
            last = merged[-1]
            merged[-1] = Interface(last.n_above, last.n_below, last.alpha, last.distribution, last.tau + s.tau)
        else:
            merged.append(s)
    return merged


def _object(mesh: bpy.types.Mesh, material: bpy.types.Material) -> bpy.types.Object:
    mesh.materials.clear()
    mesh.materials.append(material)
    return bpy.data.objects.new("Slab", mesh)


def _joined(meshes: list[bpy.types.Mesh]) -> bpy.types.Mesh:
    """The first mesh and, turned inside out, the second; attribute `inner` is 1 on that."""
    import bmesh

    whole = bmesh.new()
    inner = whole.faces.layers.float.new(_INNER)
    for index, mesh in enumerate(meshes):
        if index:
            mesh.flip_normals()
        before = len(whole.faces)
        whole.from_mesh(mesh)
        whole.faces.ensure_lookup_table()
        for face in whole.faces[before:]:
            face[inner], face.smooth = float(index), mesh.polygons[0].use_smooth
    joined = bpy.data.meshes.new("Slab")
    whole.to_mesh(joined)
    whole.free()
    for mesh in meshes:
        bpy.data.meshes.remove(mesh)
    return joined


def _medium(outer: Interface | None, inner: Interface | None, sigma: np.ndarray | None) -> bpy.types.Material:
    """Glass for the outer face (clear where None) and, looked at from below, for the inner one; sigma (3,) per radius."""
    material, node, end = node_material("ShaderNodeBsdfGlass" if outer or inner else "ShaderNodeBsdfTransparent")
    tree = material.node_tree
    if outer or inner:
        faces = outer or inner
        node.distribution = _GLASS[faces.distribution]
        node.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
        ior = outer.eta if outer else 1.0, 1.0 / inner.eta if inner else 1.0
        roughness = [face.alpha**0.5 if face else 0.0 for face in (outer, inner)]
        for name, (first, second) in (("IOR", ior), ("Roughness", roughness)):
            if inner:
                _by_face(tree, first, second, node.inputs[name])
            else:
                node.inputs[name].default_value = first
    if sigma is not None:
        volume = tree.nodes.new("ShaderNodeVolumeAbsorption")
        density = float(np.max(sigma))
        volume.inputs["Color"].default_value = (*(1.0 - sigma / density), 1.0)
        volume.inputs["Density"].default_value = density
        tree.links.new(volume.outputs[0], end.inputs["Volume"])
    return material


def _by_face(tree, first: float, second: float, target) -> None:
    """`first` on outer faces, `second` on inner ones."""
    attribute, mix = tree.nodes.new("ShaderNodeAttribute"), tree.nodes.new("ShaderNodeMath")
    attribute.attribute_name, mix.operation = _INNER, "MULTIPLY_ADD"
    tree.links.new(attribute.outputs["Fac"], mix.inputs[0])
    mix.inputs[1].default_value, mix.inputs[2].default_value = second - first, first
    tree.links.new(mix.outputs[0], target)
