# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina chart mitsuba`: a sphere in the sun by Cycles and by Mitsuba's `measured` with the exported table, beside the truth.

Needs Mitsuba 3 (`make mitsuba` installs it) and Blender.
"""

import tempfile
from pathlib import Path

import numpy as np

from ...addon.session import blender
from ...reference_py.atomic import require_writable
from ...reference_py.errors import LaminaError
from ...reference_py.exchange.writers import mitsuba as scenes
from ...reference_py.exchange.writers import rgl
from ...reference_py.exchange.writers.truth import Truth
from ...reference_py.material import presets
from ...reference_py.optics.frame import spherical
from ..tables import Report, write_table
from .output import print_table, pyplot, save_picture

SURFACES = ("satin_varnish", "varnished_gold_leaf")
SIZE, _FINE, _SPP = 96, 2, 64
COLUMNS = ("stack", "cycles", "mitsuba", "mitsuba_from_cycles")
_LABELS = ("Truth", "Cycles, by Lamina", "Mitsuba, from export")


def chart(folder: Path, report: Report) -> None:
    """Write mitsuba.png and mitsuba.csv: the pictures' mean difference, as a share of the truth's mean. Raises LaminaError without Mitsuba."""
    for suffix in (".png", ".csv"):
        require_writable(folder / f"mitsuba{suffix}")
    try:
        import mitsuba as mi
    except ImportError:
        raise LaminaError("this chart needs Mitsuba 3, which this Python has not: make mitsuba") from None
    mi.set_variant("scalar_rgb")
    pictures, rows = [], []
    with blender(lambda text: None):
        for name in SURFACES:
            report(name)
            truth = Truth(presets.load(name), 2)
            pictures.append((_truth(truth), _cycles(name), _mitsuba(mi, truth)))
            exact, cycles, mitsuba = pictures[-1]
            pairs = ((cycles, exact), (mitsuba, exact), (mitsuba, cycles))
            rows.append([name, *(f"{np.mean(np.abs(a - b)) / np.mean(exact):.4f}" for a, b in pairs)])
    print_table(COLUMNS, rows)
    heading = ("lamina chart mitsuba -o figures", f"Mitsuba {mi.__version__}; mean difference of the pictures over the truth's mean")
    write_table(folder / "mitsuba.csv", heading, COLUMNS, rows, report)
    _draw(pictures, folder, report)


def _truth(truth: Truth) -> np.ndarray:
    """Radiance (SIZE, SIZE, 3) of the sphere, of fine pixels averaged as those of the renders."""
    places = (np.arange(SIZE * _FINE) + 0.5) * 2.0 / (SIZE * _FINE) - 1.0
    x, y = np.meshgrid(places, -places)
    inside = x * x + y * y < 1.0
    normal = np.stack([x, y, np.sqrt(np.maximum(1.0 - x * x - y * y, 0.0))], axis=-1)[inside]
    sun, view = spherical(np.radians(scenes.SUN_THETA_DEG), 0.0), np.array([0.0, 0.0, 1.0])
    cos_i, cos_o = normal @ sun, normal @ view
    lit = cos_i > 1e-4
    # the azimuth between both, about the normal
    sines = np.sqrt(np.maximum((1.0 - cos_i**2) * (1.0 - cos_o**2), 1e-12))
    turn = np.arccos(np.clip((sun @ view - cos_i * cos_o) / sines, -1.0, 1.0))
    wi, wo = spherical(np.arccos(cos_i[lit]), 0.0), spherical(np.arccos(cos_o[lit]), turn[lit])
    shown = np.zeros((len(normal), 3))
    shown[lit] = np.pi * truth.f(wo, wi) * cos_i[lit, None]
    picture = np.zeros((*inside.shape, 3))
    picture[inside] = shown
    return _averaged(picture)


def _cycles(name: str) -> np.ndarray:
    import bpy

    from ...addon.material.material import apply_stack, refresh
    from ...addon.rendering.measure import render_sun_sphere

    material = bpy.data.materials.new(name)
    apply_stack(material, presets.load(name))
    refresh(material, settle=True)
    return _averaged(np.pi * render_sun_sphere(material, scenes.SUN_THETA_DEG, SIZE * _FINE)["radiance"])


def _mitsuba(mi, truth: Truth) -> np.ndarray:
    with tempfile.TemporaryDirectory() as folder:
        rgl.write(rgl.fields(truth, "chart"), Path(folder, "table.bsdf"))
        scene = Path(folder, "scene.xml")
        scene.write_text(scenes.measured_scene("chart", "table.bsdf"), encoding="utf-8")
        return np.array(mi.render(mi.load_file(str(scene), size=str(SIZE), spp=str(_SPP))), float)


def _averaged(picture: np.ndarray) -> np.ndarray:
    return picture.reshape(SIZE, _FINE, SIZE, _FINE, 3).mean(axis=(1, 3))


def _draw(pictures, folder: Path, report: Report) -> None:
    plt = pyplot(report)
    if plt is None:
        return
    figure, axes = plt.subplots(len(pictures), len(_LABELS), figsize=(2.2 * len(_LABELS), 2.2 * len(pictures) + 0.3), layout="constrained")
    for row, (name, shown) in enumerate(zip(SURFACES, pictures)):
        for column, picture in enumerate(shown):
            axes[row, column].imshow(np.clip(picture, 0.0, 1.0) ** (1.0 / 2.2))
            axes[row, column].set(xticks=[], yticks=[], title=_LABELS[column] if row == 0 else "")
        axes[row, 0].set_ylabel(presets.label(name))
    save_picture(figure, folder / "mitsuba.png", report)
    plt.close(figure)
