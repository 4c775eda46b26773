# SPDX-License-Identifier: GPL-3.0-or-later
"""What it costs that a material has both branches: to render, to start a render, and to make. Ratios of CPU time, paired.

    branches.py [TABLE.csv]

Three presets. Each figure is of the least times of interleaved rounds: with OSL over the script alone, without OSL over the
stock nodes alone. `start_least` is the same start of a script whose stock branch is one Diffuse node: what the mix itself costs.
"""

import os
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.shading_cost import COPIES, SIZE, Scene, cpu, least

import lamina
from lamina.addon.blender.environment import ensure_osl_query_on_path
from lamina.addon.material import material as materials
from lamina.addon.material.roles import SWITCH, node_with
from lamina.addon.material.shader_node import remove_material
from lamina.reference_py.material import presets
from lamina.study.tables import write_table

NAMES = ("glazed_mug", "metallic_car_paint", "frosted_paint")
ROUNDS, STARTS, SAMPLES = 7, 20, 64
COLUMNS = ("preset", "osl", "render", "start", "start_least", "start_ms", "alone_start_ms", "make", "make_ms", "alone_make_ms")


def made(name: str, backend: str) -> bpy.types.Material:
    new = bpy.data.materials.new(f"{name} {backend}")
    materials.apply_stack(new, presets.load(name), "auto", backend)
    materials.refresh(new, settle=True)
    return new


def with_diffuse(material: bpy.types.Material) -> bpy.types.Material:
    """A copy whose stock branch is one Diffuse node."""
    new = material.copy()
    tree = new.node_tree
    tree.links.new(tree.nodes.new("ShaderNodeBsdfDiffuse").outputs[0], node_with(new, SWITCH).inputs[1])
    return new


def making(name: str, tier: str, backend: str) -> float:
    """Seconds to make a material of known bakes; a script that was compiled before is compiled again."""
    from lamina.addon.material import script_node

    script_node._compiled.clear()
    new = bpy.data.materials.new("made")
    taken = cpu(lambda: materials.apply_stack(new, presets.load(name), tier, backend))
    remove_material(new)
    return taken


def rows(folder: str):
    for name in NAMES:
        stage = Scene(folder)
        both, alone = made(name, "auto"), {True: made(name, "osl"), False: made(name, "nodes")}
        for osl in (True, False):
            one, other = least(ROUNDS, *(lambda m=m: stage.seconds([m], osl, SIZE, SAMPLES) for m in (both, alone[osl])))
            starting = [both, alone[osl], *([with_diffuse(both)] if osl else [])]
            copies = [[material.copy() for _ in range(COPIES)] for material in starting]
            none, *start = least(STARTS, *(lambda c=c: stage.seconds(c, osl, 4, 1) for c in ([], *copies)))
            each = [1000.0 * (seconds - none) / COPIES for seconds in start]
            backends = "auto", "osl" if osl else "nodes"
            make = least(ROUNDS, *(lambda b=b: making(name, "analytic", b) for b in backends))
            share = [f"{ms / max(each[1], 1e-6):.2f}" for ms in each]
            yield (
                name,
                "on" if osl else "off",
                f"{one / other:.3f}",
                share[0],
                share[2] if osl else "",
                f"{each[0]:.1f}",
                f"{each[1]:.1f}",
                f"{make[0] / make[1]:.2f}",
                f"{1000.0 * make[0]:.0f}",
                f"{1000.0 * make[1]:.0f}",
            )


def main() -> int:
    import tempfile

    ensure_osl_query_on_path()
    lamina.register()
    with tempfile.TemporaryDirectory() as folder:
        found = []
        for row in rows(folder):
            found.append(row)
            print("branches", "  ".join(f"{column} {value}" for column, value in zip(COLUMNS, row)), file=sys.stderr, flush=True)
    if len(sys.argv) > 1:
        write_table(Path(sys.argv[1]), ("make branches: both branches over one alone, least CPU time of rounds in turn",), COLUMNS, found)
    sys.stdout.flush()
    os._exit(0)


if __name__ == "__main__":
    main()
