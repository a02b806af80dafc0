// Against ringing at the horizon: a sky ends there, and a few bands cannot end so sharply.
#pragma once

#include <alpenglow/sky/sky_fit.hpp>

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

    [[nodiscard]] int bands() const { return bands_; }

private:
    int bands_;
    std::array<std::array<double, 49>, 7> matrix_{}; // [m][l - m][l' - m], stride 7
};

// A fit with a filter in its rows, so that filtering costs nothing at run time: filters are linear and commute with the
// azimuth. The result has exactly the filter's bands (at most the fit's), all of which are to be evaluated: fewer bands
// want a filter of their own.
[[nodiscard]] SkyFit filtered_fit(const SkyFit& fit, const HorizonFilter& filter);
// The same with eq. 5.
[[nodiscard]] SkyFit filtered_fit_zonal_sinc(const SkyFit& fit, int bands);

} // namespace alpenglow::sky
