# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina chart published`: what others published of layered surfaces, beside `adding`: study/data/published.json has sources and licences.

Prahl: cloudy slabs, bare, glossy or under glass, by adding-doubling. Byrnes: smooth layers over vacuum or metal for both polarizations; light of no
polarization is followed here as if every surface made it so again, and the difference is what that costs. Of Prahl's samples the column `refined` has what
his own code gives with more directions.
"""

import json
from pathlib import Path

import numpy as np

from ...reference_py.atomic import require_writable
from ...reference_py.material.stack import Stack
from ...reference_py.optics.frame import spherical
from ...reference_py.registry import make_model
from ..tables import Report, write_table
from .output import print_table, pyplot, save_picture

DATA = Path(__file__).parents[1] / "data" / "published.json"
COLUMNS = ("source", "surface", "light", "published", "refined", "adding", "difference")
# Optical depth that stands for a slab without end; directions that uniform light is summed over.
_DEEP, _DIRECTIONS = 60.0, 48
_BLACK = {"kind": "lambert", "color": [0.0] * 3}


def published() -> dict:
    """The file's sources by name, each with its licence and rows."""
    return json.loads(DATA.read_text(encoding="utf-8"))


def cloudy_slab(row: dict) -> Stack:
    """Prahl's sample: a medium between glass slides, if any, in vacuum."""
    layers = [_clear(row["slide_above"])] if row["slide_above"] != 1.0 else []
    depth = _DEEP if row["depth"] is None else row["depth"]
    medium = {"extinction": [1.0] * 3, "scatter_albedo": [row["albedo"]] * 3, "scatter_g": row["g"], "thickness": depth}
    layers.append(_clear(row["ior"]) | medium)
    layers += [_clear(row["slide_below"])] if row["slide_below"] != 1.0 else []
    return Stack.from_dict({"layers": [*layers, _clear(1.0)], "base": _BLACK})


def smooth_layers(row: dict) -> Stack:
    """Byrnes' layers of absolute index and optical depth, over a medium without end of index n + ik."""
    layers = [_clear(ior) | {"tint": [float(np.exp(-tau))] * 3} for ior, tau in zip(row["ior"], row["tau"])]
    n, k = row["below"]
    if k == 0.0:
        return Stack.from_dict({"layers": [*layers, _clear(n)], "base": _BLACK})
    return Stack.from_dict({"layers": layers, "base": {"kind": "conductor", "eta": [n] * 3, "k": [k] * 3, "roughness": 0.0}})


def _clear(ior: float) -> dict:
    return {"kind": "dielectric", "ior": ior, "roughness": 0.0, "tint": [1.0] * 3, "thickness": 1.0}


def rows() -> list[tuple[str, str, str, float, float | None, float]]:
    """(source, surface, light, published, refined or None, adding) of everything."""
    found = []
    nodes, weights = np.polynomial.legendre.leggauss(_DIRECTIONS)
    mu = 0.5 * (nodes + 1.0)
    for row in published()["prahl"]["rows"]:
        albedo = make_model("adding", cloudy_slab(row)).albedo(spherical(np.arccos(np.append(mu, 1.0)), 0.0))[:, 0]
        for light, key, own in (("normal", "ur1", albedo[-1]), ("uniform", "uru", np.sum(weights * mu * albedo[:-1]))):
            found.append(("prahl", row["name"], light, row[key], row.get(f"{key}_refined"), own))
    for row in published()["byrnes"]["rows"]:
        albedo = make_model("adding", smooth_layers(row)).albedo(spherical(np.radians(row["theta_deg"]), 0.0))[:, 0]
        both = 0.5 * (np.array(row["s"]) + row["p"])
        found += [("byrnes", row["name"], f"{theta} deg", exact, None, own) for theta, exact, own in zip(row["theta_deg"], both, albedo)]
    return found


def chart(folder: Path, report: Report) -> None:
    """Write published.csv and published.png."""
    for suffix in (".png", ".csv"):
        require_writable(folder / f"published{suffix}")
    found = rows()
    written = [
        [*names, f"{exact:.5f}", "" if refined is None else f"{refined:.5f}", f"{own:.5f}", f"{own - (exact if refined is None else refined):+.5f}"]
        for *names, exact, refined, own in found
    ]
    print_table(COLUMNS, written)
    heading = ("lamina chart published -o figures", *(f"{name}: {source['source']}; {source['licence']}" for name, source in published().items()))
    write_table(folder / "published.csv", heading, COLUMNS, written, report)
    _draw(found, folder, report)


def _draw(found, folder: Path, report: Report) -> None:
    plt = pyplot(report)
    if plt is None:
        return
    figure, (left, right) = plt.subplots(1, 2, figsize=(11.0, 4.6), layout="constrained")
    slabs = [row for row in found if row[0] == "prahl"]
    names = list(dict.fromkeys(row[1] for row in slabs))
    for light, mark in (("normal", "o"), ("uniform", "s")):
        chosen = [row for row in slabs if row[2] == light]
        left.plot([row[3] for row in chosen], range(len(names)), mark, mfc="none", color="black", label=f"published, {light} light")
        left.plot(
            [np.nan if row[4] is None else row[4] for row in chosen],
            range(len(names)),
            "+",
            color="black",
            label=None if mark == "o" else "its code, 64 directions",
        )
        left.plot([row[5] for row in chosen], range(len(names)), ".", color="tab:red", label="adding" if light == "normal" else None)
    left.set(yticks=range(len(names)), xlabel="share of light reflected", title="Cloudy slabs (Prahl, iadpython)")
    left.set_yticklabels(names, fontsize=8)
    left.legend(fontsize=8)
    for row in published()["byrnes"]["rows"]:
        own = [r[5] for r in found if r[:2] == ("byrnes", row["name"])]
        line = right.plot(row["theta_deg"], own, label=row["name"].replace("_", " "))[0]
        right.plot(row["theta_deg"], 0.5 * (np.array(row["s"]) + row["p"]), "o", mfc="none", color=line.get_color())
    right.set(xlabel="angle from the normal, degrees", title="Smooth layers (rings: Byrnes, tmm; lines: adding)", ylim=(0.0, 0.8))
    right.legend(fontsize=8)
    save_picture(figure, folder / "published.png", report)
    plt.close(figure)
