# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of stacks and models as SVG text, written by hand: they need no other package."""
