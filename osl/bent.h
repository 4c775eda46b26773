// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Filled in from reference_py (addon/shader/osl/osl_files.py).
#define MIN_COS_O 1.0

// The normal about which Cycles puts a glossy closure of normal n. Where the view would be mirrored below the surface, Cycles
// bends n towards the geometric normal until its mirror image has a least height (kernel/closure/bsdf_util.h), but on strands.
// The normal m = n + k ng, of any length, mirrors the view to the height 2 (m.wo) (m.ng) / (m.m) - z: a quadratic equation
// for k, whose roots have different signs.
normal bent(normal n, vector wo, normal ng)
{
    normal result = n;
    float z = dot(wo, ng);
    float least = min(0.9 * z, 0.01);
    float missing = least + z - 2.0 * dot(n, wo) * dot(n, ng);
    if (missing > 0.0) {
        float is_strand = 0.0;
        getattribute("geom:is_curve", is_strand);
        float half = dot(n, wo) - least * dot(n, ng);
        float root = sqrt(half * half + (z - least) * missing);
        if (is_strand == 0.0)
            result = normalize(n + (root - half) / (z - least) * ng);
    }
    return result;
}

// Cosine of that normal and the view; Cycles' I points from the surface to the viewer.
float view_cosine(normal bent_normal, vector wo)
{
    return clamp(dot(bent_normal, wo), MIN_COS_O, 1.0);
}
