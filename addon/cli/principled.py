# SPDX-License-Identifier: GPL-3.0-or-later
"""Command that writes a .blend whose Lamina materials are Principled ones, or lists how well every preset is handed over."""

from pathlib import Path

from ...reference_py.atomic import require_writable
from ...reference_py.errors import LaminaError
from ...reference_py.exchange.principled import to_principled
from ...reference_py.exchange.report import LOST
from ...reference_py.material import presets
from ..session import blender, say


def principled(options) -> int:
    """One line per material on stdout. Returns 1 where one could not be converted."""
    if options.presets:
        if options.input or options.output:
            raise LaminaError("--presets prints a table and reads and writes no file; leave out IN.blend and -o")
        _table()
        return 0
    if not options.input or not options.output:
        raise LaminaError("give IN.blend and -o OUT.blend, or --presets")
    source, output = Path(options.input), Path(options.output)
    if output.suffix.lower() != ".blend":
        raise LaminaError(f"{output}: principled writes a Blender file; choose a name that ends in .blend")
    if not source.is_file():
        raise LaminaError(f"{source}: there is no such .blend file")
    require_writable(output)
    report = say("principled")
    report(f"open {source}")
    with blender(report):
        import bpy

        from ..blender.blend_files import open_file, save_copy
        from ..exchange.conversion import principled_copies

        open_file(source)
        if not any(material.lamina.is_layered for material in bpy.data.materials):
            raise LaminaError(f"{source}: no material of it has a Lamina stack")
        outcomes = [(item.name, item.lamina.is_layered, sentence) for item, sentence in principled_copies(replacing=True)]
        if all(left for _, left, _ in outcomes):
            raise LaminaError(f"{source}: none of its materials can be converted; {outcomes[0][0]}: {outcomes[0][2]}")
        save_copy(output)
    for name, _, sentence in outcomes:
        print(f"{name}: {sentence}")
    left = sum(left for _, left, _ in outcomes)
    report(f"wrote {output}: {len(outcomes) - left} of {len(outcomes)} materials are Principled now")
    return 1 if left else 0


def _table() -> None:
    """Every preset: error in uniform light, worst error of the albedo, and what is lost. The worst first."""
    rows = []
    for name in presets.names():
        report = to_principled(presets.load(name)).report
        rows.append((report.match.soft_light, name, report.match.worst, ", ".join(dict.fromkeys(loss.parameter for loss in report.of(LOST)))))
    print(f"{'preset':20} {'error':>7} {'worst':>7}  lost")
    for error, name, worst, lost in sorted(rows, reverse=True):
        print(f"{name:20} {100.0 * error:5.1f} % {worst:7.3f}  {lost}".rstrip())
