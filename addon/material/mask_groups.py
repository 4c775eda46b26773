# SPDX-License-Identifier: GPL-3.0-or-later
"""The node groups that draw masks, made by code: one output, and a socket for each value of the generator.

A pattern is noise that is cut where it exceeds what leaves the wanted share, and what draws the mask (edges, cavities, what faces up)
is added to the noise before. Places are the object's own, in its largest dimension, which Cycles and EEVEE read from the object.
"""

import bpy

from ...reference_py.material.masks import Generator
from ..shader.nodes.node_builder import Builder

MASK_KEY = "lamina_mask"
OUTPUT = "Mask"
# What a bake gives in place of the pattern, and whether it does. Cycles drops the other one, and all that it costs.
BAKED, USE_BAKED = "Baked", "Use Baked"
# Detail and roughness of the noise, and the standard deviation that Blender's has then, about a mean of .5 (measured: 256 x 256 points, 4.5 and 5.3).
_DETAIL, _ROUGHNESS, _DEVIATION = 8.0, 0.65, 0.0589
# Quantiles of the normal distribution by the logistic one's (Johnson, Kotz and Balakrishnan 1995, 22.4: within .01 of the share).
_LOGISTIC = 1.702
_LEAST_AMOUNT, _LEAST_SOFTNESS = 1e-4, 1e-3
_SAMPLES = 6
# From here to there the normal that a bevel turns is an edge: 1 - the cosine between the two.
_EDGE = (0.004, 0.12)


def mask_group(generator: Generator) -> bpy.types.NodeTree:
    """This file's group of a generator, made where there is none."""
    own = (g for g in bpy.data.node_groups if g.get(MASK_KEY) == generator.name and g.is_editable)
    tree = next((g for g in own if _declares(g, generator)), None)
    if tree is not None:
        return tree
    tree = bpy.data.node_groups.new(f"Lamina {generator.label}", "ShaderNodeTree")
    tree[MASK_KEY] = generator.name
    try:
        _build(tree, generator)
    except Exception:
        bpy.data.node_groups.remove(tree)
        raise
    return tree


def _declares(tree, generator: Generator) -> bool:
    names = {item.name for item in tree.interface.items_tree if item.in_out == "INPUT"}
    return {p.label for p in generator.parameters} | {BAKED, USE_BAKED} <= names


def _build(tree, generator: Generator) -> None:
    for parameter in generator.parameters:
        socket = tree.interface.new_socket(parameter.label, in_out="INPUT", socket_type="NodeSocketFloat")
        socket.default_value, socket.min_value, socket.max_value = parameter.default, parameter.minimum, parameter.maximum
        socket.description = parameter.help
        socket.subtype = "FACTOR" if parameter.maximum == 1.0 else "NONE"
    for name, text in ((BAKED, "What Bake Masks wrote, in place of the pattern"), (USE_BAKED, "1 shows what Bake Masks wrote, 0 the live pattern")):
        socket = tree.interface.new_socket(name, in_out="INPUT", socket_type="NodeSocketFloat")
        socket.min_value, socket.max_value, socket.subtype, socket.description = 0.0, 1.0, "FACTOR", text
    tree.interface.new_socket(OUTPUT, in_out="OUTPUT", socket_type="NodeSocketFloat")
    draw = _Draw(tree)
    given = draw.given
    live = getattr(draw, generator.name)()
    drawn = draw.mixed(live, given[BAKED], given[USE_BAKED])
    value = draw.math("MULTIPLY_ADD", drawn, draw.math("SUBTRACT", given["High"], given["Low"]), given["Low"])
    draw.link(value, draw.node("NodeGroupOutput").inputs[OUTPUT])
    draw.arrange()


