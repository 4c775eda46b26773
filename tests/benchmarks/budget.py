# SPDX-License-Identifier: GPL-3.0-or-later
"""What a material costs with OSL and without, beside Principled with a coat: nodes, text, start, shading, growth in a long animation.

    budget.py [TABLE.csv]
    budget.py --growth NAME on|off value|still

`shading` is CPU time over Principled's in the same surroundings, with values that come from the surface's position where both have them;
`start_ms` is what one more material adds to a render. `growth_kB` is what a frame adds to the process where Blender keeps a scene's data from
frame to frame and a roughness is animated: Cycles then makes that shader anew. `growth_still_kB` is the same with a moving camera alone.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.shading_cost import COPIES, SIZE, Scene, least

import lamina
from lamina.addon.blender.environment import ensure_osl_query_on_path
from lamina.addon.material import material as materials
from lamina.addon.material.elements import node_of
from lamina.addon.rendering.settings import render_to
from lamina.reference_py.material import presets
from lamina.reference_py.material.stack import Stack
from lamina.study.tables import write_table

PRINCIPLED, TEXTURED = "principled_coat", " textured"
TABLE = {"layers": [{"kind": "dielectric", "name": "Varnish", "roughness": 0.35, "tint": [0.9, 0.75, 0.5]}], "base": {"kind": "lambert"}}
NAMES = (PRINCIPLED, "glazed_mug", "metallic_car_paint", "frosted_paint", PRINCIPLED + TEXTURED, "wooden_table" + TEXTURED)
ROUNDS, STARTS, SAMPLES, FRAMES = 7, 12, 64, 120
COLUMNS = ("material", "osl", "nodes", "text_kB", "closures", "start_ms", "shading", "growth_kB", "growth_still_kB")


def made(name: str) -> bpy.types.Material:
    """A settled material of a name of NAMES; where it is textured, color, roughness and the coat's thickness or weight differ over the surface."""
    material = bpy.data.materials.new(name)
    kind, textured = name.removesuffix(TEXTURED), name.endswith(TEXTURED)
    if kind == PRINCIPLED:
        material.use_nodes = True
        shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
        shader.inputs["Coat Weight"].default_value = 1.0
        live = [shader.inputs[label] for label in ("Base Color", "Coat Roughness", "Coat Weight")]
    else:
        materials.apply_stack(material, Stack.from_dict(TABLE) if textured else presets.load(kind))
        live = (
            [
                node_of(element).inputs[label]
                for element, label in zip((material.lamina.base, *2 * [material.lamina.layers[0]]), ("Color", "Roughness", "Thickness"))
            ]
            if textured
            else []
        )
    if textured:
        place = material.node_tree.nodes.new("ShaderNodeNewGeometry").outputs["Position"]
        apart = material.node_tree.nodes.new("ShaderNodeSeparateXYZ")
        material.node_tree.links.new(place, apart.inputs[0])
        for source, socket in zip((place, apart.outputs[0], apart.outputs[1]), live):
            material.node_tree.links.new(source, socket)
    if kind != PRINCIPLED:
        materials.refresh(material, settle=True)
    return material


def counts(material: bpy.types.Material, osl: bool) -> tuple[int, float, int | str]:
    """Nodes of the branch that renders with what it reads, kB of its text, and its closures."""
    tree = material.node_tree
    groups = [node.node_tree for node in tree.nodes if node.type == "GROUP"]
    texts = [node.script for node in tree.nodes if node.type == "SCRIPT"]
    closures = material.lamina.lobe_count or ""
    if osl and texts:
        return len(tree.nodes), sum(len(text.as_string()) for text in texts) / 1e3, closures
    return len(tree.nodes) + sum(len(group.nodes) for group in groups), 0.0, closures


def resident_kb() -> int:
    return next(int(line.split()[1]) for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmRSS"))


def growth(name: str, osl: bool, animate_value: bool) -> float:
    """kB a frame, in this process, over the last two thirds of FRAMES."""
    with tempfile.TemporaryDirectory() as folder:
        stage = Scene(folder)
        material = made(name)
        scene, camera = stage.scene, stage.scene.camera
        stage.seconds([material], osl, 8, 1)
        scene.render.use_persistent_data = True
        camera.keyframe_insert("location", frame=1)
        camera.location.x = 0.1
        camera.keyframe_insert("location", frame=FRAMES)
        if animate_value:
            shader = next((node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED"), None)
            label, node = ("Coat Roughness", shader) if name.startswith(PRINCIPLED) else ("Roughness", node_of(material.lamina.layers[0]))
            for link in list(node.inputs[label].links):
                material.node_tree.links.remove(link)
            for frame, value in ((1, 0.2), (FRAMES, 0.5)):
                node.inputs[label].default_value = value
                node.inputs[label].keyframe_insert("default_value", frame=frame)
            if material.lamina.layers:
                materials.refresh(material, settle=True)
        sizes = []
        for frame in range(1, FRAMES + 1):
            scene.frame_set(frame)
            render_to(scene, stage.file)
            sizes.append(resident_kb())
    return (sizes[-1] - sizes[FRAMES // 3]) / (FRAMES - 1 - FRAMES // 3)


def rows(folder: str):
    stage = Scene(folder)
    everything = {name: made(name) for name in NAMES}
    for name, material in everything.items():
        peer = everything[PRINCIPLED + (TEXTURED if name.endswith(TEXTURED) else "")]
        for osl in (True, False):
            nodes, text, closures = counts(material, osl)
            own, peers = least(ROUNDS, *(lambda m=m: stage.seconds([m], osl, SIZE, SAMPLES) for m in (material, peer)))
            copies = [material.copy() for _ in range(COPIES)]
            none, start = least(STARTS, *(lambda c=c: stage.seconds(c, osl, 4, 1) for c in ([], copies)))
            grown = [grown_in_a_process(name, osl, value) for value in (True, False)]
            start_ms = 1000.0 * (start - none) / COPIES
            yield name, "on" if osl else "off", nodes, f"{text:.0f}", closures, f"{start_ms:.1f}", f"{own / peers:.2f}", *(f"{kb:.1f}" for kb in grown)


def grown_in_a_process(name: str, osl: bool, value: bool) -> float:
    command = [sys.executable, __file__, "--growth", name, "on" if osl else "off", "value" if value else "still"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    return float(next(line.split()[1] for line in done.stdout.splitlines() if line.startswith("growth ")))


def main() -> int:
    ensure_osl_query_on_path()
    lamina.register()
    if sys.argv[1:2] == ["--growth"]:
        _, _, name, osl, what = sys.argv
        print("growth", growth(name, osl == "on", what == "value"))
    else:
        with tempfile.TemporaryDirectory() as folder:
            found = []
            for row in rows(folder):
                found.append(row)
                print("budget", "  ".join(f"{column} {value}" for column, value in zip(COLUMNS, row)), file=sys.stderr, flush=True)
        if len(sys.argv) > 1:
            write_table(Path(sys.argv[1]), ("make budget: what a material costs, with OSL and without",), COLUMNS, found)
    sys.stdout.flush()
    os._exit(0)


if __name__ == "__main__":
    main()
