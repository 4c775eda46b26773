# SPDX-License-Identifier: GPL-3.0-or-later
"""Throws broken input at every reader: each must answer with a value or with one line, never with anything else.

    fuzz.py [COUNT [TABLE.txt]]      inputs in all, shared among the readers (default: 100000; some minutes of one core)

Some of the inputs are made by hypothesis from the grammar of JSON with the readers' own keys, the others are whole files with
bytes changed, cut, doubled or put in. What it finds becomes a case of a test. Prints a row per reader, also into TABLE.txt; exit code 1
on a finding.
"""

import importlib
import json
import os
import random
import shutil
import sys
import tempfile
import traceback
import warnings
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.measured import merl_bytes, merl_values, rgl_fields, table_text, tensor_bytes

from lamina.addon.batch.items import expand
from lamina.addon.batch.job import KEYS, Job
from lamina.reference_py.atomic import write_text
from lamina.reference_py.errors import LaminaError
from lamina.reference_py.fit.readers.by_suffix import read
from lamina.reference_py.fit.readers.measurement import spread_pairs
from lamina.reference_py.lobes import cache
from lamina.reference_py.lobes.methods import is_cached, key_of, make_lobe_set
from lamina.reference_py.material import presets
from lamina.reference_py.material.schema import SCHEMA
from lamina.reference_py.material.stack import Stack
from lamina.study.stamp import stamp

COUNT, SEED = 100_000, 5
HOME = Path(tempfile.mkdtemp(prefix="lamina-fuzz."))


def read_stack(text: str) -> None:
    """Also written again and read back: what is read must be what was written."""
    stack = Stack.from_json(text)
    again = Stack.from_json(stack.to_json())
    assert again.to_dict() == stack.to_dict()
    stack.unknown_keys()


def read_job(text: str) -> None:
    job = Job.from_json(text, HOME / "job.json")
    if len(job.stacks) * len(job.views) * len(job.frames) < 500:
        for item in expand(job)[:50]:
            assert item.file == Path(item.file).name and item.file[0] != "."


def read_cache(text: str) -> None:
    cache._memory.clear()
    stack = presets.load("clean_copper")
    for method in ("auto", "baked"):
        cache._file(key_of(stack, method)).write_text(text, encoding="utf-8", errors="replace")
        is_cached(stack, method)


def read_preset_file(data: bytes) -> None:
    path = HOME / "preset.json"
    path.write_bytes(data)
    presets.load(path)


def read_picture(data: bytes) -> None:
    from lamina.addon.blender.images import read_exr

    path = HOME / "picture.exr"
    path.write_bytes(data)
    read_exr(path)


def reader_of(suffix: str):
    """A reader of measurements whose files end in `suffix`."""

    def read_measurement(data: bytes) -> None:
        path = (HOME / "measured").with_suffix(suffix)
        path.write_bytes(data)
        m = read(path)
        assert np.all(np.isfinite(m.f)) and np.all(m.f >= 0.0) and np.all(m.wi[:, 2] > 0.0) and np.all(m.wo[:, 2] > 0.0)

    return read_measurement


def measurements() -> dict[str, list[bytes]]:
    """Small measured files by suffix."""
    wi, wo = spread_pairs(30, np.random.default_rng(SEED))
    f = np.linspace(0.1, 0.5, 90).reshape(30, 3)
    tensors = [rgl_fields(thetas=3, cells=5), rgl_fields(thetas=3, cells=5, wavelength_nm=(450.0, 550.0, 650.0))]
    return {".binary": [merl_bytes(merl_values(sizes=(6, 6, 12)))], ".bsdf": [tensor_bytes(fields) for fields in tensors],
            ".csv": [table_text(wi, wo, f).encode()]}  # fmt: skip


def keys() -> list[str]:
    kinds = [*SCHEMA.layers.values(), *SCHEMA.bases.values()]
    names = {p.name for kind in kinds for p in kind.all_parameters} | {c for kind in kinds for p in kind.all_parameters for c in p.choices}
    return sorted(
        names
        | {k.name for k in KEYS}
        | {k.name for k in kinds}
        | {
            "layers",
            "base",
            "kind",
            "schema_version",
            "name",
            "stack",
            "blend",
            "object",
            "parameter",
            "values",
            "from",
            "to",
            "steps",
            "chosen",
            "lobe_set",
            "tried",
            "reason",
            "layers[0].roughness",
            "base.color",
            "ball",
            "1-24",
            *presets.names(),
        }
    )


def values():
    numbers = st.integers() | st.floats() | st.sampled_from([0, 1, -1, 2, 0.5, 1e308, -0.0, 1e-320, 2**63, 10**400])
    leaves = st.none() | st.booleans() | numbers | st.text(max_size=12) | st.sampled_from(keys())
    names = st.sampled_from(keys()) | st.text(max_size=6)
    return st.recursive(leaves, lambda inner: st.lists(inner, max_size=5) | st.dictionaries(names, inner, max_size=6), max_leaves=12)


def grown(base: dict, others: Sequence[str] = ()):
    """A valid file with some of its keys replaced, and `others` added."""
    return st.dictionaries(st.sampled_from([*sorted(base), *others]), values(), max_size=3).map(lambda changes: base | changes)


