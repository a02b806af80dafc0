// Sky radiance projected on spherical harmonics by quadrature: the reference for the fits, and the way in for any
// model. The sky has no lower hemisphere: radiance below the horizon counts as 0, and what the ground sends back is for
// others to add.
#pragma once

#include <alpenglow/sky/preetham.hpp>

#include <functional>
#include <span>

#include <glm/vec3.hpp>

namespace alpenglow::sky {

inline constexpr int max_sky_bands = 7;

// Nodes of the product rule: Gauss-Legendre in elevation, split at the sun, and in azimuth, clustered towards the sun.
struct SkyQuadrature {
    int elevations = 16; // per part: below the sun's elevation and above it
    int azimuths = 32;   // over half the circle: skies are mirror-symmetric about the sun's meridian
};

// Coefficients of bands 0 .. bands-1 (1 .. 7) of a sky that is mirror-symmetric about the plane of zenith and +X, with
// the sun at `sun_zenith_angle_rad` from the zenith towards +X: sine terms (m < 0) are exactly 0. `radiance` is asked
// for unit vectors above the horizon with y >= 0. out holds bands * bands values.
void project_symmetric_sky(const std::function<glm::dvec3(const glm::dvec3&)>& radiance, double sun_zenith_angle_rad,
                           int bands, const SkyQuadrature& quadrature, std::span<glm::dvec3> out);

// Preetham's sky for a sun in the plane of zenith and +X; cd/m^2. The sun's zenith angle is held at pi/2 below the
// horizon.
void project_preetham(double sun_zenith_angle_rad, double turbidity, int bands, const SkyQuadrature& quadrature,
                      std::span<glm::dvec3> out);

// Turns coefficients of a sky that is symmetric about the +X meridian to the azimuth of `to_sun` (Habel et al. 2008,
// eq. 4, for vanishing sine terms). At the zenith the azimuth does not matter: it is left as it is.
void rotate_symmetric_sky(const glm::dvec3& to_sun, int bands, std::span<glm::dvec3> coefficients);
void rotate_symmetric_sky(const glm::vec3& to_sun, int bands, std::span<glm::vec3> coefficients);

} // namespace alpenglow::sky
