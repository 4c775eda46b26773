# SPDX-License-Identifier: GPL-3.0-or-later
"""What was computed for a stack, by content: names, sources, unknown keys and what float32 leaves out do not matter."""

import hashlib
import json
from collections.abc import Callable
from typing import TypeVar

from ...stack import Stack

_LIMIT = 256
_memory: dict[tuple, object] = {}

T = TypeVar("T")


def remembered(stack: Stack, what: tuple, make: Callable[[], T]) -> T:
    """What `make` gave for a stack of this content before, or gives now."""
    key = content(stack), *what
    if key not in _memory:
        if len(_memory) >= _LIMIT:
            _memory.pop(next(iter(_memory)))
        _memory[key] = make()
    return _memory[key]


def content(stack: Stack) -> str:
    """A hash of what a stack is made of."""
    elements = [[e.kind, *((name, _rounded(value)) for name, value in sorted(e.values.items()))] for e in (*stack.layers, stack.base)]
    return hashlib.sha256(json.dumps(elements).encode()).hexdigest()


def truth_of(stack: Stack):
    """The deterministic truth of a stack."""
    from ...models.adding.model import Adding  # models import networks

    return Adding(stack)


def _rounded(value):
    if isinstance(value, tuple):
        return [_rounded(v) for v in value]
    return f"{value:.5g}" if isinstance(value, float) else value
