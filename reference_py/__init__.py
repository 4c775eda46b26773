# SPDX-License-Identifier: GPL-3.0-or-later
"""The numpy reference: schema, stacks, optics, models and lobe sets. No bpy here.

Conventions are stated once, in `frame.py`; the sources that docstrings cite by a short key
(Weidlich07, Heitz14, ...) are listed in `reference_py/README.md`.
"""
