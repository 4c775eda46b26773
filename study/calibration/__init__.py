# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of the programs that find constants: stacks to train on and to hold out, constants in force, their text."""
