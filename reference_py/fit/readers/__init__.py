# SPDX-License-Identifier: GPL-3.0-or-later
"""Readers: each turns one kind of file into a `Measurement`, or says in one line what is wrong with the file; `by_suffix` chooses."""

SUFFIXES = (".binary", ".bsdf", ".brdf", ".csv", ".txt", ".astm", ".dat")
