# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina chart closures`: the layered closures of Cycles' OSL, rendered, beside Lamina's lobe sets: albedo against the truth.

Each Blender has its own rows: `coat_bsdf`, films on `dielectric_bsdf` and a `layer()` of finer tables are of 5.3. What only one Blender has is in no
material that Lamina makes, as a saved file is to render the same in all.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ...reference_py.atomic import require_writable
from ...reference_py.material.stack import Stack
from ...reference_py.optics.error_measure import albedo_error
from ...reference_py.optics.frame import spherical
from ...reference_py.registry import make_model
from ..tables import Report, read_table, write_table
from .output import print_table

VIEWS_DEG = (0.0, 45.0, 75.0)
COLUMNS = ("blender", "surface", "closures", *(f"error_{view:g}" for view in VIEWS_DEG))
HEADING = (
    "lamina chart closures -o figures",
    "directional albedo in a white world, relative error of the worst channel at each view in degrees; truth: adding, of anisotropy position_free",
    "cycles: as a user of OSL writes it; lamina: closure_model of the lobe set that a new material gets, which equals its render to 1e-4",
)
_WALKS = 1 << 17
_SAMPLES, _SIZE = 64, 48


def _stack(base: dict, **layer) -> Stack:
    return Stack.from_dict({"layers": [{"kind": "dielectric", "ior": 1.5, **layer}], "base": base})


_PAINT, _BLACK = {"kind": "lambert", "color": [0.8, 0.3, 0.1]}, {"kind": "lambert", "color": [0.0] * 3}
_GOLD = {"kind": "conductor", "metal": "gold", "roughness": 0.4}
_ROUGH, _FILM = 0.6, (400.0, 1.8)
SURFACES = {
    "smooth coat over paint": _stack(_PAINT, roughness=0.0),
    "rough coat over paint": _stack(_PAINT, roughness=_ROUGH),
    "rough coat over gold": _stack(_GOLD, roughness=_ROUGH),
    "tinted coat over paint": _stack(_PAINT, roughness=0.2, tint=[0.9, 0.6, 0.3]),
    "film on a rough dielectric": _stack(_BLACK, roughness=0.4, film_thickness=_FILM[0], film_ior=_FILM[1]),
    "brushed dielectric": _stack(_BLACK, roughness=_ROUGH, anisotropy=0.8),
}


def chart(folder: Path, report: Report) -> None:
    """Write closures.csv, with this Blender's rows anew, and print it."""
    from ...addon.session import blender

    table = folder / "closures.csv"
    require_writable(table)
    with blender(report):
        import bpy

        version = ".".join(map(str, bpy.app.version[:2]))
        own = list(rows(version, report))
    kept = [[row[name] for name in COLUMNS] for row in (read_table(table) if table.exists() else ()) if row["blender"] not in (version, "all")]
    found = sorted(kept + [row for row in own if row[0] == version]) + [row for row in own if row[0] == "all"]
    print_table(COLUMNS, found)
    write_table(table, HEADING, COLUMNS, found, report)


def rows(version: str, report: Report) -> Iterator[list[str]]:
    """One row for each surface and way to write it; Lamina's are of all Blenders."""
    from ...addon.rendering.measure import render_furnace
    from ..pareto.compared_materials import script_material

    wo = spherical(np.radians(VIEWS_DEG), 0.0)
    for surface, stack in SURFACES.items():
        report(surface)
        exact = truth(stack).albedo(wo)
        for number, (name, text) in enumerate(texts(stack, version).items()):
            tag = f"closures_{len(surface)}_{number}"
            mean, _ = render_furnace(script_material(tag, text.replace("NAME", tag)), VIEWS_DEG, _SAMPLES, _SIZE)
            yield [version, surface, f"cycles {name}", *_errors(mean, exact)]
        yield ["all", surface, "lamina", *_errors(make_model("closure_model", stack, method="baked").albedo(wo), exact)]


def truth(stack: Stack):
    """`adding`, or the walks where it does not know a feature."""
    knows = "anisotropy" not in stack.layers[0].values
    return make_model("adding", stack) if knows else make_model("position_free", stack, walks=_WALKS)


def texts(stack: Stack, version: str) -> dict[str, str]:
    """Shaders called NAME, by what they are made of."""
    from ..pareto.compared_materials import base_closure, layer_text

    layer, (interface,) = stack.layers[0], _interfaces(stack)
    if "film_thickness" in layer:
        # a whole number would be an int, which is no film's
        film = f', "thinfilm_thickness", float({layer["film_thickness"]:g}), "thinfilm_ior", float({layer["film_ior"]:g})'
        return {"dielectric_bsdf": _shader(_dielectric(interface.alpha, interface.alpha, interface.eta, film))}
    if "anisotropy" in layer:
        widths = interface.facets.anisotropic
        return {"dielectric_bsdf": _shader(_dielectric(widths.alpha_x, widths.alpha_y, interface.eta))}
    found = {"layer": layer_text(stack, "NAME")}
    if version >= "5.3":
        tint = "color(" + ", ".join(f"{v:.9g}" for v in np.exp(-2.0 * interface.tau)) + ")"
        found["coat_bsdf"] = _shader(f"layer(coat_bsdf(color(1), {interface.eta:.9g}, {interface.alpha**0.5:.9g}, N), {tint} * {base_closure(stack)})")
    return found


def _interfaces(stack: Stack):
    from ...reference_py.optics.optical_stack import OpticalStack

    return OpticalStack.of(stack).interfaces


def _dielectric(along: float, across: float, eta: float, more: str = "") -> str:
    return f'dielectric_bsdf(N, U, color(1), color(0), {along:.9g}, {across:.9g}, {eta:.9g}, "multi_ggx"{more})'


def _shader(closure: str) -> str:
    return f"shader NAME(output closure color BSDF = 0) {{ vector U = normalize(dPdu); BSDF = {closure}; }}"


def _errors(found: np.ndarray, exact: np.ndarray) -> list[str]:
    return [f"{error:.4f}" for error in albedo_error(found[:, :3], exact)]
