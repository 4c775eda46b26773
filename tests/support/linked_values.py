# SPDX-License-Identifier: GPL-3.0-or-later
"""Values of layers that come in through sockets, as from textures."""

from lamina.addon.material.elements import node_of


def link_values(material, links: dict[tuple[int | None, str], float | tuple[float, ...]]) -> None:
    """Link sockets, by a layer's number or None for the base and their label, to nodes of these values, which the sockets get too."""
    for (number, label), value in links.items():
        color = isinstance(value, tuple)
        source = material.node_tree.nodes.new("ShaderNodeRGB" if color else "ShaderNodeValue")
        socket = node_of(material.lamina.base if number is None else material.lamina.layers[number]).inputs[label]
        source.outputs[0].default_value = socket.default_value = (*value, 1.0) if color else value
        material.node_tree.links.new(source.outputs[0], socket)
