#include <alpenglow/ephemeris/series.hpp>

#include <alpenglow/core/constants.hpp>
#include <alpenglow/ephemeris/frames.hpp>

#include "harmonics.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace alpenglow::ephemeris {
namespace {

// amplitude cos(phase + frequency tau), tau in Julian millennia.
struct VsopTerm {
    double amplitude;
    double phase;
    double frequency;
};

// Heliocentric longitude of the Earth, 1e-8 rad.
constexpr std::array<VsopTerm, 63> earth_l0{{{3341656.0, 4.6692568, 6283.0758500},
                                             {34894.0, 4.62610, 12566.15170},
                                             {3497.0, 2.7441, 5753.3849},
                                             {3418.0, 2.8289, 3.5231},
                                             {3136.0, 3.6277, 77713.7715},
                                             {2676.0, 4.4181, 7860.4194},
                                             {2343.0, 6.1352, 3930.2097},
                                             {1324.0, 0.7425, 11506.7698},
                                             {1273.0, 2.0371, 529.6910},
                                             {1199.0, 1.1096, 1577.3435},
                                             {990.0, 5.233, 5884.927},
                                             {902.0, 2.045, 26.298},
                                             {857.0, 3.508, 398.149},
                                             {780.0, 1.179, 5223.694},
                                             {753.0, 2.533, 5507.553},
                                             {505.0, 4.583, 18849.228},
                                             {492.0, 4.205, 775.523},
                                             {357.0, 2.920, 0.067},
                                             {317.0, 5.849, 11790.629},
                                             {284.0, 1.899, 796.298},
                                             {271.0, 0.315, 10977.079},
                                             {243.0, 0.345, 5486.778},
                                             {206.0, 4.806, 2544.314},
                                             {205.0, 1.869, 5573.143},
                                             {202.0, 2.458, 6069.777},
                                             {156.0, 0.833, 213.299},
                                             {132.0, 3.411, 2942.463},
                                             {126.0, 1.083, 20.775},
                                             {115.0, 0.645, 0.980},
                                             {103.0, 0.636, 4694.003},
                                             {102.0, 0.976, 15720.839},
                                             {102.0, 4.267, 7.114},
                                             {99.0, 6.21, 2146.17},
                                             {98.0, 0.68, 155.42},
                                             {86.0, 5.98, 161000.69},
                                             {85.0, 1.30, 6275.96},
                                             {85.0, 3.67, 71430.70},
                                             {80.0, 1.81, 17260.15},
                                             {79.0, 3.04, 12036.46},
                                             {75.0, 1.76, 5088.63},
                                             {74.0, 3.50, 3154.69},
                                             {74.0, 4.68, 801.82},
                                             {70.0, 0.83, 9437.76},
                                             {62.0, 3.98, 8827.39},
                                             {61.0, 1.82, 7084.90},
                                             {57.0, 2.78, 6286.60},
                                             {56.0, 4.39, 14143.50},
                                             {56.0, 3.47, 6279.55},
                                             {52.0, 0.19, 12139.55},
                                             {52.0, 1.33, 1748.02},
                                             {51.0, 0.28, 5856.48},
                                             {49.0, 0.49, 1194.45},
                                             {41.0, 5.37, 8429.24},
                                             {41.0, 2.40, 19651.05},
                                             {39.0, 6.17, 10447.39},
                                             {37.0, 6.04, 10213.29},
                                             {37.0, 2.57, 1059.38},
                                             {36.0, 1.71, 2352.87},
                                             {36.0, 1.78, 6812.77},
                                             {33.0, 0.59, 17789.85},
                                             {30.0, 0.44, 83996.85},
                                             {30.0, 2.74, 1349.87},
                                             {25.0, 3.16, 4690.48}}};
constexpr std::array<VsopTerm, 8> earth_l1{{{206059.0, 2.678235, 6283.075850},
                                            {4303.0, 2.6351, 12566.1517},
                                            {425.0, 1.590, 3.523},
                                            {119.0, 5.796, 26.298},
                                            {109.0, 2.966, 1577.344},
                                            {93.0, 2.59, 18849.23},
                                            {72.0, 1.14, 529.69},
                                            {68.0, 1.87, 398.15}}};
constexpr std::array<VsopTerm, 2> earth_l2{{{8720.0, 1.0721, 6283.0758}, {309.0, 0.867, 12566.152}}};
// Radius vector, 1e-8 au.
constexpr std::array<VsopTerm, 7> earth_r0{{{1670700.0, 3.0984635, 6283.0758500},
                                            {13956.0, 3.05525, 12566.15170},
                                            {3084.0, 5.1985, 77713.7715},
                                            {1628.0, 1.1739, 5753.3849},
                                            {1576.0, 2.8469, 7860.4194},
                                            {925.0, 5.453, 11506.770},
                                            {542.0, 4.564, 3930.210}}};
constexpr std::array<VsopTerm, 2> earth_r1{{{103019.0, 1.107490, 6283.075850}, {1721.0, 1.0644, 12566.1517}}};
// Heliocentric latitude, 1e-8 rad.
constexpr std::array<VsopTerm, 5> earth_b0{{{280.0, 3.199, 84334.662},
                                            {102.0, 5.422, 5507.553},
                                            {80.0, 3.88, 5223.69},
                                            {44.0, 3.70, 2352.87},
                                            {32.0, 4.00, 1577.34}}};

template <std::size_t N>
double sum(const std::array<VsopTerm, N>& terms, double tau) {
    double total = 0.0;
    for (const VsopTerm& term : terms) {
        total += term.amplitude * std::cos(term.phase + term.frequency * tau);
    }
    return total;
}

// The moon's mean arguments, radians (Meeus, eqs. 47.1 to 47.5; L' holds the light-time).
struct LunarArguments {
    double l;
    double d;
    double m;
    double m_moon;
    double f;
};

LunarArguments lunar_arguments(double t) {
    const auto reduced = [](double degrees) { return degree_rad * std::fmod(degrees, 360.0); };
    return {reduced(218.3164477 + t * (481267.88123421 + t * (-0.0015786 + t * (1.0 / 538841.0 - t / 65194000.0)))),
            reduced(297.8501921 + t * (445267.1114034 + t * (-0.0018819 + t * (1.0 / 545868.0 - t / 113065000.0)))),
            reduced(357.5291092 + t * (35999.0502909 + t * (-0.0001536 + t / 24490000.0))),
            reduced(134.9633964 + t * (477198.8675055 + t * (0.0087414 + t * (1.0 / 69699.0 - t / 14712000.0)))),
            reduced(93.2720950 + t * (483202.0175233 + t * (-0.0036539 + t * (-1.0 / 3526000.0 + t / 863310000.0))))};
}

// Multiples of D, M, M' and F; 1e-6 degrees of longitude (sine) and 1e-3 km of distance (cosine). Meeus, table 47.A.
struct LongitudeTerm {
    std::int8_t d, m, m_moon, f;
    double longitude, distance;
};
constexpr std::array<LongitudeTerm, 60> moon_lr{{{0, 0, 1, 0, 6288774, -20905355},
                                                 {2, 0, -1, 0, 1274027, -3699111},
                                                 {2, 0, 0, 0, 658314, -2955968},
                                                 {0, 0, 2, 0, 213618, -569925},
                                                 {0, 1, 0, 0, -185116, 48888},
                                                 {0, 0, 0, 2, -114332, -3149},
                                                 {2, 0, -2, 0, 58793, 246158},
                                                 {2, -1, -1, 0, 57066, -152138},
                                                 {2, 0, 1, 0, 53322, -170733},
                                                 {2, -1, 0, 0, 45758, -204586},
                                                 {0, 1, -1, 0, -40923, -129620},
                                                 {1, 0, 0, 0, -34720, 108743},
                                                 {0, 1, 1, 0, -30383, 104755},
                                                 {2, 0, 0, -2, 15327, 10321},
                                                 {0, 0, 1, 2, -12528, 0},
                                                 {0, 0, 1, -2, 10980, 79661},
                                                 {4, 0, -1, 0, 10675, -34782},
                                                 {0, 0, 3, 0, 10034, -23210},
                                                 {4, 0, -2, 0, 8548, -21636},
                                                 {2, 1, -1, 0, -7888, 24208},
                                                 {2, 1, 0, 0, -6766, 30824},
                                                 {1, 0, -1, 0, -5163, -8379},
                                                 {1, 1, 0, 0, 4987, -16675},
                                                 {2, -1, 1, 0, 4036, -12831},
                                                 {2, 0, 2, 0, 3994, -10445},
                                                 {4, 0, 0, 0, 3861, -11650},
                                                 {2, 0, -3, 0, 3665, 14403},
                                                 {0, 1, -2, 0, -2689, -7003},
                                                 {2, 0, -1, 2, -2602, 0},
                                                 {2, -1, -2, 0, 2390, 10056},
                                                 {1, 0, 1, 0, -2348, 6322},
                                                 {2, -2, 0, 0, 2236, -9884},
                                                 {0, 1, 2, 0, -2120, 5751},
                                                 {0, 2, 0, 0, -2069, 0},
                                                 {2, -2, -1, 0, 2048, -4950},
                                                 {2, 0, 1, -2, -1773, 4130},
                                                 {2, 0, 0, 2, -1595, 0},
                                                 {4, -1, -1, 0, 1215, -3958},
                                                 {0, 0, 2, 2, -1110, 0},
                                                 {3, 0, -1, 0, -892, 3258},
                                                 {2, 1, 1, 0, -810, 2616},
                                                 {4, -1, -2, 0, 759, -1897},
                                                 {0, 2, -1, 0, -713, -2117},
                                                 {2, 2, -1, 0, -700, 2354},
                                                 {2, 1, -2, 0, 691, 0},
                                                 {2, -1, 0, -2, 596, 0},
                                                 {4, 0, 1, 0, 549, -1423},
                                                 {0, 0, 4, 0, 537, -1117},
                                                 {4, -1, 0, 0, 520, -1571},
                                                 {1, 0, -2, 0, -487, -1739},
                                                 {2, 1, 0, -2, -399, 0},
                                                 {0, 0, 2, -2, -381, -4421},
                                                 {1, 1, 1, 0, 351, 0},
                                                 {3, 0, -2, 0, -340, 0},
                                                 {4, 0, -3, 0, 330, 0},
                                                 {2, -1, 2, 0, 327, 0},
                                                 {0, 2, 1, 0, -323, 1165},
                                                 {1, 1, -1, 0, 299, 0},
                                                 {2, 0, 3, 0, 294, 0},
                                                 {2, 0, -1, -2, 0, 8752}}};
// 1e-6 degrees of latitude (sine). Meeus, table 47.B.
struct LatitudeTerm {
    std::int8_t d, m, m_moon, f;
    double latitude;
};
constexpr std::array<LatitudeTerm, 60> moon_b{
    {{0, 0, 0, 1, 5128122}, {0, 0, 1, 1, 280602},  {0, 0, 1, -1, 277693}, {2, 0, 0, -1, 173237}, {2, 0, -1, 1, 55413},
     {2, 0, -1, -1, 46271}, {2, 0, 0, 1, 32573},   {0, 0, 2, 1, 17198},   {2, 0, 1, -1, 9266},   {0, 0, 2, -1, 8822},
     {2, -1, 0, -1, 8216},  {2, 0, -2, -1, 4324},  {2, 0, 1, 1, 4200},    {2, 1, 0, -1, -3359},  {2, -1, -1, 1, 2463},
     {2, -1, 0, 1, 2211},   {2, -1, -1, -1, 2065}, {0, 1, -1, -1, -1870}, {4, 0, -1, -1, 1828},  {0, 1, 0, 1, -1794},
     {0, 0, 0, 3, -1749},   {0, 1, -1, 1, -1565},  {1, 0, 0, 1, -1491},   {0, 1, 1, 1, -1475},   {0, 1, 1, -1, -1410},
     {0, 1, 0, -1, -1344},  {1, 0, 0, -1, -1335},  {0, 0, 3, 1, 1107},    {4, 0, 0, -1, 1021},   {4, 0, -1, 1, 833},
     {0, 0, 1, -3, 777},    {4, 0, -2, 1, 671},    {2, 0, 0, -3, 607},    {2, 0, 2, -1, 596},    {2, -1, 1, -1, 491},
     {2, 0, -2, 1, -451},   {0, 0, 3, -1, 439},    {2, 0, 2, 1, 422},     {2, 0, -3, -1, 421},   {2, 1, -1, 1, -366},
     {2, 1, 0, 1, -351},    {4, 0, 0, 1, 331},     {2, -1, 1, 1, 315},    {2, -2, 0, -1, 302},   {0, 0, 1, 3, -283},
     {2, 1, 1, -1, -229},   {1, 1, 0, -1, 223},    {1, 1, 0, 1, 223},     {0, 1, -2, -1, -220},  {2, 1, -1, -1, -220},
     {1, 0, 1, 1, -185},    {2, -1, -2, -1, 181},  {0, 1, 2, 1, -177},    {4, 0, -2, -1, 176},   {4, -1, -1, -1, 166},
     {1, 0, 1, -1, -164},   {4, 0, 1, -1, 132},    {1, 0, -1, -1, -119},  {4, -1, 0, -1, 115},   {2, -2, 0, 1, 107}}};

} // namespace

