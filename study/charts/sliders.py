# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina chart sliders`: the manual's strips, five renders for each parameter of a layer and of a base."""

from pathlib import Path

from ...addon.session import blender
from ...reference_py.atomic import require_writable
from ...reference_py.material.stack import Stack
from ..tables import Report

TILE, SAMPLES = 128, 96

_PAINT = {"kind": "lambert", "color": [0.45, 0.12, 0.06]}
_CLAY = {"kind": "oren_nayar", "color": [0.7, 0.45, 0.25]}
_METAL = {"kind": "conductor", "metal": "aluminium", "roughness": 0.35}
_OWN_METAL = {"kind": "conductor", "reflectance": [0.9, 0.6, 0.3], "edge_color": [0.9, 0.8, 0.7], "roughness": 0.35}
_VARNISH = {"kind": "dielectric", "roughness": 0.15}
_GLAZE = {"kind": "dielectric", "tint": [0.35, 0.62, 0.8]}
_MILK = {"kind": "dielectric", "scatter_color": [0.75, 0.85, 0.9], "density": 1.0, "scatter_g": 0.0}
_RAW_MILK = {"kind": "dielectric", "extinction": [1.0, 1.0, 1.0], "scatter_albedo": [0.9, 0.9, 0.9], "scatter_g": 0.0}
_OXIDE = {"kind": "conductor", "metal": "titanium", "roughness": 0.25, "film_thickness": 150.0, "film_ior": 2.4}
_BRUSHED = {"kind": "conductor", "metal": "aluminium", "roughness": 0.5, "anisotropy": 0.9, "rotation": 0.0}

# Name of a parameter: the layer or None, the base, and the five values of its strip.
STRIPS: dict[str, tuple[dict | None, dict, tuple]] = {
    "ior": (_VARNISH, _PAINT, (1.1, 1.33, 1.5, 1.8, 2.4)),
    "roughness": (_VARNISH, _PAINT, (0.0, 0.15, 0.3, 0.5, 0.8)),
    "tint": (_GLAZE, _METAL, ([1.0, 1.0, 1.0], [0.8, 0.9, 0.95], [0.35, 0.62, 0.8], [0.8, 0.45, 0.1], [0.5, 0.03, 0.05])),
    "thickness": (_GLAZE, _METAL, (0.0, 0.3, 1.0, 2.0, 4.0)),
    "distribution": (_VARNISH | {"roughness": 0.4}, _METAL, ("ggx", "beckmann")),
    "coverage": (_GLAZE | {"coverage": 1.0}, _METAL, (0.0, 0.25, 0.5, 0.75, 1.0)),
    "anisotropy": (None, _BRUSHED, (0.0, 0.3, 0.6, 0.8, 1.0)),
    "rotation": (None, _BRUSHED, (0.0, 0.125, 0.25, 0.375, 0.5)),
    "film_thickness": (None, _OXIDE, (0.0, 30.0, 60.0, 120.0, 240.0)),
    "film_ior": (None, _OXIDE, (1.0, 1.2, 1.33, 1.8, 2.4)),
    "scatter_color": (_MILK | {"density": 3.0}, _PAINT, ([0.95, 0.95, 0.95], [0.75, 0.85, 0.9], [0.9, 0.7, 0.4], [0.5, 0.75, 0.55], [0.3, 0.3, 0.3])),
    "density": (_MILK, _PAINT, (0.0, 0.3, 1.0, 3.0, 20.0)),
    "scatter_g": (_MILK, _PAINT, (-0.8, -0.4, 0.0, 0.5, 0.9)),
    "extinction": (_RAW_MILK, _PAINT, ([0.0, 0.0, 0.0], [0.3, 0.3, 0.3], [1.0, 1.0, 1.0], [0.3, 1.0, 3.0], [9.0, 9.0, 9.0])),
    "scatter_albedo": (_RAW_MILK | {"extinction": [3.0] * 3}, _PAINT, ([0.0] * 3, [0.5] * 3, [0.9] * 3, [0.99, 0.95, 0.85], [1.0] * 3)),
    "color": (_VARNISH, _PAINT, ([0.02, 0.02, 0.02], [0.45, 0.12, 0.06], [0.06, 0.2, 0.4], [0.7, 0.5, 0.1], [0.8, 0.8, 0.8])),
    "sigma_deg": (None, _CLAY, (0.0, 10.0, 20.0, 40.0, 80.0)),
    "metal": (None, _METAL, ("silver", "gold", "copper", "iron", "titanium")),
    "reflectance": (None, _OWN_METAL, ([0.9, 0.6, 0.3], [0.95, 0.85, 0.6], [0.6, 0.6, 0.62], [0.3, 0.4, 0.6], [0.2, 0.2, 0.2])),
    "edge_color": (None, _OWN_METAL, ([0.0, 0.0, 0.0], [0.5, 0.5, 0.5], [0.9, 0.8, 0.7], [0.4, 0.7, 1.0], [1.0, 1.0, 1.0])),
    "eta": (None, {"kind": "conductor", "eta": [1.0] * 3, "k": [3.0] * 3, "roughness": 0.35}, ([0.2] * 3, [0.6] * 3, [1.0] * 3, [2.0] * 3, [4.0] * 3)),
    "k": (None, {"kind": "conductor", "eta": [1.0] * 3, "k": [3.0] * 3, "roughness": 0.35}, ([0.5] * 3, [1.0] * 3, [2.0] * 3, [4.0] * 3, [2.0, 3.0, 6.0])),
}  # fmt: skip
# Strips whose parameter is the base's; those of the others are the layer's.
OF_THE_BASE = ("anisotropy", "rotation", "film_thickness", "film_ior", "color", "sigma_deg", "metal", "reflectance", "edge_color", "eta", "k")


def stack_of(name: str, value) -> Stack:
    """The stack of one picture of a strip. Raises LaminaError as Stack does."""
    layer, base, _ = STRIPS[name]
    if name in OF_THE_BASE:
        base = base | {name: value}
    else:
        layer = layer | {name: value}
    return Stack.from_dict({"layers": [layer] if layer else [], "base": base})


def words(value) -> str:
    """A value as it stands below its picture."""
    if isinstance(value, list):
        return f"{value[0]:g}" if len(set(value)) == 1 else " ".join(f"{v:g}" for v in value)
    return value if isinstance(value, str) else f"{value:g}"


def chart(folder: Path, report: Report) -> None:
    """Write slider_NAME.png for each parameter. Raises LaminaError without Blender or for a folder that cannot be written to."""
    for name in STRIPS:
        require_writable(folder / f"slider_{name}.png")
    with blender(lambda text: None):
        _render(folder, report)


def _render(folder: Path, report: Report) -> None:
    import bpy

    from ...addon.material.material import apply_stack, refresh
    from ...addon.rendering.sheet import Tile, render_sheet

    for number, (name, (_, _, values)) in enumerate(STRIPS.items()):
        report(f"{100 * number // len(STRIPS):3} % {name}")
        tiles = []
        for value in values:
            material = bpy.data.materials.new(name)
            apply_stack(material, stack_of(name, value))
            refresh(material, settle=True)
            tiles.append(Tile(words(value), material))
        render_sheet(tiles, folder / f"slider_{name}.png", 5, TILE, SAMPLES)
        bpy.data.batch_remove([tile.material for tile in tiles])
