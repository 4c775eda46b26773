# SPDX-License-Identifier: GPL-3.0-or-later
"""A bare Oren-Nayar base as stock nodes, which compute with its color and its slope deviation as they come in (`reference_py.optics.diffuse`)."""

import bpy
import numpy as np

from ....reference_py.lobes.view_table import KNOTS, RoughBase, knot_cosines
from ....reference_py.optics.diffuse import FACTORS_1994, G_AT_HORIZON, MEAN_G, OREN_NAYAR_POWER, directional_g
from ..inputs import base_slopes_input
from ..working_space import REC709, primaries, working_space
from .node_builder import Builder
from .view_nodes import STEP, View, in_space, numbers


def rough_base(build: Builder, view: View, table: RoughBase, owner: str) -> bpy.types.NodeSocket:
    """The closure of the base, or of the opaque layer, of an owner."""
    color, slopes = view.base_color(owner), view.given(base_slopes_input(owner))
    roughness = _fujii_roughness(build, build.math("MINIMUM", build.math("MAXIMUM", slopes, 0.0), base_slopes_input(owner).parameter.maximum))
    if not table.is_lambert and table.power == OREN_NAYAR_POWER and working_space() == REC709:
        return build.shader("ShaderNodeBsdfDiffuse", Color=color, Roughness=roughness, **view.own_normal)
    albedo = _Albedo(build, view, roughness)
    energy = in_space(build, albedo.of(color, OREN_NAYAR_POWER), primaries())
    if table.is_lambert:
        return build.shader("ShaderNodeBsdfDiffuse", Color=energy, Roughness=0.0, **view.own_normal)
    # one of Newton's steps to the color that has this energy: what is left is 4e-4 of it at most
    start = in_space(build, color, primaries())
    missing = build.vector("SUBTRACT", energy, albedo.of(start, table.power))
    seen = build.vector("ADD", start, build.vector("DIVIDE", missing, albedo.slope(start, table.power)))
    return build.shader("ShaderNodeBsdfDiffuse", Color=build.vector("MAXIMUM", seen, 0.0), Roughness=roughness, **view.own_normal)


def _fujii_roughness(build: Builder, sigma_deg: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
    sigma = build.math("MULTIPLY", sigma_deg, float(np.radians(1.0)))
    sigma2 = build.math("MULTIPLY", sigma, sigma)
    less, b = (build.math("DIVIDE", build.math("MULTIPLY", sigma2, factor), build.math("ADD", sigma2, offset)) for factor, offset in FACTORS_1994)
    return build.math("DIVIDE", b, build.math("SUBTRACT", 1.0, less))


class _Albedo:
    """Energies of colors at the view, as sockets."""

    def __init__(self, build: Builder, view: View, roughness: bpy.types.NodeSocket):
        self._build = build
        (g,) = numbers(build, view.place, STEP * np.arange(KNOTS), directional_g(knot_cosines())[:, None])
        whole = build.math("MULTIPLY_ADD", roughness, G_AT_HORIZON, np.pi)
        self._single, mean = (build.math("DIVIDE", build.math("MULTIPLY_ADD", roughness, of, np.pi), whole) for of in (g, MEAN_G))
        self._others, self._short = build.math("MULTIPLY", mean, build.math("SUBTRACT", 1.0, self._single)), build.math("SUBTRACT", 1.0, mean)

    def of(self, color: bpy.types.NodeSocket, power: int) -> bpy.types.NodeSocket:
        """That of `oren_nayar_albedo`."""
        return self._build.vector("MULTIPLY", color, self._build.vector("ADD", self._single, self._multiple(color, power)))

    def slope(self, color: bpy.types.NodeSocket, power: int) -> bpy.types.NodeSocket:
        """How fast it grows with the color."""
        build = self._build
        rise = build.vector("ADD", build.vector("DIVIDE", build.vector("SCALE", color, scale=self._short), self._rest(color)), float(power))
        return build.vector("MULTIPLY_ADD", self._multiple(color, power), rise, self._single)

    def _multiple(self, color: bpy.types.NodeSocket, power: int) -> bpy.types.NodeSocket:
        """What meets several facets, over the color."""
        build, seen = self._build, color
        for _ in range(power - 2):
            seen = build.vector("MULTIPLY", seen, color)
        return build.vector("SCALE", build.vector("DIVIDE", seen, self._rest(color)), scale=self._others)

    def _rest(self, color: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        return self._build.vector("SUBTRACT", 1.0, self._build.vector("SCALE", color, scale=self._short))
