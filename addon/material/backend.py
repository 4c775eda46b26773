# SPDX-License-Identifier: GPL-3.0-or-later
"""The ways to write a lobe set in a material: an OSL shader, a group of stock nodes, or both. Does not need bpy."""

from ...reference_py.errors import LaminaError, Sentence
from ..blender import environment

AUTO, OSL, NODES = "auto", "osl", "nodes"
BACKENDS = {
    AUTO: "Both: an OSL shader for CPU and OptiX, and stock nodes that show wherever OSL does not run",
    OSL: "An OSL shader alone, which reads values and textures live; black wherever OSL does not run",
    NODES: "Stock nodes alone, for every device and for EEVEE; of textures and animation they follow what a bake follows",
}
DEFAULT_BACKEND = AUTO


def require_osl() -> None:
    """Raise LaminaError where Script nodes cannot work, before anything is changed."""
    available, reason = environment.osl_available()
    if not available:
        raise LaminaError(
            "backend {osl} needs Cycles with OSL, and {reason}; choose backend {auto} or {nodes}, or use a Blender from blender.org, with CPU or OptiX rendering",
            osl=OSL,
            reason=reason,
            auto=AUTO,
            nodes=NODES,
        )


def branches_here(wanted: str) -> tuple[str, ...]:
    """The branches that `wanted`, a key of BACKENDS, means in this Blender, "osl" before "nodes".

    Raises LaminaError for an unknown backend and for "osl" where there is none.
    """
    if wanted not in BACKENDS:
        raise LaminaError("unknown backend {wanted!r}; choose {choices}", wanted=wanted, choices=", ".join(BACKENDS))
    if wanted == OSL:
        require_osl()
    if wanted == AUTO:
        return (OSL, NODES) if environment.osl_available()[0] else (NODES,)
    return (wanted,)


def notice(wanted: str) -> Sentence:
    """One line for the user where `wanted` leaves the choice and it fell on stock nodes; empty when it did not."""
    if wanted != AUTO or OSL in branches_here(wanted):
        return Sentence("")
    return Sentence(
        "made of stock nodes, because {reason}; of all textures and animation of layers only coverages and what a bake follows have an effect",
        reason=environment.osl_available()[1],
    )
