# SPDX-License-Identifier: GPL-3.0-or-later
"""What a method is: one row of `METHODS`."""

from collections.abc import Callable
from dataclasses import dataclass

from ...material.place import Place
from ...material.schema import ANISOTROPY, THIN_FILM
from ...material.stack import Stack
from ...optics.optical_stack import USERS, Support
from ..cache import cached, get
from ..made import Made, Options


@dataclass(frozen=True)
class Computed:
    """How what a method computes first is kept: `key` names it, `pack` makes JSON's types of it, `unpack` takes them.

    What is kept is the method's own: tables, or a choice. `is_instant` says of which stacks nothing has to be computed.
    """

    compute: Callable[[Stack, Options], object]
    key: Callable[[Stack, Options], str]
    pack: Callable[[object], dict]
    unpack: Callable[[dict, Stack], object]
    is_instant: Callable[[Stack, Options], bool] = lambda stack, options: False
    most_glossy: int = 0

    def result(self, stack: Stack, options: Options):
        """What was computed before, or is now."""
        return cached(self.key(stack, options), lambda: self.compute(stack, options), self.pack, lambda data: self.unpack(data, stack))

    def is_cached(self, stack: Stack, options: Options) -> bool:
        """Whether it takes no time, as it was computed before or needs no computing."""
        return self.is_instant(stack, options) or get(self.key(stack, options), lambda data: self.unpack(data, stack)) is not None

    def put(self, key: str, stack: Stack, data: dict) -> None:
        """Keep what another process packed."""
        cached(key, lambda: self.unpack(data, stack), self.pack, lambda packed: self.unpack(packed, stack))


@dataclass(frozen=True)
class Method:
    """One way to tell Cycles about a stack without coverage.

    `follows` says whether its shaders follow live values; where they do not, the lobes of `analytic` stand in. Where `computed` is None it takes no time, and its shaders hold a stack's
    structure alone; else they hold values too.
    """

    name: str
    make: Callable[[Stack, Options], Made]
    follows: Callable[[Stack, tuple[Place, ...]], bool]
    computed: Computed | None = None
    support: Support = Support(features=(ANISOTROPY, THIN_FILM))
    role: str = "method"

    def __post_init__(self) -> None:
        USERS.setdefault(self.role, {})[self.name] = self.support
