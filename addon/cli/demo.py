# SPDX-License-Identifier: GPL-3.0-or-later
"""The main job in one command: presets rendered on one page, and a table of their cost and error."""

import time
from pathlib import Path

from ...reference_py.atomic import output_folder, write_text
from ...reference_py.lobes.methods import DEFAULT_METHOD
from ...reference_py.material import presets
from ..session import blender, say
from .stack_errors import THETA_DEG, errors_of

COLUMNS = 5


def demo(options) -> None:
    """Render the contact sheet and print and save the table."""
    folder = output_folder(options.output)
    sheet, table = folder / "presets.png", folder / "presets.txt"
    report = say("demo")
    stacks = {name: presets.load(name) for name in (presets.names() if options.all else presets.PAPER)}
    with blender(report):
        seconds = _render(stacks, sheet, options, report)
    lines = [
        f"Tier {DEFAULT_METHOD} against the truth, worst of the view angles {', '.join(f'{t:g}' for t in THETA_DEG)} degrees",
        f"{'preset':20} {'chosen':18} {'closures':>8} {'seconds':>8} {'albedo error':>13} {'shape error':>12}",
    ]
    for name, stack in stacks.items():
        errors = errors_of(stack)
        shape = "" if errors.shape is None else f"{100 * errors.shape:.1f} %"
        lines.append(f"{name:20} {errors.chosen:18} {errors.closures:8} {seconds[name]:8.1f} {100 * errors.albedo:11.2f} % {shape:>12}")
    text = "\n".join(lines) + "\n"
    write_text(table, text)
    print(text, end="")
    report(f"wrote {sheet} and {table}")


def _render(stacks, sheet: Path, options, report) -> dict[str, float]:
    """Render the page; returns wall seconds per preset."""
    import bpy

    from ..material.material import apply_stack
    from ..rendering.sheet import Tile, render_sheet

    tiles = []
    for i, (name, stack) in enumerate(stacks.items()):
        report(f"{100 * i // len(stacks):3} % of the bakes, {name}")
        material = bpy.data.materials.new(name)
        apply_stack(material, stack, settle=True)
        layers = f"{len(stack.layers)} layer{'s' * (len(stack.layers) != 1)} over {stack.base.kind.replace('_', '-')}"
        tiles.append(Tile(presets.label(name), material, layers))
    marks = [time.monotonic()]

    def progress(done: float, what: str) -> None:
        marks.append(time.monotonic())
        report(f"{100 * done:3.0f} % {what}")

    render_sheet(tiles, sheet, COLUMNS, options.size, options.samples, progress, title="Lamina presets")
    # the first call starts tile 0, the last comes after the page is composed
    return {name: marks[i + 2] - marks[i + 1] for i, name in enumerate(stacks)}
