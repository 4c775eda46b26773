# SPDX-License-Identifier: GPL-3.0-or-later
"""Fresnel, microfacet and diffuse formulas, and the optical form of a stack."""
