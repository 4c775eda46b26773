# SPDX-License-Identifier: GPL-3.0-or-later
"""How fast the two truths and bakes are: walks per second of `position_free`, seconds of a cold albedo and f of `adding`, of samples and of a bake,
and where Mitsuba is installed (`make mitsuba`) what the walks cost beside its explicit slabs at equal error.

Processor time, not the clock's, and the best of several repeats, so that other work on the machine counts little.
Run by `make bench`; nothing is asserted.
"""

import os
import resource
import time
from multiprocessing import get_context

import numpy as np

from lamina.reference_py.exchange.writers.mitsuba import slab_scene
from lamina.reference_py.lobes.methods import make_lobe_set
from lamina.reference_py.material import presets
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.optics.frame import spherical
from lamina.reference_py.registry import make_model
from lamina.study.suite import suite_stack

REPEATS = 5
WALKS = 1 << 17
DIRECTIONS = 64
VIEW = spherical(np.radians(45.0), 0.0)
TINT = [0.9, 0.6, 0.3]


def layer(ior=1.5, alpha=0.0, distribution="ggx", **values):
    return {"kind": "dielectric", "ior": ior, "roughness": alpha**0.5, "distribution": distribution, **values}


LAMBERT = {"kind": "lambert", "color": [0.5, 0.5, 0.5]}
GOLD = {"kind": "conductor", "metal": "gold", "roughness": 0.5}


def cloudy(tau, albedo, g):
    """A rough layer over a medium that scatters, of this optical depth."""
    return layer(alpha=0.4, thickness=1.0, extinction=[tau] * 3, scatter_albedo=[albedo] * 3, scatter_g=g)


COATS = {
    "smooth": layer(),
    "ggx .4": layer(alpha=0.4),
    "beckmann .4": layer(alpha=0.4, distribution="beckmann"),
    "ggx .4, cloudy": cloudy(1.0, 0.9, 0.0),
}
COLD_STACKS = {
    "three smooth layers over lambert": [LAMBERT, layer(1.5), layer(1.3), layer(1.6)],
    "three rough, tinted layers over gold": [
        GOLD,
        layer(1.5, 0.1, tint=TINT),
        layer(1.3, 0.3, "beckmann", tint=TINT),
        layer(1.6, 0.2, tint=TINT),
    ],
    "a rough layer, a medium of depth 20": [LAMBERT, cloudy(20.0, 0.9, 0.5)],
}

_ALPHAS = [(0.3 + 0.02 * i) ** 2 for i in range(20)]
SILVER = {"kind": "conductor", "metal": "silver", "roughness": 0.3}
TWENTY_LAYERS = {
    "twenty rough layers, two alternate": suite_stack("twenty_rough"),
    "two indices, twenty roughnesses": Stack.from_dict({"base": SILVER, "layers": [layer((1.5, 1.3)[i % 2], a) for i, a in enumerate(_ALPHAS)]}),
    "twenty indices and roughnesses": Stack.from_dict(
        {"base": SILVER, "layers": [layer((1.3 + 0.01 * i, 1.7 - 0.01 * i)[i % 2], a) for i, a in enumerate(_ALPHAS)]}
    ),
}

# Paths a pixel of 64 x 64, and estimates of both ways.
MITSUBA_SAMPLES, MITSUBA_ROUNDS = 16, 9
SLABS = ("plastic_grey_0_4", "gold_coat_0_1_metal_0_1", "three_rough")
SAMPLED = ("clean_copper", "satin_varnish", "frosted_paint", "metallic_car_paint")
BAKED = ("plastic_grey_0", "plastic_tinted", "gold_coat_0_1_metal_0_1", "three_rough")


def walks_per_second(coat: dict, surface: str) -> float:
    """Of one coat over Lambert .5, the best of the repeats."""
    model = make_model("position_free", Stack.from_dict({"layers": [coat], "base": LAMBERT}), surface=surface, walks=WALKS)
    return WALKS / min(processor_seconds(model) for _ in range(REPEATS))


def processor_seconds(model, wo=VIEW) -> float:
    start = time.process_time()
    model.albedo(wo)
    return time.process_time() - start


def cold_seconds(name: str) -> float:
    """Building `adding` and its albedo at `DIRECTIONS` directions: called in a process that has computed nothing yet."""
    base, *layers = COLD_STACKS[name]
    wo = spherical(np.linspace(0.0, np.radians(89.0), DIRECTIONS), 0.0)
    start = time.process_time()
    make_model("adding", Stack.from_dict({"layers": layers, "base": base})).albedo(wo)
    return time.process_time() - start


