# SPDX-License-Identifier: GPL-3.0-or-later
"""Lobe sets: what Cycles is told about a stack, as lobes that depend on the view alone."""
