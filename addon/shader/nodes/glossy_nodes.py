# SPDX-License-Identifier: GPL-3.0-or-later
"""The glossy lobes of tables as Glossy and Metallic nodes, kept where Cycles computes with them exactly."""

from collections.abc import Callable

import bpy
import numpy as np

from ....reference_py.lobes.tabulate import is_grey_dielectric
from ....reference_py.lobes.view_table import GlossyTable
from ....reference_py.optics.microfacet import SPECULAR_ALPHA
from ...blender.versions import HAS_DIELECTRIC
from .node_builder import Builder
from .view_nodes import View, columns_at, weight_at

DISTRIBUTIONS = {"ggx": "GGX", "beckmann": "BECKMANN"}
# Cycles evaluates isotropic lobes in float32 from 1 - cos^2, off by 3e-7 / alpha^2. Below this alpha the error of the
# least anisotropy that a Glossy node does not ignore, 1e-3, is the smaller one.
NARROW_ALPHA = 0.017
_LEAST_ANISOTROPY = 1.01e-4
# Of the Metallic node, to which any anisotropy will do, and the alpha below which it is given (osl/break_isotropy.h).
_SLIGHT_ANISOTROPY, _NARROW_DIELECTRIC_ALPHA = 2e-6, 0.06
# A table that is anisotropic the other way by no more than this counts as isotropic.
_NEARLY_ISOTROPIC = 1e-3


def glossy(build: Builder, view: View, table: GlossyTable, color=None) -> bpy.types.NodeSocket:
    """The closure of a table; `color` unless its own weight is meant."""
    if table.fresnel is not None:
        return _dielectric(build, view, table)
    color = weight_at(build, view, table.weight, table.axis) if color is None else color
    alpha_x, alpha_y, slope = columns_at(build, view, table.shape)
    round_ = _is_round(table.shape)
    roughness = build.math("SQRT", alpha_x if round_ else build.math("SQRT", build.math("MULTIPLY", alpha_x, alpha_y)))

    def anisotropy():
        return anisotropy_of(build, lambda a, b: build.math("SQRT", build.math("DIVIDE", a, b)), alpha_x, alpha_y, table.shape)

    return glossy_node(build, view, table.distribution, color, roughness, anisotropy, slope, table.shape, table.frame)


def _is_round(shape: np.ndarray) -> bool:
    return bool(np.all(shape[:, 0] == shape[:, 1]))


def glossy_node(
    build: Builder,
    view: View,
    distribution: str,
    color,
    roughness,
    anisotropy: Callable,
    slope,
    shape: np.ndarray,
    frame: float | bpy.types.NodeSocket | None = None,
) -> bpy.types.NodeSocket:
    """A Glossy node of these operands; `shape` (n, 3) is all that its alphas and slope can be, and `anisotropy` is asked where it is not round.

    `frame` is in radians from the tangent, or a socket of full turns.
    """
    sockets = {"Color": color, "Roughness": roughness}
    if _is_round(shape) and np.min(shape[:, 0]) < NARROW_ALPHA < np.max(shape[:, 0]):
        sockets["Anisotropy"] = build.math("MULTIPLY", build.math("LESS_THAN", roughness, NARROW_ALPHA**0.5), _LEAST_ANISOTROPY)
    else:
        sockets["Anisotropy"] = _kept_apart(build, 0.0 if _is_round(shape) else anisotropy(), shape[:, :2])
    if frame is not None:
        turns = frame if isinstance(frame, bpy.types.NodeSocket) else frame / (2.0 * np.pi)
        sockets["Tangent"], sockets["Rotation"] = view.given_tangent, turns
    elif sockets["Anisotropy"] != 0.0:
        sockets["Tangent"] = view.tangent
    if np.any(shape[:, 2]):
        sockets["Normal"] = build.vector("MULTIPLY_ADD", view.side, slope, view.normal)
    else:
        sockets |= view.own_normal
    return build.shader("ShaderNodeBsdfAnisotropic", settings={"distribution": DISTRIBUTIONS[distribution]}, **sockets)


