// Atmospheric refraction, apart from the geometric positions: whoever draws the sun decides whether to lift it.
#pragma once

namespace alpenglow::ephemeris {

// What must be added to the geometric altitude to get the apparent one, in radians (Saemundsson 1986, Meeus eq. 16.4,
// divided by its value at the zenith so that R(90 deg) = 0; within 0.1 arcminute of full integrations above 0 deg at
// 1010 hPa and 10 C). Altitudes are clamped to -pi/2 .. pi/2. Below -1 degree, where the formula means nothing, R falls
// linearly to 0 at the nadir, so that the lifted altitude is continuous and strictly increasing everywhere.
[[nodiscard]] double refraction_from_true_rad(double altitude_rad, double pressure_hpa = 1010.0,
                                              double temperature_c = 10.0);

// What must be subtracted from the apparent altitude to get the geometric one, in radians (Bennett 1982, Meeus
// eq. 16.3, made 0 at the zenith as above). Consistent with refraction_from_true_rad to 0.1 arcminute above 0 degrees.
[[nodiscard]] double refraction_from_apparent_rad(double altitude_rad, double pressure_hpa = 1010.0,
                                                  double temperature_c = 10.0);

} // namespace alpenglow::ephemeris
