# SPDX-License-Identifier: GPL-3.0-or-later
"""A job's items: one picture each, with a name that stays when the job grows and a hash of all that goes into it."""

import hashlib
import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from math import prod
from pathlib import Path

from ...reference_py.errors import LaminaError
from ...reference_py.material.schema import SCHEMA
from ...reference_py.material.stack import Base, Layer, Stack
from ...reference_py.version import version
from ..material.limits import require_shader
from .job import BALL, MAX_VALUES, Job, Look, Scene, Sweep, inside

BALL_SAMPLES, BALL_SIZE = 64, (256, 256)


@dataclass(frozen=True)
class Item:
    """One picture. `values` are the sweeps' as (parameter, value); `inputs` is the hash of all that it depends on,
    `digest` that of the .blend alone, empty for the ball; `job` names the job and how many pictures it has.

    `samples` and `size` are None where the scene's own count. `file` is the picture's path below the output folder.
    """

    id: str
    file: str
    look: str
    stack: Stack
    values: tuple[tuple[str, object], ...]
    tier: str
    backend: str
    scene: Scene
    blend: str
    view: float
    frame: int
    samples: int | None
    size: tuple[int, int] | None
    seed: int
    inputs: str
    digest: str
    job: str

    def to_dict(self) -> dict:
        """As JSON's types, for another process."""
        return {**vars(self), "stack": self.stack.to_dict(), "scene": vars(self.scene), "values": [list(v) for v in self.values]}

    @classmethod
    def from_dict(cls, data: dict) -> "Item":
        """What `to_dict` gave."""
        size = tuple(data["size"]) if data["size"] else None
        values = tuple((name, value) for name, value in data["values"])
        return cls(**{**data, "stack": Stack.from_dict(data["stack"]), "scene": Scene(**data["scene"]), "values": values, "size": size})

    @property
    def words(self) -> str:
        """What tells it from others of its look."""
        parts = [f"{name.rpartition('.')[2]} {_shown(value)}" for name, value in self.values]
        parts += [self.tier] + ([self.scene.name] if self.scene.name != BALL else []) + ([f"{self.view:g} deg"] if self.view else [])
        return ", ".join(parts)


def expand(job: Job) -> list[Item]:
    """All items of a job, those of one scene and one material side by side. Raises LaminaError."""
    count = len(job.stacks) * prod(len(s.values) for s in job.sweeps) * len(job.qualities) * len(job.scenes) * len(job.views) * len(job.frames)
    if count > MAX_VALUES:
        raise LaminaError(f"job {job.name!r}: {count} pictures; at most {MAX_VALUES} in one job")
    variants = [
        (look, combination, _changed(look, combination))
        for look in job.stacks
        for combination in product(*([(sweep, value) for value in sweep.values] for sweep in job.sweeps))
    ]
    for look, _, stack in variants:
        try:
            require_shader(stack, job.backend)
        except LaminaError as error:
            raise LaminaError(f"stack {look.name!r}: {error}") from None
    items = []
    for scene in job.scenes:
        blend = inside(scene.blend, f"scene {scene.name!r}", job.folder) if scene.blend else None
        digest = _digest_of(blend) if blend else ""
        for (look, combination, stack), tier in product(variants, job.qualities):
            values = tuple((sweep.parameter, value) for sweep, value in combination)
            for view, frame in product(job.views, job.frames):
                items.append(_item(job, count, look, stack, values, tier, scene, blend, digest, view, frame))
    if len({item.id for item in items}) < len(items):
        raise LaminaError(f"job {job.name!r}: a sweep has the same value twice")
    return items


def _item(job, count, look, stack, values, tier, scene, blend, digest, view, frame) -> Item:
    samples = job.samples or (None if blend else BALL_SAMPLES)
    size = job.size or (None if blend else BALL_SIZE)
    seed = (job.seed + frame) % 2**31
    name = f"{_slug(look.name)}-{_hash([look.name, values, tier, scene.name, view])[:10]}"
    inputs = _hash([version(), _content(stack), tier, job.backend, scene.object, digest, view, frame, samples, size, seed])
    file = f"{name}.{frame:04d}.exr"
    told = f"{job.name}, {count} picture{'s' * (count > 1)}"
    return Item(
        f"{name}.{frame:04d}",
        file,
        look.name,
        stack,
        values,
        tier,
        job.backend,
        scene,
        str(blend or ""),
        view,
        frame,
        samples,
        size,
        seed,
        inputs,
        digest,
        told,
    )


def _slug(name: str) -> str:
    """A name that every file system takes."""
    return re.sub(r"[^A-Za-z0-9]+", "_", name).strip("_")[:40] or "stack"


def _hash(data) -> str:
    return hashlib.sha256(json.dumps(data).encode()).hexdigest()


def _digest_of(path: Path) -> str:
    try:
        with open(path, "rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise LaminaError(f"{path}: cannot read: {error.strerror}") from None


def _content(stack: Stack) -> list:
    return [[element.kind, sorted(element.values.items())] for element in (*stack.layers, stack.base)]


def _changed(look: Look, combination: Sequence[tuple[Sweep, object]]) -> Stack:
    """The stack with the sweeps' values. Raises LaminaError for a parameter that it has not."""
    data = look.stack.to_dict()
    for sweep, value in combination:
        where = f"stack {look.name!r}: sweep of {sweep.parameter}"
        if sweep.layer is not None and sweep.layer >= len(look.stack.layers):
            raise LaminaError(f"{where}: it has {len(look.stack.layers)} layers, counted from 0")
        element = look.stack.base if sweep.layer is None else look.stack.layers[sweep.layer]
        _require_parameter(element, sweep.layer is None, sweep.key, where)
        (data["base"] if sweep.layer is None else data["layers"][sweep.layer])[sweep.key] = value
    return Stack.from_dict(data, f"stack {look.name!r} with its sweeps") if combination else look.stack


def _require_parameter(element: Layer | Base, is_base: bool, key: str, where: str) -> None:
    kind = (SCHEMA.bases if is_base else SCHEMA.layers)[element.kind]
    names = [p.name for p in kind.all_parameters]
    if key not in names:
        raise LaminaError(f"{where}: {element.kind} has no {key!r}; choose {', '.join(names)}")


def _shown(value) -> str:
    return "/".join(f"{v:g}" for v in value) if isinstance(value, list) else f"{value:g}" if isinstance(value, float) else str(value)
