// Against ringing at the horizon: a sky ends there, and a few bands cannot end so sharply.
#pragma once

#include <array>
#include <span>

#include <glm/vec3.hpp>

namespace alpenglow::sky {

// Habel et al. 2008, eq. 5: zonal terms times sinc(pi l / N), N the number of bands. A box filter over the zenith
// angle.
void filter_zonal_sinc(int bands, std::span<glm::dvec3> coefficients);
void filter_zonal_sinc(int bands, std::span<glm::vec3> coefficients);

// The filter that gives the least blur above the horizon for its ringing below: of all vectors of these bands, the one
// that minimises |f - sky|^2 over the upper hemisphere plus `weight` times |f|^2 over the lower. It is linear,
// (I + (weight - 1) G)^-1 for each m, G the overlap of the basis below the horizon, and treats the terms that are not
// zonal as well. weight 1 leaves everything as it is.
class HorizonFilter {
public:
    // bands 1 .. 7, weight >= 0.
    HorizonFilter(int bands, double weight);

    // bands * bands coefficients, in any azimuth.
    void apply(std::span<glm::dvec3> coefficients) const;
    void apply(std::span<glm::vec3> coefficients) const;

private:
    int bands_;
    std::array<std::array<double, 49>, 7> matrix_{}; // [m][l - m][l' - m], stride 7
};

} // namespace alpenglow::sky
