# SPDX-License-Identifier: GPL-3.0-or-later
"""Models turn a stack into numbers: the paper's, the truths, and other people's for comparison (`baselines`)."""
