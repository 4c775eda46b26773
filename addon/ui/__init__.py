# SPDX-License-Identifier: GPL-3.0-or-later
"""What a user sees: the panel, its icons and its languages."""
