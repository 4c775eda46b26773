# SPDX-License-Identifier: GPL-3.0-or-later
"""What a batch leaves: verified pictures, a table of all of them, contact sheets."""

import csv
import io
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...reference_py.atomic import write_text
from ...reference_py.lobes.made import DEFAULT_TOLERANCE
from .items import Item

TABLE = "batch.csv"
# a narrower cell's labels could not be read
_TILES_PER_SHEET, _COLUMNS, _TILE = 60, 8, 192
_ERRORS = ("albedo", "soft_light", "shape")
_COLUMNS_OF_TABLE = (
    "id", "state", "look", "tier", "chosen", *(f"{e}_error" for e in _ERRORS), "scene", "view_deg", "frame", "sweep", "samples", "seed",
    "width", "height", "mean_r", "mean_g", "mean_b", "seconds", "version", "blender", "inputs", "pixels", "problem",
)  # fmt: skip


@dataclass(frozen=True)
class Output:
    """An item's picture: what is wrong with it, empty if nothing, and the texts in its header.

    `scene_failed` where the problem is that of the item's scene, and so of all its items.
    """

    item: Item
    problem: str
    texts: dict[str, str]
    scene_failed: bool = False


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
    errors = _errors(texts)
    return row | {
        "chosen": texts["lamina:chosen"], **{f"{e}_error": errors.get(e, "") for e in _ERRORS}, "samples": texts["lamina:samples"],
        "height": pixels.shape[0], "width": pixels.shape[1],
        **{f"mean_{c}": f"{v:.6g}" for c, v in zip("rgb", pixels.mean(axis=(0, 1)))},
        "seconds": texts["lamina:seconds"], "version": texts["lamina:version"], "blender": texts["lamina:blender"], "pixels": texts["lamina:pixels"],
    }  # fmt: skip


def missed(outputs: Sequence[Output]) -> str:
    """One line on the pictures whose estimated error is above the tolerance, empty if there are none."""
    seen = [(max(float(e) for e in errors), output.item) for output in outputs if not output.problem and (errors := _seen(output.texts))]
    above = [(error, item) for error, item in seen if error > DEFAULT_TOLERANCE]
    if not above:
        return ""
    error, item = max(above, key=lambda one: one[0])
    return (
        f"{len(above)} of {len(outputs)} pictures miss the tolerance of {100 * DEFAULT_TOLERANCE:g} %, the worst {item.id} ({item.look}, {item.words}) "
        f"by its estimated error of {100 * error:.1f} %; see {TABLE}"
    )


def _seen(texts: Mapping[str, str]) -> list[str]:
    """The errors that the tolerance is for, as in `error_estimate.Errors.visible`."""
    errors = _errors(texts)
    return [errors[name] for name in ("albedo", "soft_light") if name in errors]


def _errors(texts: Mapping[str, str]) -> dict[str, str]:
    said = texts["lamina:error"].split()
    return dict(zip(said[::2], said[1::2])) if said[:1] != ["unknown:"] else {}


def _pixels(path: Path) -> np.ndarray:
    from ..blender.images import read_exr

    channels = read_exr(path).channels
    return np.stack([channels[c] for c in "RGB"], axis=-1)


def write_sheets(outputs: Sequence[Output], folder: Path, title: str, report: Callable[[str], None]) -> list[Path]:
    """Contact sheets of the first frame of every look that is done, in the job's order, each as its scene shows it.

    Needs a running Blender.
    """
    from ..blender.images import write_png
    from ..rendering.sheet import Tile, compose

    frames: dict[str, list[Output]] = {}
    for output in outputs:
        if not output.problem:
            frames.setdefault(output.item.id.rpartition(".")[0], []).append(output)
    shown, written, notices = list(frames.values()), [], set()
    for page, start in enumerate(range(0, len(shown), _TILES_PER_SHEET)):
        part = shown[start : start + _TILES_PER_SHEET]
        pictures = [_tile(group[0], folder, notices.add) for group in part]
        tiles = [Tile(group[0].item.look[:60], None, _note(group)) for group in part]
        number = f" {page + 1}" if len(shown) > _TILES_PER_SHEET else ""
        path = folder / f"sheet{number.strip() and '_' + number.strip()}.png"
        write_png(path, compose(pictures, tiles, _COLUMNS, (title + number)[:80]))
        written.append(path)
    for sentence in sorted(notices):
        report(f"sheet: {sentence}")
    return written


def _note(group: Sequence[Output]) -> str:
    """What is shown of the frames of one look."""
    item = group[0].item
    return item.words + (f", frame {item.frame}, first of {len(group)}" if len(group) > 1 else "")


def _tile(output: Output, folder: Path, report: Callable[[str], None]) -> np.ndarray:
    """The whole picture in a cell, as its scene's view transform shows it; uint8."""
    from ..rendering.sheet import PAGE
    from ..rendering.view import displayed

    picture = displayed(fitted(_pixels(folder / output.item.file), _TILE), json.loads(output.texts.get("lamina:view", "{}")), report)
    height, width = picture.shape[:2]
    top, left = (_TILE - height) // 2, (_TILE - width) // 2
    cell = np.tile(np.round(255.0 * PAGE).astype(np.uint8), (_TILE, _TILE, 1))
    cell[top : top + height, left : left + width] = picture
    return cell


def fitted(linear: np.ndarray, side: int) -> np.ndarray:
    """A linear picture (h, w, 3) whose longer side is `side` pixels, averaged down or repeated up."""
    picture = np.nan_to_num(linear.astype(np.float64), posinf=1.0, neginf=0.0)
    longer = max(picture.shape[:2])
    for axis in (0, 1):
        size = picture.shape[axis]
        edges = np.linspace(0, size, max(1, round(size * side / longer)) + 1)
        low = edges[:-1].astype(int)
        high = np.maximum(np.ceil(edges[1:]).astype(int), low + 1)
        sums = np.insert(picture.cumsum(axis=axis), 0, 0.0, axis=axis)
        count = (high - low).reshape((-1, 1, 1) if axis == 0 else (1, -1, 1))
        picture = (sums.take(high, axis) - sums.take(low, axis)) / count
    return picture
