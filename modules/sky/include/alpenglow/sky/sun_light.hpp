// Sun and moon through the air: illuminance and colour of the direct light, at the ground and over it; the disc as it
// stands in the sky.
#pragma once

#include <alpenglow/sky/colour.hpp>

#include <glm/vec3.hpp>

namespace alpenglow::sky {

// The column of air over the observer, as far as direct light is concerned.
struct AirColumn {
    double turbidity = 2.5;     // clamped to 1 .. 20; sets the aerosol
    double ozone_atm_cm = 0.35; // clamped to 0 .. 2
    double water_cm = 2.0;      // precipitable water, clamped to 0 .. 20
    // The observer's height over the sea, held to 0 .. 100 km: of each constituent only what lies above, or on the way
    // of a ray that comes from below the horizontal, is in the light's way.
    double observer_height_m = 0.0;
};

// The sun outside the atmosphere at one astronomical unit, in lux (Darula, Kittler and Gueymard 2005).
inline constexpr double solar_illuminance_constant_lux = 133334.0;
// The full moon outside the atmosphere at mean distance: magnitude -12.73 (Allen 1976), with 2.54e-6 lux at magnitude
// 0.
inline constexpr double full_moon_illuminance_lux = 0.3136;

// Relative optical length m of the air column (Kasten 1965; course 2003, "Atmosphere"): 1 at the zenith, 36.5 at the
// horizon. `apparent_altitude_rad` is with refraction; below the horizon the value of the horizon.
[[nodiscard]] double relative_optical_length(double apparent_altitude_rad);

// Refraction of a body at a geometric altitude, in radians (Saemundsson 1986, 1010 hPa, 10 degrees C): 0.483 degrees at
// 0. Below -1 degree held at the value there.
[[nodiscard]] double refraction_rad(double geometric_altitude_rad);

// The same for an observer at a height (held to 0 .. 100 km), by the density of the air there; a body below the
// horizontal shines through the layers underneath, twice up to the lowest. Bennett 1982 for the apparent altitude,
// solved for the geometric one, so that apparent altitudes keep their order. Within 0.2 arcmin of the other at sea
// level.
[[nodiscard]] double refraction_rad(double geometric_altitude_rad, double height_m);

// The visible horizon's altitude, <= 0: -acos(R / (R + h)).
[[nodiscard]] double horizon_altitude_rad(double height_m);

// A disc as refraction shows it: an ellipse, flattened near the horizon because its lower limb is lifted more.
struct ApparentDisc {
    double altitude_rad;        // of the ellipse's centre
    double vertical_radius_rad; // semi-axes
    double horizontal_radius_rad;
};
[[nodiscard]] ApparentDisc apparent_disc(double geometric_altitude_rad, double angular_radius_rad,
                                         double height_m = 0.0);

// Brightness of the sun's disc at a fraction 0 .. 1 of its radius, relative to the disc's mean, for R, G and B:
// mu^a with a = -0.023 + 0.292 um / wavelength (Hestroffer and Magnan 1998) at 630, 550 and 450 nm.
[[nodiscard]] glm::dvec3 limb_darkening(double radius_fraction);

// Share of the sun's light that a disc whose centre stands at `altitude_rad` over the horizon sends past it, limb
// darkening included: 0 .. 1, rising and continuous. visible_disc_fraction is the same for an even disc.
[[nodiscard]] glm::dvec3 visible_sun_fraction(double altitude_rad, double vertical_radius_rad);

// Fraction of a disc of `radius_rad` whose centre stands at `altitude_rad` that is above the horizon, 0 .. 1.
[[nodiscard]] double visible_disc_fraction(double altitude_rad, double radius_rad);

// How much of each constituent a ray crosses, relative to the whole column over the sea.
struct SlantColumn {
    double molecules, aerosol, ozone, water;
};
// For a ray to space from an observer at a height (held to 0 .. 100 km): relative_optical_length at sea level, above it
// in proportion to the Chapman function of a spherical layer (Smith and Smith 1972); scale heights 8, 1.25 and 2 km for
// molecules, aerosol and water, ozone a tent from 10 over 25 to 40 km. A ray below the visible horizon counts as one
// that grazes it.
[[nodiscard]] SlantColumn slant_column(double apparent_altitude_rad, double height_m);

// Transmittance of a path of relative optical length m through Rayleigh, aerosol (Angstrom, alpha 1.3), ozone, mixed
// gases and water vapour (Preetham et al. 1999, appendix A.1, after Iqbal 1983), at the spectrum's wavelengths.
[[nodiscard]] Spectrum air_transmittance(const AirColumn& air, double m);
[[nodiscard]] Spectrum air_transmittance(const AirColumn& air, const SlantColumn& column);

// Spectral irradiance of the sun outside the atmosphere, W m^-2 nm^-1, at 1 au: the shape of the table in Preetham et
// al. 1999, scaled to the solar illuminance constant.
[[nodiscard]] const Spectrum& sun_spectrum();

// The same for the full moon at mean distance: redder than the sun, a ramp from 70 % at 340 nm to 135 % at 740 nm
// (Jensen et al. 2001, section 4.2), scaled to full_moon_illuminance_lux.
[[nodiscard]] const Spectrum& moon_spectrum();

// Illuminance on a surface facing the sun, linear Rec.709 in lux, within the gamut, at the column's height. The visible
// part of the refracted, limb-darkened disc is in it: it fades smoothly to 0 as the disc sets behind the horizon that
// the observer sees. Altitude is geometric; `distance_au` scales by its inverse square.
[[nodiscard]] glm::dvec3 sun_illuminance_lux(double geometric_altitude_rad, double angular_radius_rad,
                                             double distance_au, const AirColumn& air);

// The moon's brightness at a phase angle (0 full, pi new) relative to full: Allen's magnitudes, 0.026 |a| + 4e-9 a^4
// with a in degrees (as in Krisciunas and Schaefer 1991, eq. 9). It has the opposition surge that the next function
// lacks.
[[nodiscard]] double moon_phase_factor(double phase_angle_rad);
// The Lommel-Seeliger phase law of Jensen et al. 2001, eq. 5: 1 - sin(a/2) tan(a/2) ln cot(a/4). Four times too bright
// at half moon against Allen's measurements; here for comparison.
[[nodiscard]] double lommel_seeliger_phase_factor(double phase_angle_rad);

// As sun_illuminance_lux, for the moon. Without earthshine.
[[nodiscard]] glm::dvec3 moon_illuminance_lux(double geometric_altitude_rad, double angular_radius_rad,
                                              double distance_m, double phase_angle_rad, const AirColumn& air);

} // namespace alpenglow::sky
