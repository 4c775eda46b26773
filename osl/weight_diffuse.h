// SPDX-License-Identifier: GPL-3.0-or-later
// What `depth` interfaces leave of a Lambert base's albedo, averaged over fixed light directions of cosine density.
color weight_diffuse(int depth, float n[], float alpha[], int beckmann[], color tau[], float view_z)
{
@NODES@
    float view_sin = sqrt(max(1.0 - view_z * view_z, 0.0));
    color left = color(0.0);
    for (int s = 0; s < @NODE_COUNT@; ++s) {
        float z_i = sqrt(node_u[s]);
        float cos_2h = z_i * view_z + sqrt(1.0 - node_u[s]) * node_cos_phi[s] * view_sin;
        float cos_h = sqrt(max(0.5 * (1.0 + cos_2h), 0.0));
        float z_h = 0.5 * (z_i + view_z) / max(cos_h, 1e-6);
        float z_o = view_z;
        left += node_weight[s] * carried_through(depth, n, alpha, beckmann, tau, z_h, cos_h, z_i, z_o);
    }
    return left;
}
