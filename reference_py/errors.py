# SPDX-License-Identifier: GPL-3.0-or-later
"""The one exception that a user sees: its text is complete on one line."""


class LaminaError(ValueError):
    """Bad input or a missing means. The message names the thing, the value and the choices."""


def one_of(what: str, name: str, value, choices) -> object:
    """The value, where it is one of the choices. Raises LaminaError naming `what` it is an option of, its name, the value and the choices."""
    if value not in choices:
        raise LaminaError(f"{what}: unknown {name} {value!r}; choose {', '.join(choices)}")
    return value
