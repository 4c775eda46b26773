# SPDX-License-Identifier: GPL-3.0-or-later
"""`adding`: noise-free albedo, transmittance and f of a stack by matrix operators (Stam01; Jakob14)."""

from .adding_model import Adding, LayerEnergies

__all__ = ["Adding", "LayerEnergies"]