def _dielectric(build: Builder, view: View, table: GlossyTable) -> bpy.types.NodeSocket:
    """A metal without extinction. Metallic nodes have no weight: what is missing to 1 is mixed off, what is more is added."""
    assert HAS_DIELECTRIC and is_grey_dielectric(table), "see reference_py.lobes.tabulate"
    closures = []
    for weight in (np.minimum(table.weight, 1.0), np.maximum(table.weight - 1.0, 0.0)):
        if np.all(weight == 1.0):
            closures.append(_bare_dielectric(build, view, table))
        elif np.any(weight > 0.0):
            share, _, _ = columns_at(build, view, weight)
            mix = build.shader("ShaderNodeMixShader", share)
            build.link(_bare_dielectric(build, view, table), mix.node.inputs[2])
            closures.append(mix)
    return build.sum(closures)


def _bare_dielectric(build: Builder, view: View, table: GlossyTable) -> bpy.types.NodeSocket:
    alpha, _, _ = columns_at(build, view, table.shape)
    return metallic_node(build, view, table.distribution, (table.fresnel.eta,) * 3, (0.0,) * 3, build.math("SQRT", alpha), table.shape)


def metallic_node(build: Builder, view: View, distribution: str, index, extinction, roughness, shape: np.ndarray) -> bpy.types.NodeSocket:
    """A Metallic node of these operands; `shape` (n, 3) is all that its alphas can be."""
    sockets = {"IOR": index, "Extinction": extinction, "Roughness": roughness, "Anisotropy": 0.0} | view.own_normal
    if SPECULAR_ALPHA < np.min(shape[:, 0]) < _NARROW_DIELECTRIC_ALPHA:
        # as a constant, Cycles would take so little for none; no place is as small
        sockets |= {"Anisotropy": build.math("MINIMUM", view.place, _SLIGHT_ANISOTROPY), "Tangent": view.tangent}
    settings = {"distribution": DISTRIBUTIONS[distribution], "fresnel_type": "PHYSICAL_CONDUCTOR"}
    return build.shader("ShaderNodeBsdfMetallic", settings=settings, **sockets)


def anisotropy_of(build: Builder, ratio: Callable, x, y, shape: np.ndarray) -> bpy.types.NodeSocket:
    """Cycles' alphas are R (1 - a) and R / (1 - a) for a > 0, R / (1 + a) and R (1 + a) for a < 0.

    So a = (1 - s) / max(s, 1) with s = sqrt(alpha_x / alpha_y), and R = sqrt(alpha_x alpha_y). Of most lobes one side is enough.
    `ratio` gives s, or one over it, of two operands.
    """
    if np.all(shape[:, 0] <= shape[:, 1]):
        return build.math("SUBTRACT", 1.0, ratio(x, y))
    if np.all(shape[:, 0] >= shape[:, 1]):
        return build.math("SUBTRACT", ratio(y, x), 1.0)
    s = ratio(x, y)
    return build.math("DIVIDE", build.math("SUBTRACT", 1.0, s), build.math("MAXIMUM", s, 1.0))


def _kept_apart(build: Builder, anisotropy, alphas: np.ndarray):
    """The anisotropy, for a narrow lobe not so small that Cycles takes it for isotropic."""
    if not SPECULAR_ALPHA < np.min(alphas) < NARROW_ALPHA:
        return anisotropy
    across = np.log(alphas[:, 1] / alphas[:, 0])
    if np.min(across) > -_NEARLY_ISOTROPIC:
        return build.math("MAXIMUM", anisotropy, _LEAST_ANISOTROPY)
    if np.max(across) < _NEARLY_ISOTROPIC:
        return build.math("MINIMUM", anisotropy, -_LEAST_ANISOTROPY)
    return anisotropy
