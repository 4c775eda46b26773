# SPDX-License-Identifier: GPL-3.0-or-later
"""The nodes that read a table's image between its texels, at places given as shares of its width and height.

An Image Texture is quick and reads four numbers at once. In EEVEE it reads smaller copies of the image where places are far apart from one pixel
to the next, which are of other numbers; an Environment Texture does not. A direction of any length stands for a place there:
(cos p, sin p, tan t), with p around and t up.
"""

import math
from abc import ABC, abstractmethod

import bpy

from .node_builder import Builder


class Lookup(ABC):
    """One kind of nodes: how many numbers a texel has for it, and what the shares of width and height are multiplied by and added to before."""

    numbers: int
    across: tuple[float, float]
    up: tuple[float, float]

    @abstractmethod
    def place_across(self, build: Builder, share: bpy.types.NodeSocket) -> tuple[bpy.types.NodeSocket, ...]:
        """The first parts of a place."""

    @abstractmethod
    def place_up(self, build: Builder, share: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        """The last part."""

    @abstractmethod
    def node(self, build: Builder, image: bpy.types.Image) -> bpy.types.Node:
        """A node that reads an image at the place that its "Vector" gets."""


class ImageLookup(Lookup):
    """Image Textures, for Cycles."""

    numbers, across, up = 4, (1.0, 0.0), (1.0, 0.0)

    def place_across(self, build: Builder, share: bpy.types.NodeSocket) -> tuple[bpy.types.NodeSocket, ...]:
        """As in `Lookup`."""
        return (share,)

    def place_up(self, build: Builder, share: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        """As in `Lookup`."""
        return share

    def node(self, build: Builder, image: bpy.types.Image) -> bpy.types.Node:
        """As in `Lookup`."""
        node = build.node("ShaderNodeTexImage")
        node.image, node.interpolation, node.projection, node.extension = image, "Linear", "FLAT", "EXTEND"
        return node


class EnvironmentLookup(Lookup):
    """Environment Textures, for EEVEE too."""

    numbers, across, up = 3, (-2.0 * math.pi, math.pi), (math.pi, -0.5 * math.pi)

    def place_across(self, build: Builder, share: bpy.types.NodeSocket) -> tuple[bpy.types.NodeSocket, ...]:
        """As in `Lookup`."""
        return build.math("COSINE", share), build.math("SINE", share)

    def place_up(self, build: Builder, share: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        """As in `Lookup`."""
        return build.math("TANGENT", share)

    def node(self, build: Builder, image: bpy.types.Image) -> bpy.types.Node:
        """As in `Lookup`."""
        node = build.node("ShaderNodeTexEnvironment")
        node.image, node.interpolation, node.projection = image, "Linear", "EQUIRECTANGULAR"
        return node
