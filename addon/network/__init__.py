# SPDX-License-Identifier: GPL-3.0-or-later
"""Backends: a network written so that Cycles can render it."""
