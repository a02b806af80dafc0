// What anyone can check by looking up, and what almanacs print.
#include <alpenglow/ephemeris/celestial.hpp>
#include <alpenglow/ephemeris/course.hpp>
#include <alpenglow/ephemeris/frames.hpp>
#include <alpenglow/ephemeris/series.hpp>
#include <alpenglow/ephemeris/time.hpp>

#include <alpenglow/core/constants.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace alpenglow::ephemeris {
namespace {

Observer at(double latitude_deg, double longitude_deg, double height_m = 0.0) {
    return {latitude_deg * degree_rad, longitude_deg * degree_rad, height_m};
}

double utc_of(const char* text) {
    return *parse_time(text);
}

CelestialState state_at(const Observer& observer, double utc) {
    return evaluate(observer, utc, delta_t_s(utc));
}

Horizontal sun_at(const Observer& observer, double utc) {
    return horizontal_from_local(glm::dvec3(state_at(observer, utc).to_sun));
}

// Declination of the sun in the true equator of date.
double declination(double utc) {
    const glm::dvec3 sun = geocentric(julian_centuries(utc + delta_t_s(utc))).sun_m;
    return std::asin(sun.z / glm::length(sun));
}

// The instant within [begin, begin + 1 day) when the sun stands highest.
double noon(const Observer& observer, double begin) {
    double best = begin;
    for (double step = 600.0; step > 0.05; step /= 5.0) {
        const double from = step == 600.0 ? begin : best - 5.0 * step;
        const double to = step == 600.0 ? begin + day_s : best + 5.0 * step;
        double highest = -2.0;
        double where = best;
        for (double utc = from; utc < to; utc += step) {
            const double up = glm::normalize(topocentric(observer, utc, delta_t_s(utc)).sun_m).z;
            if (up > highest) {
                highest = up;
                where = utc;
            }
        }
        best = where;
    }
    return best;
}

TEST(Celestial, SunriseInTheEastSunsetInTheWest) {
    const Observer innsbruck = at(47.27, 11.39, 574.0);
    int rises = 0;
    int sets = 0;
    double before = sun_at(innsbruck, utc_of("2026-01-01")).altitude_rad;
    for (double utc = utc_of("2026-01-01"); utc < utc_of("2027-01-01"); utc += 300.0) {
        const Horizontal sun = sun_at(innsbruck, utc);
        if (before < 0.0 && sun.altitude_rad >= 0.0) {
            ++rises;
            EXPECT_GT(sun.azimuth_rad, 50.0 * degree_rad);
            EXPECT_LT(sun.azimuth_rad, 130.0 * degree_rad);
        } else if (before >= 0.0 && sun.altitude_rad < 0.0) {
            ++sets;
            EXPECT_GT(sun.azimuth_rad, 230.0 * degree_rad);
            EXPECT_LT(sun.azimuth_rad, 310.0 * degree_rad);
        }
        before = sun.altitude_rad;
    }
    EXPECT_EQ(rises, 365);
    EXPECT_EQ(sets, 365);
}

TEST(Celestial, NoonAltitudeIs90MinusLatitudePlusDeclination) {
    for (const double latitude : {-60.0, -23.44, 0.0, 10.0, 47.27, 65.0}) {
        for (const char* day : {"2026-01-15", "2026-03-20", "2026-06-21", "2026-09-10", "2026-12-21"}) {
            const Observer observer = at(latitude, 0.0);
            const double utc = noon(observer, utc_of(day));
            const double expected = 90.0 - std::abs(latitude - declination(utc) / degree_rad);
            // The sun's own parallax (8.8") and its motion in declination are all that is left.
            EXPECT_NEAR(sun_at(observer, utc).altitude_rad / degree_rad, expected, 0.005) << latitude << ' ' << day;
        }
    }
}

TEST(Celestial, SouthernHemisphereNoonSunInTheNorth) {
    const Observer sydney = at(-33.87, 151.21);
    const Horizontal sun = sun_at(sydney, noon(sydney, utc_of("2026-06-20T14:00")));
    EXPECT_NEAR(std::remainder(sun.azimuth_rad, two_pi), 0.0, 0.1 * degree_rad);
    EXPECT_NEAR(sun.altitude_rad / degree_rad, 90.0 - 33.87 - 23.44, 0.02);
    // It moves from right to left: east in the morning, west in the evening, through north.
    EXPECT_LT(sun_at(sydney, utc_of("2026-06-21T00:00")).azimuth_rad, 0.5 * pi);
    EXPECT_GT(sun_at(sydney, utc_of("2026-06-21T04:00")).azimuth_rad, 1.5 * pi);
}

TEST(Celestial, PolesTheSunCirclesAtItsDeclination) {
    for (const double pole : {90.0, -90.0}) {
        for (double hour = 0.0; hour < 24.0; hour += 1.0) {
            const double utc = utc_of("2026-06-21") + 3600.0 * hour;
            EXPECT_NEAR(sun_at(at(pole, 0.0), utc).altitude_rad, (pole > 0.0 ? 1.0 : -1.0) * declination(utc),
                        10.0 * arcsecond_rad);
        }
    }
}

TEST(Celestial, MidnightSunAndPolarNight) {
    const Observer tromso = at(69.65, 18.96);
    for (double hour = 0.0; hour < 24.0; hour += 0.25) {
        EXPECT_GT(sun_at(tromso, utc_of("2026-06-21") + 3600.0 * hour).altitude_rad, 0.0);
        EXPECT_LT(sun_at(tromso, utc_of("2026-12-21") + 3600.0 * hour).altitude_rad, 0.0);
    }
}

// Almanac instants to the minute: the sun gains 2.5" of longitude a minute.
TEST(Celestial, EquinoxesAndSolsticesOf2026) {
    const auto longitude = [](const char* text) {
        const double utc = utc_of(text);
        const double t = julian_centuries(utc + delta_t_s(utc));
        return sun_series(t).longitude_rad + nutation(t).longitude_rad;
    };
    const char* const instants[] = {"2026-03-20T14:46Z", "2026-06-21T08:24Z", "2026-09-23T00:05Z", "2026-12-21T20:50Z"};
    for (int season = 0; season < 4; ++season) {
        EXPECT_NEAR(std::remainder(longitude(instants[season]) - 0.5 * pi * season, two_pi) / arcsecond_rad, 0.0, 5.0)
            << instants[season];
    }
    EXPECT_NEAR(declination(utc_of("2026-03-20T14:46Z")), 0.0, 3.0 * arcsecond_rad);
}

// NASA's greatest eclipse: instant in UT and place on the central line, where sun and moon stand in line. The printed
// place is good to 0.1 arcminute and the instant to a second; the moon's shadow runs about 0.3" a second.
TEST(Celestial, TotalSolarEclipsesAreCentral) {
    struct Eclipse {
        const char* utc;
        double latitude_deg, longitude_deg;
    };
    for (const Eclipse& e : {Eclipse{"1999-08-11T11:03:05Z", 45.0 + 4.8 / 60.0, 24.0 + 17.3 / 60.0},
                             Eclipse{"2017-08-21T18:25:32Z", 36.0 + 58.0 / 60.0, -(87.0 + 40.3 / 60.0)},
                             Eclipse{"2024-04-08T18:17:18Z", 25.0 + 17.4 / 60.0, -(104.0 + 8.3 / 60.0)}}) {
        const double utc = utc_of(e.utc);
        const Topocentric t = topocentric(at(e.latitude_deg, e.longitude_deg), utc, delta_t_s(utc));
        EXPECT_LT(angle_between(t.sun_m, t.moon_m) / arcsecond_rad, 4.0) << e.utc;
        EXPECT_NEAR(state_at(at(e.latitude_deg, e.longitude_deg), utc).moon_illuminated_fraction, 0.0F, 1e-6F);
    }
}

// Total lunar eclipse of 2025-03-14, greatest at 06:58:43 UT: the moon is full, and opposite the sun.
TEST(Celestial, FullMoonOppositeTheSun) {
    const double utc = utc_of("2025-03-14T06:58:43Z");
    const Topocentric centre = topocentric(at(0.0, 0.0), utc, delta_t_s(utc));
    const glm::dvec3 here = observer_in_local_m(0.0, 0.0);
    EXPECT_GT(angle_between(centre.sun_m + here, centre.moon_m + here), pi - 0.5 * degree_rad);
    const Observer denver = at(39.74, -104.99, 1600.0);
    const CelestialState state = state_at(denver, utc);
    EXPECT_GT(state.moon_illuminated_fraction, 0.9995F);
    EXPECT_LT(state.moon_phase_angle_rad, static_cast<float>(2.0 * degree_rad));
    EXPECT_LT(glm::dot(state.to_sun, state.to_moon), -0.9995F);
    EXPECT_GT(state.to_moon.z, 0.0F);
    EXPECT_LT(state.to_sun.z, 0.0F);
}

// The half that is lit looks at the sun, and the fraction fits the angle between sun and moon in the sky.
TEST(Celestial, IlluminatedFractionGrowsWithElongation) {
    const Observer observer = at(47.27, 11.39);
    for (double utc = utc_of("2026-01-01"); utc < utc_of("2026-03-01"); utc += 3.1 * 3600.0) {
        const CelestialState s = state_at(observer, utc);
        const double elongation = angle_between(glm::dvec3(s.to_sun), glm::dvec3(s.to_moon));
        EXPECT_NEAR(s.moon_illuminated_fraction, 0.5 * (1.0 - std::cos(elongation)), 0.0015);
        EXPECT_NEAR(s.moon_phase_angle_rad, pi - elongation, 0.003);
    }
}

TEST(Celestial, MoonDistanceStaysWithinItsRange) {
    double nearest = 1e12;
    double farthest = 0.0;
    for (double utc = utc_of("1900-01-01"); utc < utc_of("2100-01-01"); utc += 7.3 * 3600.0) {
        const double d = moon_series(julian_centuries(utc)).distance_m;
        nearest = std::min(nearest, d);
        farthest = std::max(farthest, d);
    }
    // Meeus, chapter 50: extreme perigee 356 371 km (1912), extreme apogee 406 720 km (1984).
    EXPECT_NEAR(nearest, 356.4e6, 0.3e6);
    EXPECT_NEAR(farthest, 406.7e6, 0.1e6);
    EXPECT_GT(nearest, 356.35e6); // what the drift bound rests on
}

// Horizontal parallax: the moon on the horizon is lowered by up to 61.5', overhead it is nearer by an Earth's radius.
TEST(Celestial, MoonParallax) {
    double largest = 0.0;
    double nearer = 0.0;
    for (double utc = utc_of("2026-01-01"); utc < utc_of("2027-01-01"); utc += 1801.0) {
        const Observer observer = at(0.0, 0.0);
        const Topocentric t = topocentric(observer, utc, delta_t_s(utc));
        const glm::dvec3 geocentric_moon = t.moon_m + observer_in_local_m(0.0, 0.0);
        const double parallax = angle_between(t.moon_m, geocentric_moon);
        largest = std::max(largest, parallax);
        nearer = std::max(nearer, glm::length(geocentric_moon) - glm::length(t.moon_m));
        EXPECT_LE(horizontal_from_local(t.moon_m).altitude_rad, horizontal_from_local(geocentric_moon).altitude_rad);
    }
    EXPECT_GT(largest, 60.0 / 60.0 * degree_rad);
    EXPECT_LT(largest, 61.6 / 60.0 * degree_rad);
    EXPECT_NEAR(nearer, 6378137.0, 6000.0);
}

TEST(Celestial, MoonShowsUsOneFaceAndLibrates) {
    double longitude = 0.0;
    double latitude = 0.0;
    double course_longitude = 0.0;
    double course_latitude = 0.0;
    for (double utc = utc_of("2015-01-01"); utc < utc_of("2034-01-01"); utc += 9.7 * 3600.0) {
        const double t = julian_centuries(utc);
        const Geocentric g = geocentric(t);
        const glm::dvec3 earth = glm::normalize(glm::transpose(g.equatorial_from_moon) * -g.moon_m);
        longitude = std::max(longitude, std::abs(std::atan2(earth.y, earth.x)));
        latitude = std::max(latitude, std::abs(std::asin(earth.z)));
        const glm::dvec3 by_course =
            glm::normalize(glm::transpose(course::ecliptic_from_moon(t)) * -course::rectangular(course::moon(t)));
        course_longitude = std::max(course_longitude, std::abs(std::atan2(by_course.y, by_course.x)));
        course_latitude = std::max(course_latitude, std::abs(std::asin(by_course.z)));
    }
    // Largest optical librations: 7.9 and 6.9 degrees.
    EXPECT_NEAR(longitude / degree_rad, 7.9, 0.3);
    EXPECT_NEAR(latitude / degree_rad, 6.8, 0.2);
    EXPECT_NEAR(course_longitude / degree_rad, 7.9, 0.3);
    EXPECT_NEAR(course_latitude / degree_rad, 6.8, 0.2);
}

// The course's vector to the leading terminator: square to the sun's direction from the moon, in the plane of sun, moon
// and observer.
TEST(Celestial, TerminatorDirection) {
    for (double utc = utc_of("2026-01-01"); utc < utc_of("2026-03-01"); utc += 5.3 * 3600.0) {
        const double t = julian_centuries(utc);
        const course::HorizonPositions p = course::horizon_positions(t, t, 0.8, 0.2);
        const glm::dvec3 edge = glm::normalize(course::leading_terminator(p.sun, p.moon));
        const glm::dvec3 to_sun = glm::normalize(p.sun - p.moon);
        EXPECT_NEAR(glm::dot(edge, to_sun), 0.0, 1e-12);
        EXPECT_NEAR(glm::dot(edge, glm::normalize(glm::cross(p.sun, p.moon))), 0.0, 1e-12);
    }
}

TEST(Celestial, PolarisStandsNearTheNorthPole) {
    const glm::dvec3 polaris = from_spherical((2.0 + 31.0 / 60.0 + 49.1 / 3600.0) * 15.0 * degree_rad,
                                              (89.0 + 15.0 / 60.0 + 51.0 / 3600.0) * degree_rad);
    for (double hour = 0.0; hour < 24.0; hour += 1.0) {
        const CelestialState s = state_at(at(47.27, 11.39), utc_of("2026-06-21") + 3600.0 * hour);
        EXPECT_NEAR(horizontal_from_local(s.local_from_equatorial * polaris).altitude_rad / degree_rad, 47.27, 0.65);
    }
}

TEST(Celestial, DeltaTIsOverridable) {
    const double utc = utc_of("2026-06-21T05:30Z");
    EXPECT_EQ(delta_t_of({.utc_j2000_s = utc, .delta_t_s = 12.5}), 12.5);
    EXPECT_EQ(delta_t_of({.utc_j2000_s = utc}), delta_t_s(utc));
    // An hour more of TT moves the moon by half a degree, and the sun by 2.5 arcminutes.
    const Topocentric a = topocentric(at(0.0, 0.0), utc, 0.0);
    const Topocentric b = topocentric(at(0.0, 0.0), utc, 3600.0);
    EXPECT_NEAR(angle_between(a.moon_m, b.moon_m) / degree_rad, 0.55, 0.1);
    EXPECT_NEAR(angle_between(a.sun_m, b.sun_m) * 60.0 / degree_rad, 2.4, 0.1);
}

TEST(Celestial, RefusesInputsByName) {
    const WorldClock clock{.utc_j2000_s = 0.0};
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const auto message = [](const Observer& o, const WorldClock& c) {
        const Status s = check_inputs(o, c);
        EXPECT_EQ(s.has_value(), inputs_valid(o, c));
        return s ? std::string() : s.error().message();
    };
    EXPECT_EQ(message(at(47.0, 11.0), clock), "");
    EXPECT_EQ(message(at(90.0, -180.0), clock), "");
    EXPECT_EQ(message(at(91.0, 0.0), clock), "observer.latitude (degrees): is 91 (expected -90 to 90)");
    EXPECT_NE(message(at(nan, 0.0), clock).find("latitude"), std::string::npos);
    EXPECT_NE(message(at(0.0, 400.0), clock).find("longitude"), std::string::npos);
    EXPECT_NE(message(at(0.0, 0.0, 1e6), clock).find("height"), std::string::npos);
    EXPECT_NE(message(at(0.0, 0.0), {.utc_j2000_s = 1e12}).find("utc"), std::string::npos);
    EXPECT_NE(message(at(0.0, 0.0), {.utc_j2000_s = nan}).find("utc"), std::string::npos);
    EXPECT_NE(message(at(0.0, 0.0), {.delta_t_s = 1e9}).find("delta_t"), std::string::npos);
}

// The skip rule's promise, in double: perturb every input, evaluate in secret, and never be farther off than the bound.
TEST(Celestial, DriftBoundHoldsAndIsNotIdle) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    double tightest_in_time = 0.0;
    for (int i = 0; i < 40000; ++i) {
        const Observer from{std::asin(unit(random)), pi * unit(random), 44000.0 + 56000.0 * unit(random)};
        const double utc = 5.0 * century_s * unit(random);
        const double delta_t = delta_t_s(utc);
        const double size = std::pow(10.0, -6.0 + 2.0 * unit(random));
        Observer to = from;
        double utc_to = utc;
        double delta_t_to = delta_t;
        const int what = i % 5;
        if (what == 0 || what == 4) {
            utc_to += size * 1e5 * unit(random);
        }
        if (what == 1 || what == 4) {
            to.latitude_rad = std::clamp(to.latitude_rad + size * unit(random), -0.5 * pi, 0.5 * pi);
        }
        if (what == 2 || what == 4) {
            to.longitude_rad += size * unit(random);
        }
        if (what == 3 || what == 4) {
            delta_t_to += size * 1e6 * unit(random);
            to.height_m = std::clamp(to.height_m + size * 1e8 * unit(random), min_height_m, max_height_m);
        }
        const Topocentric a = topocentric(from, utc, delta_t);
        const Topocentric b = topocentric(to, utc_to, delta_t_to);
        CelestialState made;
        made.made_from_utc_j2000_s = utc;
        made.made_from_latitude_rad = from.latitude_rad;
        made.made_from_longitude_rad = from.longitude_rad;
        made.made_from_height_m = from.height_m;
        made.made_from_delta_t_s = delta_t;
        const double bound = direction_drift_bound_rad(made, to, utc_to, delta_t_to);
        double error = std::max(angle_between(a.sun_m, b.sun_m), angle_between(a.moon_m, b.moon_m));
        for (int axis = 0; axis < 3; ++axis) {
            error = std::max({error, angle_between(a.local_from_equatorial[axis], b.local_from_equatorial[axis]),
                              angle_between(a.local_from_moon[axis], b.local_from_moon[axis])});
        }
        ASSERT_LE(error, bound + 2e-11) << what << ' ' << size; // double's resolution of the instant
        if (what == 0 && bound > 1e-8) {
            tightest_in_time = std::max(tightest_in_time, error / bound);
        }
    }
    EXPECT_GT(tightest_in_time, 0.9);
}

TEST(Celestial, AStateNeverMadeHasNoBound) {
    EXPECT_TRUE(std::isinf(direction_drift_bound_rad(CelestialState{}, Observer{}, 0.0, 0.0)));
}

} // namespace
} // namespace alpenglow::ephemeris
