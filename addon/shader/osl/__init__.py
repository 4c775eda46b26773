# SPDX-License-Identifier: GPL-3.0-or-later
"""A lobe set as the text of an OSL shader; `generate` is the way in."""
