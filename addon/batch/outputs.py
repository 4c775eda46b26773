# SPDX-License-Identifier: GPL-3.0-or-later
"""What a batch leaves: verified pictures, a table of all of them, contact sheets."""

import csv
import io
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...reference_py.atomic import write_text
from .items import Item

TABLE = "batch.csv"
_TILES_PER_SHEET, _COLUMNS, _TILE = 60, 8, 160
_ERRORS = ("albedo", "soft_light", "shape")
_COLUMNS_OF_TABLE = (
    "id", "state", "look", "tier", "chosen", *(f"{e}_error" for e in _ERRORS), "scene", "view_deg", "frame", "sweep", "samples", "seed",
    "width", "height", "mean_r", "mean_g", "mean_b", "seconds", "version", "blender", "inputs", "pixels", "problem",
)  # fmt: skip


@dataclass(frozen=True)
class Output:
    """An item's picture: what is wrong with it, empty if nothing, and the texts in its header."""

    item: Item
    problem: str
    texts: dict[str, str]


def verified(item: Item, folder: Path) -> Output:
    """The item's picture as it lies there: readable, of these inputs, of this size, with the pixels that were written."""
    from .task import problem

    what, texts = problem(folder / item.file, item.inputs)
    return Output(item, what, texts)


def write_table(outputs: Sequence[Output], folder: Path) -> Path:
    """One row per item."""
    text = io.StringIO()
    writer = csv.DictWriter(text, _COLUMNS_OF_TABLE, lineterminator="\n")
    writer.writeheader()
    for output in outputs:
        writer.writerow(_row(output, folder))
    write_text(folder / TABLE, text.getvalue())
    return folder / TABLE


def _row(output: Output, folder: Path) -> dict:
    item, texts = output.item, output.texts
    row = {
        "id": item.id, "state": "failed" if output.problem else "done", "look": item.look, "tier": item.tier, "scene": item.scene.name,
        "view_deg": f"{item.view:g}", "frame": item.frame, "sweep": json.dumps(dict(item.values)), "seed": item.seed, "inputs": item.inputs,
        "problem": output.problem,
    }  # fmt: skip
    if output.problem:
        return row
    pixels = _pixels(folder / item.file)
    said = texts["lamina:error"].split()
    errors = dict(zip(said[::2], said[1::2])) if not texts["lamina:error"].startswith("unknown") else {}
    return row | {
        "chosen": texts["lamina:chosen"], **{f"{e}_error": errors.get(e, "") for e in _ERRORS}, "samples": texts["lamina:samples"],
        "height": pixels.shape[0], "width": pixels.shape[1],
        **{f"mean_{c}": f"{v:.6g}" for c, v in zip("rgb", pixels.mean(axis=(0, 1)))},
        "seconds": texts["lamina:seconds"], "version": texts["lamina:version"], "blender": texts["lamina:blender"], "pixels": texts["lamina:pixels"],
    }  # fmt: skip


def _pixels(path: Path) -> np.ndarray:
    from ..rendering.images import read_exr

    channels = read_exr(path).channels
    return np.stack([channels[c] for c in "RGB"], axis=-1)


def write_sheets(outputs: Sequence[Output], folder: Path, title: str) -> list[Path]:
    """Contact sheets of the first frame of every look that is done, in the job's order. Needs a running Blender."""
    from ..rendering.images import write_png
    from ..rendering.sheet import Tile, compose

    first = {output.item.id.rpartition(".")[0]: output for output in reversed(outputs) if not output.problem}
    shown = [output for output in outputs if first.get(output.item.id.rpartition(".")[0]) is output]
    side = min(_TILE, max((min(_pixels(folder / o.item.file).shape[:2]) for o in shown[:1]), default=_TILE))
    side = max(side, 64)
    written = []
    for page, start in enumerate(range(0, len(shown), _TILES_PER_SHEET)):
        part = shown[start:start + _TILES_PER_SHEET]
        pictures = [tile(_pixels(folder / o.item.file), side) for o in part]
        tiles = [Tile(o.item.look[:60], None, o.item.words) for o in part]
        number = f" {page + 1}" if len(shown) > _TILES_PER_SHEET else ""
        path = folder / f"sheet{number.strip() and '_' + number.strip()}.png"
        write_png(path, compose(pictures, tiles, _COLUMNS, (title + number)[:80]))
        written.append(path)
    return written


def tile(linear: np.ndarray, side: int) -> np.ndarray:
    """A linear picture (h, w, 3) as sRGB (side, side, 3) uint8: its middle square, averaged down or repeated up."""
    height, width = linear.shape[:2]
    least = min(height, width)
    top, left = (height - least) // 2, (width - least) // 2
    square = np.nan_to_num(linear[top:top + least, left:left + least], posinf=1.0, neginf=0.0)
    edges = np.linspace(0, least, side + 1)
    low, high = edges[:-1].astype(int), np.maximum(np.ceil(edges[1:]).astype(int), edges[:-1].astype(int) + 1)
    sums = np.pad(square.astype(np.float64).cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0), (0, 0)))
    total = sums[high][:, high] - sums[low][:, high] - sums[high][:, low] + sums[low][:, low]
    mean = total / ((high - low)[:, None] * (high - low))[..., None]
    encoded = np.where(mean <= 0.0031308, 12.92 * mean, 1.055 * np.maximum(mean, 1e-9) ** (1 / 2.4) - 0.055)
    return (encoded.clip(0.0, 1.0) * 255.0 + 0.5).astype(np.uint8)
