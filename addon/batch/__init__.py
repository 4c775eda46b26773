# SPDX-License-Identifier: GPL-3.0-or-later
"""Batches: many looks of stacks rendered by several processes, resumable, each picture with its origin in its header."""
