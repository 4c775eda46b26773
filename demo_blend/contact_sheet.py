# SPDX-License-Identifier: GPL-3.0-or-later
"""The contact sheet: ten looks on the same ball, on one page. Run with the bpy wheel:

    python -m lamina.demo_blend.contact_sheet OUT.png [--tile 320] [--samples 24] [--columns 5]
"""

import argparse

import bpy

from ..addon.rendering.environment import ensure_osl_query_on_path
from ..addon.rendering.settings import node_tree
from ..addon.rendering.sheet import Tile, render_sheet
from ..reference_py.errors import LaminaError

# label, note, inputs of the stock Principled BSDF (colours linear)
STOCK = [
    ("Coated red paint", "clear coat over matt", {"Base Color": (0.52, 0.008, 0.01), "Roughness": 0.6,
                                                  "Coat Weight": 1.0}),
    ("Copper", "polished", {"Base Color": (0.95, 0.56, 0.41), "Metallic": 1.0, "Roughness": 0.12}),
    ("Frosted metal", "bead blasted", {"Base Color": (0.8, 0.81, 0.82), "Metallic": 1.0, "Roughness": 0.42}),
    ("Car paint", "metallic blue", {"Base Color": (0.01, 0.09, 0.36), "Metallic": 0.85, "Roughness": 0.38,
                                    "Coat Weight": 1.0}),
    ("Porcelain", "glazed white", {"Base Color": (0.8, 0.78, 0.74), "Roughness": 0.55, "Coat Weight": 1.0}),
    ("Gold", "satin", {"Base Color": (1.0, 0.72, 0.29), "Metallic": 1.0, "Roughness": 0.26}),
    ("Chrome", "mirror", {"Base Color": (0.86, 0.87, 0.88), "Metallic": 1.0, "Roughness": 0.03}),
    ("British green", "car paint", {"Base Color": (0.004, 0.06, 0.022), "Metallic": 0.5, "Roughness": 0.4,
                                    "Coat Weight": 1.0}),
    ("Black lacquer", "piano finish", {"Base Color": (0.004, 0.004, 0.005), "Roughness": 0.3, "Coat Weight": 1.0}),
    ("Terracotta", "unglazed", {"Base Color": (0.42, 0.12, 0.05), "Roughness": 0.85}),
]


def stock_tile(label: str, note: str, inputs: dict[str, float | tuple[float, ...]]) -> Tile:
    """Tile with a stock Principled BSDF; colours are given without alpha."""
    material = bpy.data.materials.new(label)
    shader = next(node for node in node_tree(material).nodes if node.type == "BSDF_PRINCIPLED")
    for name, value in inputs.items():
        shader.inputs[name].default_value = (*value, 1.0) if isinstance(value, tuple) else value
    return Tile(label, material, note)


def main() -> int:
    parser = argparse.ArgumentParser(description="Render ten looks on one page.")
    parser.add_argument("out", help="PNG to write")
    parser.add_argument("--tile", type=int, default=240, help="pixels along a tile's side")
    parser.add_argument("--samples", type=int, default=24)
    parser.add_argument("--columns", type=int, default=5)
    given = parser.parse_args()
    ensure_osl_query_on_path()
    try:
        render_sheet([stock_tile(*row) for row in STOCK], given.out, given.columns, given.tile, given.samples,
                     lambda done, text: print(f"{done:4.0%} {text}", flush=True), title="Ten stock materials")
    except LaminaError as error:
        print(f"error: {error}")
        return 1
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
