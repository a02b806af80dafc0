// The factors that fits divide out, in float and double alike: fitting and evaluation must use the same ones.
#pragma once

#include <algorithm>
#include <cmath>

namespace alpenglow::sky {

// Close to Preetham's k_Y = Y_z / F(0, theta_s), without trigonometry.
// Where it differs from the exact one, it does so by a smooth factor, which the fit takes up.
template <class Real>
struct PreethamNormaliser {
    Real zenith_slope, zenith_offset, chi_slope, horizon, c, d, e;

    static PreethamNormaliser of(Real t) {
        return {Real(4.0453) * t - Real(4.9710),
                Real(2.4192) - Real(0.2155) * t,
                Real(4) * (Real(4.0 / 9.0) - t / Real(120)),
                Real(1) + (Real(0.1787) * t - Real(1.4630)) * std::exp(Real(0.4275) - Real(0.3554) * t),
                Real(5.3251) - Real(0.0227) * t,
                Real(0.1206) * t - Real(2.5771),
                Real(0.3703) - Real(0.0670) * t};
    }

    // r = sin(theta_s), z = cos(theta_s).
    [[nodiscard]] Real operator()(Real r, Real z) const {
        const Real v = (Real(1) + z - r) / (Real(1) + z + r); // tan of half the sun's altitude
        const Real w = v * v;
        // arctangent, Abramowitz and Stegun 4.4.47 in spirit: error 1e-5
        const Real half_altitude =
            v * (Real(0.99997726) +
                 w * (Real(-0.33262347) +
                      w * (Real(0.19354346) + w * (Real(-0.11643287) + w * (Real(0.05265332) - w * Real(0.0117212))))));
        const Real chi = chi_slope * half_altitude;
        const Real x = chi * chi;
        // tan chi as a Pade quotient; all quotients make one division.
        const Real tangent = chi * (Real(10395) + x * (Real(-1260) + Real(21) * x));
        const Real below = Real(10395) + x * (Real(-4725) + x * (Real(210) - x));
        const Real y = Real(-0.25) * d * (Real(1.5707963267948966) - Real(2) * half_altitude);
        const Real series = Real(1) + y * (Real(1) + y * (Real(0.5) + y * Real(1.0 / 6.0)));
        const Real square = series * series;
        const Real power = square * square; // e^(-d theta), nearly
        return Real(1000) * (zenith_slope * tangent + zenith_offset * below) * power /
               (below * horizon * (power + c + e * z * z * power));
    }
};

} // namespace alpenglow::sky
