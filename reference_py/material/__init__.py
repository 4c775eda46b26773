# SPDX-License-Identifier: GPL-3.0-or-later
"""The material as the user means it: schema, stacks, JSON, presets. No optics."""
