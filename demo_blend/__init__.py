# SPDX-License-Identifier: GPL-3.0-or-later
"""Scripts that build every demo scene, and the .blend files they built."""