def bent(data: bytes, rng: random.Random) -> bytes:
    """A file with a few things wrong."""
    data = bytearray(data)
    for _ in range(rng.randint(1, 6)):
        at, length = rng.randrange(len(data) + 1), rng.choice((1, 1, 2, 4, 16, 200))
        what = rng.randrange(6)
        if what == 0 and at < len(data):
            data[at] = rng.randrange(256)
        elif what == 1:
            del data[at : at + length]
        elif what == 2:
            data[at:at] = data[at : at + length]
        elif what == 3:
            data[at:at] = rng.randbytes(length)
        elif what == 4:
            data[at : at + length] = rng.choice((b"\xff", b"\0", b"9", b"[", b'"', b"-", b"e", b"{")) * length
        elif rng.random() < 0.2:
            del data[at:]
    return bytes(data)


def where_of(error: Exception) -> tuple[str, int]:
    """File and line that raised it."""
    place = traceback.extract_tb(error.__traceback__)[-1]
    return place.filename, place.lineno


class Trial:
    """Counts a reader's answers and keeps what should not have happened."""

    def __init__(self, name: str, read):
        self.name, self._read = name, read
        self.answers, self.findings = Counter(), {}

    def __call__(self, given_input) -> None:
        try:
            self._read(given_input)
            self.answers["read"] += 1
        except LaminaError as error:
            self.answers["refused"] += 1
            if "\n" in str(error):
                self.findings.setdefault(("more than one line", *where_of(error)), (given_input, str(error)))
        except Exception as error:
            self.findings.setdefault((type(error).__name__, *where_of(error)), (given_input, str(error)))
            self.answers["FOUND"] += 1

    def by_grammar(self, strategy, count: int) -> None:
        @seed(SEED)
        @settings(max_examples=count, deadline=None, database=None, phases=[Phase.generate], suppress_health_check=list(HealthCheck))
        @given(strategy)
        def run(value):
            self(json.dumps(value))

        run()

    def by_bending(self, files: list[bytes], count: int, as_text: bool) -> None:
        rng = random.Random(SEED)
        for _ in range(count):
            data = bent(rng.choice(files), rng)
            self(data.decode("utf-8", "surrogateescape").encode("utf-8", "replace").decode() if as_text else data)


def pictures() -> list[bytes]:
    from lamina.addon.blender import oiio

    rng, files = np.random.default_rng(SEED), []
    for i, shape in enumerate(((4, 4), (17, 40))):
        oiio.write(HOME / f"{i}.exr", {c: rng.random(shape, np.float32) for c in "RGBA"}, {"lamina:inputs": "a" * 64, "lamina:stack": "{}"})
        files.append((HOME / f"{i}.exr").read_bytes())
    return files


def main() -> int:
    importlib.import_module("bpy")  # OpenImageIO lies beside it

    from lamina.addon.blender.environment import ensure_osl_query_on_path

    ensure_osl_query_on_path()
    warnings.simplefilter("error", RuntimeWarning)  # lines on stderr beside the one that is meant
    total = int(sys.argv[1]) if len(sys.argv) > 1 else COUNT
    part = -(-total // 20)
    cache.keep_in(HOME)
    stacks = [presets.load(name).to_json().encode() for name in presets.names()[:8]]
    job = {
        "stacks": ["clean_copper", {"name": "a", "stack": presets.load("frosted_metal").to_dict()}],
        "views": [0, 20],
        "frames": "1-5x2",
        "size": [20, 10],
        "sweeps": [{"parameter": "base.roughness", "values": [0.1, 0.2]}],
        "qualities": ["auto"],
        "scenes": ["ball"],
        "seed": 3,
        "samples": 4,
    }
    make_lobe_set(presets.load("clean_copper"), "auto")
    make_lobe_set(presets.load("clean_copper"), "baked")
    caches = [file.read_bytes() for file in HOME.glob("*.json")]
    trials = [Trial(read.__name__, read) for read in (read_stack, read_job, read_cache, read_preset_file, read_picture)]
    stack_trial, job_trial, cache_trial, preset_trial, picture_trial = trials
    stack_trial.by_grammar(values(), part)
    stack_trial.by_grammar(grown(presets.load("glazed_mug").to_dict(), keys()), part)
    stack_trial.by_bending(stacks, 3 * part, True)
    job_trial.by_grammar(grown(job), part)
    job_trial.by_bending([json.dumps(job).encode()], 3 * part, True)
    cache_trial.by_bending(caches, 2 * part, True)
    preset_trial.by_bending(stacks, 2 * part, False)
    picture_trial.by_bending(pictures(), 3 * part, False)
    for suffix, files in measurements().items():
        trials.append(Trial(f"read {suffix}", reader_of(suffix)))
        trials[-1].by_bending(files, part + part // 3 + 1, False)
    rows = [f"{'reader':18} {'inputs':>8} {'read':>8} {'refused':>8} {'found':>8}"]
    for trial in trials:
        a = trial.answers
        rows.append(f"{trial.name:18} {a.total():8} {a['read']:8} {a['refused']:8} {a['FOUND']:8}")
    rows.append(f"{sum(trial.answers.total() for trial in trials)} inputs, {sum(len(trial.findings) for trial in trials)} findings")
    print("\n".join(rows))
    if len(sys.argv) > 2:
        write_text(Path(sys.argv[2]), "\n".join([f"# make fuzz; {stamp()}", *rows]) + "\n")
    for trial in trials:
        for (kind, file, line), (given_input, message) in trial.findings.items():
            print(f"FOUND by {trial.name}: {kind} at {file}:{line}: {message[:200]}\n  {given_input[:600]!r}")
    return 1 if any(trial.findings for trial in trials) else 0


if __name__ == "__main__":
    code = main()
    shutil.rmtree(HOME, ignore_errors=True)
    sys.stdout.flush()
    os._exit(code)
