# SPDX-License-Identifier: GPL-3.0-or-later
"""Unpolarised Fresnel reflectance of dielectrics and conductors (Born and Wolf 1999, sections 1.5 and 14.4)."""

import numpy as np


def cos_theta_t(cos_theta_i: np.ndarray, eta_it) -> np.ndarray:
    """Cosine of the refracted angle for eta_it = n_t / n_i; 0 under total internal reflection."""
    return np.sqrt(np.maximum(1.0 - (1.0 - np.square(cos_theta_i)) / np.square(eta_it), 0.0))


def fresnel_dielectric(cos_theta_i: np.ndarray, eta_it) -> np.ndarray:
    """Reflectance of a dielectric interface for light that meets it at cos_theta_i >= 0.

    eta_it = n_t / n_i in travel direction; 1 beyond the critical angle.
    """
    cos_i = np.minimum(np.maximum(cos_theta_i, 0.0), 1.0)
    eta = np.asarray(eta_it, float)
    sin2_t = (1.0 - np.square(cos_i)) / np.square(eta)
    cos_t = np.sqrt(np.maximum(1.0 - sin2_t, 0.0))
    # At grazing incidence with eta = 1 both quotients are 0 / 0: such an interface reflects nothing.
    with np.errstate(invalid="ignore", divide="ignore"):
        near, far = eta * cos_t, eta * cos_i
        r_s, r_p = cos_i - near, far - cos_t
        # in place: arrays are large where it counts
        near += cos_i
        far += cos_t
        r_s /= near
        r_p /= far
        r_s *= r_s
        r_p *= r_p
        r_s += r_p
        r_s *= 0.5
    reflectance = np.where(sin2_t >= 1.0, 1.0, r_s)
    return reflectance if eta.ndim == 0 and eta != 1.0 else np.where(eta == 1.0, 0.0, reflectance)


def fresnel_conductor(cos_theta_i: np.ndarray, eta, k) -> np.ndarray:
    """Reflectance of a conductor of complex index eta + i k relative to the medium above. Broadcasts."""
    cos_i = np.minimum(np.maximum(cos_theta_i, 0.0), 1.0)
    cos2 = np.square(cos_i)
    sin2 = 1.0 - cos2
    eta2, k2 = np.square(eta), np.square(k)
    # in place: arrays are large where it counts
    twice = eta2 - k2 - sin2
    a2_plus_b2 = np.square(twice)
    a2_plus_b2 += 4.0 * eta2 * k2
    a2_plus_b2 = np.sqrt(a2_plus_b2)
    twice += a2_plus_b2
    twice *= 0.5
    twice = np.sqrt(np.maximum(twice, 0.0))
    twice *= 2.0 * cos_i
    t3 = cos2 * a2_plus_b2
    t3 += np.square(sin2)
    t4 = twice * sin2
    a2_plus_b2 += cos2
    r_s = a2_plus_b2 - twice
    a2_plus_b2 += twice
    r_s /= a2_plus_b2
    r_p = t3 - t4
    r_p *= r_s
    t3 += t4
    r_p /= t3
    r_s += r_p
    r_s *= 0.5
    return r_s
