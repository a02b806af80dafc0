// The colour conversions of colour.hpp for float and double, inline for the models' inner loops.
#pragma once

#include <algorithm>

#include <glm/vec3.hpp>

namespace alpenglow::sky {

// Rec.709 primaries and white D65 (0.3127, 0.3290).
template <class Real>
glm::vec<3, Real> xyz_to_rec709_of(const glm::vec<3, Real>& v) {
    return {Real(3.2409699419045213) * v.x - Real(1.5373831775700935) * v.y - Real(0.4986107602930033) * v.z,
            Real(-0.9692436362808798) * v.x + Real(1.8759675015077206) * v.y + Real(0.0415550574071756) * v.z,
            Real(0.0556300796969936) * v.x - Real(0.2039769588889765) * v.y + Real(1.0569715142428784) * v.z};
}

template <class Real>
glm::vec<3, Real> yxy_to_rec709_of(const glm::vec<3, Real>& v) {
    const Real y = v.z;
    if (!(y > Real(1e-6))) {
        return glm::vec<3, Real>(0);
    }
    const Real scale = v.x / y;
    return xyz_to_rec709_of(glm::vec<3, Real>(v.y * scale, v.x, (Real(1) - v.y - y) * scale));
}

template <class Real>
Real luminance_of(const glm::vec<3, Real>& rgb) {
    return Real(0.2126) * rgb.x + Real(0.7152) * rgb.y + Real(0.0722) * rgb.z;
}

template <class Real>
glm::vec<3, Real> into_gamut_of(const glm::vec<3, Real>& rgb) {
    const Real white = luminance_of(rgb);
    if (!(white > Real(0))) {
        return glm::vec<3, Real>(0);
    }
    const Real least = std::min({rgb.x, rgb.y, rgb.z});
    if (least >= Real(0)) {
        return rgb;
    }
    const Real keep = white / (white - least);
    const auto mix = [&](Real component) { return std::max(white + keep * (component - white), Real(0)); };
    return {mix(rgb.x), mix(rgb.y), mix(rgb.z)};
}

} // namespace alpenglow::sky
