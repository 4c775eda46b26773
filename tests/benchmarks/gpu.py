# SPDX-License-Identifier: GPL-3.0-or-later
"""Ten presets on the graphics card beside the model of what a shader does, for whoever has a card.

    blender --background --factory-startup --python tests/benchmarks/gpu.py -- TABLE.csv [DEVICE ...]

Needs nothing but a Blender from blender.org. DEVICE: of those in `KINDS`; without any, all that this machine has. A row for each preset, device
and branch: the script (OSL; of cards OptiX alone has it) and the stock nodes. `off` is the relative error of a sphere's pixels
in the sun at 45 degrees, its 99th percentile, against `closure_model`; `from_cpu` is the same against the CPU's picture of that branch.
"""

import importlib.util
import os
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
KINDS = ("OPTIX", "CUDA", "HIP", "ONEAPI", "METAL")
WITH_OSL = ("CPU", "OPTIX")
PRESETS = (
    "glazed_mug", "frosted_paint", "clean_copper", "metallic_car_paint", "patina_copper", "nail_polish", "lacquered_brass", "rusted_painted_steel",
    "waxed_wood", "polished_chrome",
)  # fmt: skip
COLUMNS = ("preset", "device", "name", "branch", "off", "from_cpu", "finite")
SUN_THETA_DEG, SIZE = 45.0, 96


def import_lamina() -> None:
    """Lamina from this folder, whatever it is called."""
    if "lamina" in sys.modules:
        return
    spec = importlib.util.spec_from_file_location("lamina", ROOT / "__init__.py", submodule_search_locations=[str(ROOT)])
    module = sys.modules["lamina"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    from lamina.addon.blender.environment import ensure_osl_query_on_path

    ensure_osl_query_on_path()
    module.register()


def cards() -> dict[str, list]:
    """Devices of the graphics card by kind, of the kinds that this Blender and machine have."""
    preferences, found = bpy.context.preferences.addons["cycles"].preferences, {}
    for kind in KINDS:
        try:
            devices = [device for device in preferences.get_devices_for_type(kind) if device.type == kind]
        except (TypeError, ValueError):  # a Blender that was built without it
            continue
        if devices:
            found[kind] = devices
    return found


def use(kind: str, found: dict[str, list]) -> str:
    """Have Cycles render on a kind of device; returns the name of the card."""
    preferences = bpy.context.preferences.addons["cycles"].preferences
    preferences.compute_device_type = "NONE" if kind == "CPU" else kind
    for other in (device for devices in found.values() for device in devices):
        other.use = other.type == kind
    return "CPU" if kind == "CPU" else found[kind][0].name


def rows_of(preset: str, kinds: list[str], found: dict[str, list]) -> list[tuple]:
    """Both branches of one preset on the CPU and on every kind of device."""
    from support.goniometer import BRIGHT, local_directions

    from lamina.addon.blender.environment import osl_available
    from lamina.addon.material.material import apply_stack, refresh, stack_of
    from lamina.addon.rendering.measure import render_sun_sphere
    from lamina.reference_py.material import presets
    from lamina.reference_py.registry import make_model

    material = bpy.data.materials.new(preset)
    apply_stack(material, presets.load(preset), "baked")
    refresh(material, settle=True)
    model = make_model("closure_model", stack_of(material), method="baked")
    rows, by_cpu = [], {}
    for kind in ("CPU", *(kind for kind in kinds if kind != "CPU")):
        name = use(kind, found)
        for branch in ("osl", "nodes"):
            if branch == "osl" and not (kind in WITH_OSL and osl_available()[0]):
                continue
            picture = render_sun_sphere(material, SUN_THETA_DEG, SIZE, device="CPU" if kind == "CPU" else "GPU", osl=branch == "osl")
            normal = picture["normal"][picture["mask"]].astype(float)
            wi, wo = local_directions(normal / np.linalg.norm(normal, axis=-1, keepdims=True), picture["wi"], picture["wo"])
            wanted = model.f(wo, wi) * np.maximum(wi[:, 2:], 0.0)
            rendered = picture["radiance"][picture["mask"]].astype(float)
            counts = wanted > BRIGHT * wanted.max()
            off, apart = (
                float(np.percentile((np.abs(rendered - other) / np.maximum(wanted, 1e-12))[counts], 99))
                for other in (wanted, by_cpu.setdefault(branch, rendered))
            )
            rows.append((preset, kind, name, branch, f"{off:.2e}", f"{apart:.2e}", "yes" if np.isfinite(picture["radiance"]).all() else "no"))
    bpy.data.materials.remove(material)
    return rows


def main(table: str, *asked: str) -> int:
    """Write the table; 2 where there is no card, or none of those that were asked for."""
    if unknown := [kind for kind in asked if kind not in (*KINDS, "CPU")]:
        print(f"make gpu: unknown device {unknown[0]}; choose {', '.join(KINDS)}")
        return 2
    found = cards()
    kinds = [kind for kind in asked or KINDS if kind in found or kind == "CPU"]
    if not kinds:
        print(f"make gpu: this Blender finds no {' or '.join(asked or KINDS)} device on this machine; nothing was rendered")
        return 2
    sys.path.insert(0, str(ROOT / "tests"))
    with tempfile.TemporaryDirectory() as cache:
        os.environ.setdefault("LAMINA_CACHE", cache)
        import_lamina()
        from lamina.study.tables import write_table

        rows = []
        for preset in PRESETS:
            rows += rows_of(preset, kinds, found)
            for row in (row for row in rows if row[0] == preset):
                print("{:22} {:7} {:28} {:6} off {} from the CPU {} finite {}".format(*row), flush=True)
        write_table(Path(table), ("make gpu", "off: 99th percentile of the relative error of pixels against closure_model"), COLUMNS, rows)
    return 0


if __name__ == "__main__":
    status = main(*sys.argv[sys.argv.index("--") + 1 :])
    sys.stdout.flush()
    os._exit(status)
