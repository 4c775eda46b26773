# SPDX-License-Identifier: GPL-3.0-or-later
"""What users choose of how a stack is told to Cycles, and the defaults. How each quality works is a row of `lobes.methods.METHODS`."""

PAPER, ANALYTIC, BAKED, AUTO = "weidlich_wilkie", "analytic", "baked", "auto"
QUALITIES = {
    PAPER: "Every value live, as the paper of 2007 has it, whose energy is far from the truth's",
    ANALYTIC: "Every value live, all reflections between the layers computed while shading: for textures and animation of many values",
    BAKED: "The truth, computed once when values rest and fitted by few lobes: closest and cheapest",
    AUTO: "Live while values change; when they rest, the cheapest shader whose error stays under the tolerance",
}
DEFAULT_METHOD = AUTO
# Largest visible error that auto may choose, as a share of the light.
DEFAULT_TOLERANCE = 0.02
