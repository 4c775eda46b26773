# SPDX-License-Identifier: GPL-3.0-or-later
"""The published suites of stacks on which models are compared.

data/suite.json: plastics, coated metals and slabs of up to twenty layers; rough over smooth and back, absorbing and not.
data/scattering_suite.json: media that scatter.
"""

import json
from functools import lru_cache
from pathlib import Path

from ..reference_py.errors import LaminaError
from ..reference_py.material import presets
from ..reference_py.material.stack import Stack

_DATA = Path(__file__).parent / "data"


def suite() -> dict[str, Stack]:
    """The stacks of clear layers by name, in the file's order."""
    return _read("suite.json")


def scattering_suite() -> dict[str, Stack]:
    """The stacks with media that scatter."""
    return _read("scattering_suite.json")


@lru_cache(maxsize=2)
def _read(name: str) -> dict[str, Stack]:
    stacks = json.loads((_DATA / name).read_text(encoding="utf-8"))["stacks"]
    return {data["name"]: Stack.from_dict(data, f"{name}: {data['name']}") for data in stacks}


def charted() -> dict[str, Stack]:
    """The presets of the paper and the suite, which the charts of errors go through."""
    return {name: presets.load(name) for name in presets.PAPER} | {f"suite/{name}": stack for name, stack in suite().items()}


def suite_stack(name: str) -> Stack:
    """One stack of the suite. Raises LaminaError on an unknown name."""
    if name not in suite():
        raise LaminaError(f"unknown suite stack {name!r}; choose {', '.join(suite())}")
    return suite()[name]
