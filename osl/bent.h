// SPDX-License-Identifier: GPL-3.0-or-later
// The normal about which Cycles puts a glossy closure of normal n. Where the view would be mirrored below the surface, Cycles
// bends n towards the geometric normal until its mirror image is just above (kernel/closure/bsdf_util.h), but on strands.
// In the plane of both normals, with angles from ng, let the view's projection p lie at psi. A normal at phi mirrors it to
// the height |p| cos(2 phi - psi), so phi halves the angle between p and the direction in which |p| has the wanted height.
normal bent(normal n, vector wo, normal ng)
{
    float z = dot(wo, ng);
    float least = min(0.9 * z, 0.01);
    normal result = n;
    if (2.0 * dot(n, wo) * dot(n, ng) - z < least) {
        int is_strand = 0;
        getattribute("geom:is_curve", is_strand);
        if (!is_strand) {
            vector x = normalize(n - dot(n, ng) * ng);
            vector y = cross(ng, x);
            vector p = wo - dot(wo, y) * y;
            float height = least / length(p);
            result = normalize(normalize(p) + height * ng + sqrt(1.0 - height * height) * x);
        }
    }
    return result;
}