EclipticPosition sun_series(double t) {
    const double tau = t / 10.0;
    const double l =
        1.75347045673 + 1e-8 * sum(earth_l0, tau) +
        tau * (6283.31966747 + 1e-8 * sum(earth_l1, tau) +
               tau * (1e-8 * (52919.0 + sum(earth_l2, tau)) + tau * 1e-8 * 289.0 * std::cos(5.844 + 6283.076 * tau)));
    const double r =
        1.00013989 +
        1e-8 * (sum(earth_r0, tau) + tau * (sum(earth_r1, tau) + tau * 4359.0 * std::cos(5.7846 + 6283.0758 * tau)));
    const double b = 1e-8 * sum(earth_b0, tau);
    // Seen from the Earth; aberration (Meeus, eq. 25.10) moves the sun back along its path.
    return {l + pi - 20.4898 * arcsecond_rad / r, -b, r * astronomical_unit_m};
}

EclipticPosition moon_series(double t) {
    const LunarArguments a = lunar_arguments(t);
    const LunarHarmonics harmonics{Harmonics<6>(a.d), Harmonics<6>(a.m), Harmonics<6>(a.m_moon), Harmonics<6>(a.f)};
    // Terms with the sun's anomaly shrink with the eccentricity of the Earth's orbit (Meeus, eq. 47.6).
    const double e = 1.0 + t * (-0.002516 + t * -0.0000074);
    const std::array<double, 3> eccentricity{1.0, e, e * e};
    double longitude = 0.0;
    double distance = 0.0;
    for (const LongitudeTerm& term : moon_lr) {
        const SineCosine sc = harmonics(term);
        const double factor = eccentricity[static_cast<std::size_t>(term.m < 0 ? -term.m : term.m)];
        longitude += factor * term.longitude * sc.sine;
        distance += factor * term.distance * sc.cosine;
    }
    double latitude = 0.0;
    for (const LatitudeTerm& term : moon_b) {
        const double factor = eccentricity[static_cast<std::size_t>(term.m < 0 ? -term.m : term.m)];
        latitude += factor * term.latitude * harmonics(term).sine;
    }
    // Venus, Jupiter and the flattening of the Earth.
    const double a1 = degree_rad * (119.75 + 131.849 * t);
    const double a2 = degree_rad * (53.09 + 479264.290 * t);
    const double a3 = degree_rad * (313.45 + 481266.484 * t);
    longitude += 3958.0 * std::sin(a1) + 1962.0 * std::sin(a.l - a.f) + 318.0 * std::sin(a2);
    latitude += -2235.0 * std::sin(a.l) + 382.0 * std::sin(a3) + 350.0 * std::sin(a1) * std::cos(a.f) +
                127.0 * std::sin(a.l - a.m_moon) - 115.0 * std::sin(a.l + a.m_moon);
    return {a.l + 1e-6 * degree_rad * longitude, 1e-6 * degree_rad * latitude, 385000560.0 + distance};
}

