# SPDX-License-Identifier: GPL-3.0-or-later
"""What differs between the versions of Blender that Lamina runs in: 4.5, 5.0, 5.1, 5.2 and 5.3."""

import bpy

from ...reference_py.optics.diffuse import CYCLES_5_2_POWER, OREN_NAYAR_POWER

# From 5.0 on Cycles' Metallic node has the exact Fresnel equations, and no extinction makes a metal a dielectric.
HAS_DIELECTRIC = bpy.app.version >= (5, 0, 0)
# Whether Principled has films on metals, and not on dielectrics alone.
HAS_METAL_FILMS = bpy.app.version >= (5, 0, 0)
# Of the color of a rough Diffuse node, in light that meets several facets.
DIFFUSE_POWER = OREN_NAYAR_POWER if bpy.app.version >= (5, 3, 0) else CYCLES_5_2_POWER


def node_tree(owner: bpy.types.ID) -> bpy.types.NodeTree:
    """Node tree of a new material, world or light, made when there is none.

    From Blender 5.0 on new materials and worlds have one, and setting `use_nodes` is deprecated.
    """
    if owner.node_tree is None:
        owner.use_nodes = True
    return owner.node_tree


def set_media_type(image: bpy.types.ImageFormatSettings, media_type: str) -> None:
    """Say what a render writes before its format, which Blender 5.0 and later refuse otherwise."""
    if hasattr(image, "media_type"):
        image.media_type = media_type
