# SPDX-License-Identifier: GPL-3.0-or-later
"""What users choose of how a stack is told to Cycles, and the defaults. How each quality works is a row of `lobes.methods.METHODS`."""

PAPER, ANALYTIC, BAKED, AUTO = "weidlich_wilkie", "analytic", "baked", "auto"
QUALITIES = {
    PAPER: "Follows every value at once, as in the paper of 2007: often too dark or too bright",
    ANALYTIC: "Follows every value, texture and animation at once; a little less exact than what is computed first",
    BAKED: "Computed in the background when values rest: the closest look at the lowest cost",
    AUTO: "Preview while values change; when they rest, the cheapest shader that keeps to the tolerance",
}
DEFAULT_METHOD = AUTO
# Largest visible error that auto may choose, as a share of the light.
DEFAULT_TOLERANCE = 0.02
