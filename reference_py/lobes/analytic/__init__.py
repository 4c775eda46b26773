# SPDX-License-Identifier: GPL-3.0-or-later
"""Tier `analytic`: a stack's energies and lobes by formulas and small tables, for parameters that vary in space and time."""

from .lobe_set import AnalyticLobes
