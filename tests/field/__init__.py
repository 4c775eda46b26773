# SPDX-License-Identifier: GPL-3.0-or-later
"""The field test: cases, the trials that they are made of, and the verdicts."""

from . import animation, exporters, files, geometry, materials, rendering  # they register their cases
from .case import CASES, FAILS