class _Draw(Builder):
    """What the generators are made of. Each method of a generator's name gives its pattern's output, 0 to 1."""

    def __init__(self, tree):
        super().__init__(tree)
        self.given = self.node("NodeGroupInput").outputs
        self._size = None

    def patches(self):
        return self._cut(self._noise(self._place()))

    def edges(self):
        # rounded off, a normal turns at every edge; where it hardly sees the surface itself the edge is a groove
        width = self.math("MULTIPLY", self.given["Width"], self._largest())
        bevel, geometry = self.node("ShaderNodeBevel"), self.node("ShaderNodeNewGeometry")
        bevel.samples = _SAMPLES
        self.link(width, bevel.inputs["Radius"])
        turned = self.math("SUBTRACT", 1.0, self.vector("DOT_PRODUCT", bevel.outputs["Normal"], geometry.outputs["Normal"]))
        edge = self.math("MULTIPLY", self._step(turned, *_EDGE), self._step(self._open(width), 0.7, 0.95))
        return self._cut(self._noise(self._place()), edge)

    def cavities(self):
        closed = self.math("SUBTRACT", 1.0, self._open(self.math("MULTIPLY", self.given["Width"], self._largest())))
        return self._cut(self._noise(self._place()), closed)

    def settled(self):
        up = self._split(self.node("ShaderNodeNewGeometry").outputs["Normal"])[2]
        turned_away = self.math("SUBTRACT", self._step(up, 0.0, 0.9), 1.0)
        return self.math("MULTIPLY", self._cut(self._noise(self._place()), turned_away), self._step(up, -0.1, 0.3))

    def drips(self):
        x, y, z = self._split(self._place())
        drawn_out = self.combined((x, y, self.math("DIVIDE", z, self.given["Length"])))
        normal = self.node("ShaderNodeVectorTransform")
        normal.vector_type, normal.convert_from, normal.convert_to = "NORMAL", "WORLD", "OBJECT"
        self.link(self.node("ShaderNodeNewGeometry").outputs["Normal"], normal.inputs[0])
        up = self._split(normal.outputs[0])[2]
        upright = self._step(self.math("ABSOLUTE", up), 0.9, 0.5)
        return self.math("MULTIPLY", self._cut(self._noise(drawn_out)), upright)

    def fingerprints(self):
        place = self._place()
        cells = self.node("ShaderNodeTexVoronoi")
        cells.inputs["Scale"].default_value = 1.0
        self.link(place, cells.inputs["Vector"])
        kept = self.node("ShaderNodeTexWhiteNoise")
        self.link(cells.outputs["Position"], kept.inputs["Vector"])
        is_kept = self.math("LESS_THAN", kept.outputs["Value"], self.given["Amount"])
        # seen from the middle of its cell; a bent distance bends the ridges
        here = self.vector("SUBTRACT", place, cells.outputs["Position"])
        x, y, z = self._split(here)
        oval = self.combined((self.math("MULTIPLY", x, 1.3), self.math("MULTIPLY", y, 1.3), z))
        bent = self.math("SUBTRACT", self._noise(self.vector("SCALE", place, scale=1.5), detail=1.0), 0.5)
        distance = self.math("MULTIPLY_ADD", bent, 0.35, self.vector("LENGTH", oval))
        reach = 0.42
        turns = self.math("MULTIPLY", distance, self.math("MULTIPLY", self.given["Ridges"], 6.2831853 / reach))
        ridge = self.math("MULTIPLY_ADD", self.math("SINE", turns), 0.5, 0.5)
        rim = self._step(distance, reach, self.math("MULTIPLY", reach, self.math("SUBTRACT", 0.98, self.math("MULTIPLY", self.given["Softness"], 0.9))))
        skin = self._step(self._noise(self.vector("SCALE", place, scale=6.0)), 0.4, 0.52)
        return self.math("MULTIPLY", self.math("MULTIPLY", rim, is_kept), self.math("MULTIPLY", self._step(ridge, 0.25, 0.75), skin))

    def mixed(self, live, baked, share):
        mix = self.node("ShaderNodeMix")
        for socket, source in zip(mix.inputs, (share, None, live, baked)):
            if source is not None:
                self.link(source, socket)
        return mix.outputs[0]

    def _dimensions(self) -> bpy.types.NodeSocket:
        node = self.node("ShaderNodeAttribute")
        node.attribute_type, node.attribute_name = "OBJECT", "dimensions"
        return node.outputs["Vector"]

    def _largest(self):
        """The object's largest dimension in the scene's units; 1 of what has none."""
        if self._size is None:
            x, y, z = self._split(self._dimensions())
            largest = self.math("MAXIMUM", self.math("MAXIMUM", x, y), z)
            self._size = self.math("ADD", largest, self.math("LESS_THAN", largest, 1e-9))
        return self._size

    def _place(self):
        """Where on the object, in its largest dimension times Scale, shifted by Seed."""
        per_size = self.math("DIVIDE", self.given["Scale"], self._largest())
        own = self.vector("MULTIPLY", self.node("ShaderNodeTexCoord").outputs["Generated"], self._dimensions())
        shift = self.math("MULTIPLY", self.given["Seed"], 13.7)
        return self.vector("ADD", self.vector("SCALE", own, scale=per_size), self.combined((shift, shift, shift)))

    def _noise(self, place, detail: float = _DETAIL):
        noise = self.node("ShaderNodeTexNoise")
        noise.inputs["Scale"].default_value, noise.inputs["Detail"].default_value, noise.inputs["Roughness"].default_value = 1.0, detail, _ROUGHNESS
        self.link(place, noise.inputs["Vector"])
        return noise.outputs[0]

    def _cut(self, noise, drawing=None):
        """Where the noise is among its highest Amount; what draws the mask lifts it by Pull standard deviations."""
        share = self.math("MINIMUM", self.math("MAXIMUM", self.given["Amount"], _LEAST_AMOUNT), 1.0 - _LEAST_AMOUNT)
        odds = self.math("DIVIDE", self.math("SUBTRACT", 1.0, share), share)
        bound = self.math("DIVIDE", self.math("LOGARITHM", odds, 2.718281828), _LOGISTIC)
        height = self.math("DIVIDE", self.math("SUBTRACT", noise, 0.5), _DEVIATION)
        if drawing is not None:
            height = self.math("MULTIPLY_ADD", drawing, self.given["Pull"], height)
        soft = self.math("MAXIMUM", self.given["Softness"], _LEAST_SOFTNESS)
        cut = self._step(self.math("SUBTRACT", height, bound), self.math("MULTIPLY", soft, -1.0), soft)
        return self.math("MULTIPLY", cut, self.math("GREATER_THAN", self.given["Amount"], 0.0))

    def _open(self, distance):
        """How much of the sky a point sees past its own object."""
        sky = self.node("ShaderNodeAmbientOcclusion")
        sky.samples, sky.only_local = _SAMPLES, True
        self.link(distance, sky.inputs["Distance"])
        return sky.outputs["AO"]

    def _step(self, value, low, high):
        """0 to 1 from `low` to `high`, smoothly."""
        node = self.node("ShaderNodeMapRange")
        node.interpolation_type = "SMOOTHSTEP"
        for name, operand in (("Value", value), ("From Min", low), ("From Max", high)):
            self._give(operand, node.inputs[name])
        return node.outputs["Result"]

    def _split(self, vector):
        node = self.node("ShaderNodeSeparateXYZ")
        self.link(vector, node.inputs[0])
        return node.outputs[0], node.outputs[1], node.outputs[2]
