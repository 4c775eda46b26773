# SPDX-License-Identifier: GPL-3.0-or-later
"""Solves hand-overs in a process of its own, as `bake_process` does with lobe sets, and tells them in the same way.

It takes requests of bakes too: a hand-over that follows the bake of its stack shares what that computed.
"""

import json
import sys

from ..errors import LaminaError
from ..lobes.methods import bake_process
from ..material.stack import Stack
from .hand_over import solved

MODULE = "exchange.conversion_process"


def request(stack: Stack, textured: bool) -> str:
    """A line that `main` reads."""
    return json.dumps({"stack": stack.to_dict(), "textured": textured})


def main() -> None:
    """Serve requests, those of `bake_process` among them, until there are no more."""
    for line in sys.stdin:
        data = json.loads(line)
        (_serve if "textured" in data else bake_process.serve)(data)


def _serve(data: dict) -> None:
    try:
        hand = solved(Stack.from_dict(data["stack"]), data["textured"])
    except LaminaError as error:
        print(f"error {json.dumps(error.sentence.packed())}", flush=True)
        return
    print(f"result {json.dumps(hand.packed())}", flush=True)
