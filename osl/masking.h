// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Smith's height-correlated masking and shadowing, as Cycles evaluates it (Walter 2007, Heitz 2014).
float smith_lambda(float cos_theta, float alpha, int beckmann)
{
    float a2_tan2 = alpha * alpha * max(1.0 / (cos_theta * cos_theta) - 1.0, 0.0);
    if (!beckmann)
        return 0.5 * (sqrt(1.0 + a2_tan2) - 1.0);
    if (a2_tan2 <= 1.0 / (1.6 * 1.6))
        return 0.0;
    float a = 1.0 / sqrt(a2_tan2);
    return ((0.396 * a - 1.259) * a + 1.0) / ((2.181 * a + 3.535) * a);
}

float masking_g2(float cos_theta_i, float cos_theta_o, float alpha, int beckmann)
{
    return 1.0 / (1.0 + smith_lambda(cos_theta_i, alpha, beckmann) + smith_lambda(cos_theta_o, alpha, beckmann));
}