Geocentric geocentric(double t) {
    const Nutation n = nutation(t);
    const double mean_obliquity = mean_obliquity_rad(t);
    const double obliquity = mean_obliquity + n.obliquity_rad;
    const glm::dmat3 equatorial_from_ecliptic = rotation_x(obliquity) * rotation_z(n.longitude_rad);
    const auto position = [&](const EclipticPosition& p) {
        return equatorial_from_ecliptic * (p.distance_m * from_spherical(p.longitude_rad, p.latitude_rad));
    };
    const LunarArguments a = lunar_arguments(t);
    constexpr double inclination = 1.54242 * degree_rad;
    Geocentric g;
    g.sun_m = position(sun_series(t));
    g.equatorial_from_moon =
        equatorial_from_ecliptic * rotation_z(a.l - a.f) * rotation_x(-inclination) * rotation_z(a.f + pi);
    g.true_from_j2000 = equatorial_from_ecliptic * rotation_x(-mean_obliquity) * date_from_j2000(t);
    g.moon_m = g.true_from_j2000 * moon_elp_m(t);
    const double node = degree_rad * (125.04455501 - 1934.1362619 * t);
    g.equation_of_equinoxes_rad = n.longitude_rad * std::cos(obliquity) + arcsecond_rad * 0.00264 * std::sin(node);
    return g;
}

} // namespace alpenglow::ephemeris
