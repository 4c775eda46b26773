# SPDX-License-Identifier: GPL-3.0-or-later
"""The one exception that a user sees: its text is complete on one line."""


class LaminaError(ValueError):
    """Bad input or a missing means. The message names the thing, the value and the choices."""
