# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina chart exchange --files FOLDER ...`: what becomes of other people's MaterialX files, a row each.

Colors are read a second time by colour-science, from the file's own text, so that a wrong color space shows.
"""

import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ...reference_py.errors import LaminaError
from ...reference_py.exchange import SUFFIX
from ...reference_py.exchange.materialx import AnyMaterial, load_mtlx
from ...reference_py.exchange.report import APPROXIMATED, LOST
from ..colorimetry import colour_science, delta_e_2000, xyz_of_linear
from ..tables import Report, write_table

COLUMNS = ("file", "material", "surface", "lost", "approximated", "soft_light_percent", "lost_light_percent", "color_ciede2000", "read_ciede2000", "unsaid")
_HEADING = (
    "lamina chart exchange",
    "soft_light: mean difference in uniform light to all that the file says, of it lost_light: transmitted, emitted, of a sheen",
    "color: of the two mean albedos; read: the worst color of the file against colour-science, and unsaid where no line names it",
)
SAID_ABOVE = 0.5
"""CIEDE2000 above which a color that is off must be said."""
_NAMES = {"acescg": "ACEScg", "lin_ap1": "ACEScg", "srgb_texture": "sRGB", "lin_rec2020": "ITU-R BT.2020", "lin_rec709": "ITU-R BT.709"}


def chart(folder: Path, report: Report, files: Sequence[str] = ()) -> None:
    """Write exchange.csv: a row for each file below the folders of `files`, by the first of its materials. Raises LaminaError without any."""
    paths = sorted({path for place in files for path in Path(place).rglob(f"*{SUFFIX}")}, key=lambda p: (p.name, str(p)))
    if not paths:
        raise LaminaError(f"chart exchange: no {SUFFIX} file in {', '.join(map(str, files)) or 'no folder'}; name folders with --files")
    colour_science()
    rows = [row_of(path) for path in paths]
    write_table(folder / "exchange.csv", _HEADING, COLUMNS, rows, report)
    refused = [row for row in rows if row[3] == "refused"]
    report(
        f"{len(rows)} files, {len(refused)} refused ({', '.join(row[0] for row in refused) or 'none'}); {sum(row[9] == 'yes' for row in rows)} with a color unsaid"
    )


def row_of(path: Path) -> list[str]:
    """What became of a file's first material."""
    try:
        material, *_ = load_mtlx(path)
        report = material.to_stack(frozenset(material.images)).report
    except LaminaError as error:
        return [path.name, "", "", "refused", str(error).removeprefix(f"{path}: "), *[""] * 5]
    # what reading says; that a base color is solved says nothing of its color space
    match, named = report.match, {loss.parameter for loss in material.losses}
    off = _off(path, material)
    unsaid = any(difference > SAID_ABOVE and name not in named for name, difference in off.items())
    numbers = (100.0 * match.soft_light, 100.0 * match.lost_light, match.color_difference, max(off.values(), default=0.0))
    counts = [str(len(report.of(fate))) for fate in (LOST, APPROXIMATED)]
    return [path.name, material.name, material.node, *counts, *(f"{n:.2f}" for n in numbers), "yes" if unsaid else "no"]


def _off(path: Path, material: AnyMaterial) -> dict[str, float]:
    """CIEDE2000 between the colors of a file as they were read and as colour-science reads them, by input."""
    colour = colour_science()
    root = ElementTree.parse(path).getroot()
    node = next((n for n in root.iter(material.node)), None)
    off = {}
    for given in node if node is not None else ():
        space = given.get("colorspace") or node.get("colorspace") or root.get("colorspace", "")
        if given.get("type") == "color3" and given.get("value") and given.get("name") in material.values and space in _NAMES:
            rgb = np.array([float(v) for v in given.get("value").split(",")])
            linear = colour.RGB_to_RGB(rgb, _NAMES[space], "sRGB", "Bradford", apply_cctf_decoding=space == "srgb_texture")
            ours = np.array(material.values[given.get("name")])
            off[given.get("name")] = float(delta_e_2000(*(xyz_of_linear(np.asarray(c, float)) for c in (linear, ours))))
    return off
