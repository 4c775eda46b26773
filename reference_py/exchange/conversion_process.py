# SPDX-License-Identifier: GPL-3.0-or-later
"""Solves one hand-over in a process of its own, as `lobe_set.worker` does with lobe sets, and tells it in the same way."""

import json
import sys

from ..errors import LaminaError
from ..material.stack import Stack
from .hand_over import solved

MODULE = "exchange.conversion_process"


def request(stack: Stack, textured: bool) -> str:
    """What `main` reads."""
    return json.dumps({"stack": stack.to_dict(), "textured": textured})


def main() -> None:
    """Serve one request."""
    data = json.loads(sys.stdin.readline())
    try:
        hand = solved(Stack.from_dict(data["stack"]), data["textured"])
    except LaminaError as error:
        print(f"error {json.dumps(error.sentence.packed())}", flush=True)
        return
    print(f"result {json.dumps(hand.packed())}", flush=True)
