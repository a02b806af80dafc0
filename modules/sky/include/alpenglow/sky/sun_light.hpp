// Sun and moon through the air: illuminance and colour of the direct light at the ground.
#pragma once

#include <alpenglow/sky/colour.hpp>

#include <glm/vec3.hpp>

namespace alpenglow::sky {

// The column of air over the observer, as far as direct light is concerned.
struct AirColumn {
    double turbidity = 2.5;     // clamped to 1 .. 20; sets the aerosol
    double ozone_atm_cm = 0.35; // clamped to 0 .. 2
    double water_cm = 2.0;      // precipitable water, clamped to 0 .. 20
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

// Fraction of a disc of `radius_rad` whose centre stands at `altitude_rad` that is above the horizon, 0 .. 1.
[[nodiscard]] double visible_disc_fraction(double altitude_rad, double radius_rad);

// Transmittance of a path of relative optical length m through Rayleigh, aerosol (Angstrom, alpha 1.3), ozone, mixed
// gases and water vapour (Preetham et al. 1999, appendix A.1, after Iqbal 1983), at the spectrum's wavelengths.
[[nodiscard]] Spectrum air_transmittance(const AirColumn& air, double m);

// Spectral irradiance of the sun outside the atmosphere, W m^-2 nm^-1, at 1 au: the shape of the table in Preetham et
// al. 1999, scaled to the solar illuminance constant.
[[nodiscard]] const Spectrum& sun_spectrum();

// The same for the full moon at mean distance: redder than the sun, a ramp from 70 % at 340 nm to 135 % at 740 nm
// (Jensen et al. 2001, section 4.2), scaled to full_moon_illuminance_lux.
[[nodiscard]] const Spectrum& moon_spectrum();

// Illuminance on a surface facing the sun, linear Rec.709 in lux, within the gamut. The visible part of the disc and
// the refraction are in it: it fades smoothly to 0 as the disc sets. Altitude is geometric; `distance_au` scales by its
// inverse square.
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
