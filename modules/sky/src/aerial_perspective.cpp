#include <alpenglow/sky/aerial_perspective.hpp>

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

namespace alpenglow::sky {
namespace {

using namespace glm;
#include "aerial_perspective.glsl"

AlpenglowAir shader_air(const Air& air) {
    return {air.rayleigh_per_m, air.mie_per_m, air.rayleigh_height_m, air.mie_height_m, air.mie_g};
}

} // namespace

Air make_air(float turbidity) {
    Air air;
    const float t = turbidity >= 1.0F ? std::min(turbidity, 20.0F) : 1.0F;
    // Preetham et al. 1999, appendix A.1: beta at 1 micrometre, depth = beta lambda^-1.3 (1.651, 2.175 and 2.907).
    const float beta = std::max(0.04608366F * t - 0.04586026F, 0.0F);
    air.mie_per_m = glm::vec3(1.6510F, 2.1753F, 2.9074F) * (beta / air.mie_height_m);
    return air;
}

float optical_length_m(float height_m, float rise, float distance_m, float scale_m) {
    return alpenglow_optical_length(height_m, rise, distance_m, scale_m);
}

AerialPerspective aerial_perspective(const Air& air, float height_m, const glm::vec3& direction, float distance_m,
                                     const glm::vec3& to_sun, const glm::vec3& sun_lux,
                                     const glm::vec3& ambient_cd_m2) {
    const AlpenglowAerial result =
        alpenglow_aerial_perspective(shader_air(air), height_m, direction.z, distance_m,
                                     std::clamp(glm::dot(direction, to_sun), -1.0F, 1.0F), sun_lux, ambient_cd_m2);
    return {result.transmittance, result.in_scatter};
}

AerialPerspective march_aerial_perspective(const Air& air, float height_m, const glm::vec3& direction, float distance_m,
                                           const glm::vec3& to_sun, const glm::vec3& sun_lux,
                                           const glm::vec3& ambient_cd_m2, int steps) {
    const double cos_sun = std::clamp(glm::dot(glm::dvec3(direction), glm::dvec3(to_sun)), -1.0, 1.0);
    const double g = air.mie_g;
    const double d = (1.0 - g) * (1.0 - g) + 2.0 * g * (1.0 - cos_sun);
    const glm::dvec3 rayleigh_source =
        glm::dvec3(sun_lux) * (0.059683103659460751 * (1.0 + cos_sun * cos_sun)) + glm::dvec3(ambient_cd_m2);
    const glm::dvec3 mie_source =
        glm::dvec3(sun_lux) * (0.079577471545947668 * (1.0 - g * g) / (d * std::sqrt(d))) + glm::dvec3(ambient_cd_m2);
    const double step_m = static_cast<double>(distance_m) / steps;
    glm::dvec3 transmittance(1.0);
    glm::dvec3 in_scatter(0.0);
    for (int i = 0; i < steps; ++i) {
        const double height = static_cast<double>(height_m) + static_cast<double>(direction.z) * (i + 0.5) * step_m;
        const glm::dvec3 rayleigh = glm::dvec3(air.rayleigh_per_m) * std::exp(-height / air.rayleigh_height_m);
        const glm::dvec3 mie = glm::dvec3(air.mie_per_m) * std::exp(-height / air.mie_height_m);
        const glm::dvec3 half = glm::exp((rayleigh + mie) * (-0.5 * step_m));
        in_scatter += transmittance * half * (rayleigh * rayleigh_source + mie * mie_source) * step_m;
        transmittance *= half * half;
    }
    return {glm::vec3(transmittance), glm::vec3(in_scatter)};
}

} // namespace alpenglow::sky