def cold_f_seconds(name: str) -> float:
    """Building `adding` and its f at sixty pairs of directions."""
    wo = spherical(np.radians(np.linspace(0.0, 85.0, 6)), 0.0)[:, None]
    wi = spherical(np.radians(np.tile(np.linspace(0.0, 80.0, 5), 2)), np.repeat([0.5, 2.8], 5))
    start = time.process_time()
    make_model("adding", TWENTY_LAYERS[name]).f(wo, wi)
    return time.process_time() - start


def seconds_per_million_samples(name: str) -> float:
    """Of `closure_model`, which draws what Cycles draws."""
    model, wo = make_model("closure_model", presets.load(name)), np.repeat(VIEW[None], 1_000_000, axis=0)
    start = time.process_time()
    model.sample(wo, 1)
    return time.process_time() - start


def bake(name: str) -> tuple[float, float]:
    """Processor seconds and peak megabytes of a bake with two glossy lobes: called in a fresh process, too."""
    start = time.process_time()
    make_lobe_set(suite_stack(name), "baked")
    return time.process_time() - start, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3


def seconds_to_one_percent(seconds: float, mean: np.ndarray, stderr: np.ndarray) -> float:
    """Processor seconds that a noisy albedo of this error would take to a standard error of 1 %, in the mean of the channels."""
    return seconds * np.mean(np.square(stderr / mean)) / 0.01**2


def walks_to_one_percent(stack: Stack) -> float:
    model = make_model("position_free", stack, surface="single", walks=WALKS)
    start = time.process_time()
    mean, stderr = model.albedo_stderr(VIEW)
    return seconds_to_one_percent(time.process_time() - start, mean, stderr)


def slabs_to_one_percent(mi, stack: Stack) -> float:
    """Pixels of Mitsuba's picture are independent estimates."""
    scene = mi.load_string(slab_scene(stack), theta=45)
    start = time.process_time()
    pixels = np.array(mi.render(scene, spp=MITSUBA_SAMPLES)).reshape(-1, 3)
    seconds = time.process_time() - start
    return seconds_to_one_percent(seconds, pixels.mean(axis=0), pixels.std(axis=0) / np.sqrt(len(pixels)))


def beside_mitsuba() -> None:
    try:
        import mitsuba as mi
    except ImportError:
        print("beside Mitsuba's slabs: it is not installed (make mitsuba)")
        return
    mi.set_variant("scalar_rgb")
    print(f"albedo at 45 degrees to 1 %, processor seconds: position_free, slabs in Mitsuba {mi.__version__}, their quotient and its least and largest")
    for name in SLABS:
        stack = suite_stack(name)
        # in turn, so that other work on the machine slows both; the first of each sets things up
        rounds = [(walks_to_one_percent(stack), slabs_to_one_percent(mi, stack)) for _ in range(MITSUBA_ROUNDS + 1)][1:]
        ours, theirs = np.transpose(rounds)
        quotients = theirs / ours
        print(
            f"  {name:36} {np.median(ours):8.4f} {np.median(theirs):8.4f} {np.median(quotients):6.1f} {quotients.min():6.1f} {quotients.max():6.1f}",
            flush=True,
        )


def main() -> None:
    # as where bakes are made and on the command line; read by what starts from here on
    os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    print("position_free, walks per second of one coat over Lambert .5")
    for surface in ("single", "multiple"):
        for name, coat in COATS.items():
            print(f"  {surface:8} {name:14} {walks_per_second(coat, surface):12,.0f}", flush=True)
    print(f"adding, processor seconds of a cold albedo at {DIRECTIONS} directions")
    with get_context("spawn").Pool(1, maxtasksperchild=1) as fresh:
        for name in COLD_STACKS:
            best = min(fresh.apply(cold_seconds, (name,)) for _ in range(REPEATS))
            print(f"  {name:36} {best:8.2f}", flush=True)
        print("adding, processor seconds of a cold f at 60 pairs of directions")
        for name in TWENTY_LAYERS:
            best = min(fresh.apply(cold_f_seconds, (name,)) for _ in range(REPEATS))
            print(f"  {name:36} {best:8.2f}", flush=True)
        print("closure_model, processor seconds of a million samples")
        for name in SAMPLED:
            best = min(fresh.apply(seconds_per_million_samples, (name,)) for _ in range(REPEATS))
            print(f"  {name:36} {best:8.2f}", flush=True)
        print("baked, processor seconds and peak memory")
        for name in BAKED:
            seconds, megabytes = fresh.apply(bake, (name,))
            print(f"  {name:36} {seconds:8.2f} {megabytes:8.0f} MB", flush=True)
    beside_mitsuba()


if __name__ == "__main__":
    main()
