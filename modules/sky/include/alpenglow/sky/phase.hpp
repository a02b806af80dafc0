// Phase functions of the course (SIGGRAPH 2003, "Fundamentals of light transport", eq. 1 to 6), normalised to 1 over
// the sphere: per steradian. `cosine` is that of the angle between the directions of travel before and after (1:
// straight on). Safe for |g| <= 0.9999: (1-g)^2 + 2 g (1 - cosine) never vanishes where 1 + g^2 - 2 g cosine does in
// single precision.
#pragma once

#include <cmath>

namespace alpenglow::sky {

// Eq. 1.
template <class Real>
[[nodiscard]] inline Real phase_isotropic() {
    return Real(0.07957747154594767);
}

// (1-g)^2 + 2 g (1 - cosine), or its mirror image for negative g: distance^2 in Henyey and Greenstein's ellipse.
template <class Real>
[[nodiscard]] inline Real phase_distance(Real cosine, Real g) {
    const Real forward = g >= Real(0) ? Real(1) - cosine : Real(1) + cosine;
    const Real a = g >= Real(0) ? g : -g;
    return (Real(1) - a) * (Real(1) - a) + Real(2) * a * forward;
}

// Eq. 2, Henyey and Greenstein; mean cosine g.
template <class Real>
[[nodiscard]] inline Real phase_henyey_greenstein(Real cosine, Real g) {
    const Real d = phase_distance(cosine, g);
    return Real(0.07957747154594767) * (Real(1) - g) * (Real(1) + g) / (d * std::sqrt(d));
}

// Eq. 3, a forward lobe g1 and a backward lobe g2 with share f; mean cosine (1-f) g1 + f g2.
template <class Real>
[[nodiscard]] inline Real phase_double_henyey_greenstein(Real cosine, Real g1, Real g2, Real f) {
    return (Real(1) - f) * phase_henyey_greenstein(cosine, g1) + f * phase_henyey_greenstein(cosine, g2);
}

// Eq. 4, Schlick, with the sign that makes k > 0 forward in our convention of the angle: (1 - k cosine).
template <class Real>
[[nodiscard]] inline Real phase_schlick(Real cosine, Real k) {
    const Real forward = k >= Real(0) ? Real(1) - cosine : Real(1) + cosine;
    const Real a = k >= Real(0) ? k : -k;
    const Real d = (Real(1) - a) + a * forward; // 1 - k cosine
    return Real(0.07957747154594767) * (Real(1) - k) * (Real(1) + k) / (d * d);
}

// Eq. 5 without its wavelength dependence, which belongs to the scattering coefficient; mean cosine 0.
template <class Real>
[[nodiscard]] inline Real phase_rayleigh(Real cosine) {
    return Real(0.05968310365946075) * (Real(1) + cosine * cosine);
}

// Eq. 6, Cornette and Shanks; Rayleigh's for g = 0; mean cosine 3 g (4 + g^2) / (5 (2 + g^2)).
template <class Real>
[[nodiscard]] inline Real phase_cornette_shanks(Real cosine, Real g) {
    const Real d = phase_distance(cosine, g);
    return Real(0.1193662073189215) * (Real(1) - g) * (Real(1) + g) * (Real(1) + cosine * cosine) /
           ((Real(2) + g * g) * d * std::sqrt(d));
}

} // namespace alpenglow::sky
