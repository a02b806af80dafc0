// Sun and moon: the course's series, the truncated theories that update_ephemeris uses, and ERFA.
#include "bench.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/ephemeris/celestial.hpp>
#include <alpenglow/ephemeris/course.hpp>
#include <alpenglow/ephemeris/frames.hpp>
#include <alpenglow/ephemeris/geocentric_cache.hpp>
#include <alpenglow/ephemeris/series.hpp>
#include <alpenglow/ephemeris/time.hpp>

#ifdef ALPENGLOW_HAVE_ERFA
#include "erfa_reference.hpp"
#include "moon_reference.hpp"
#endif

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>

namespace alpenglow::bench {
namespace {

using namespace alpenglow::ephemeris;

constexpr double no_reference = std::numeric_limits<double>::quiet_NaN();

Row row_of(std::string name, std::string method) {
    Row row;
    row.module = "ephemeris";
    row.name = std::move(name);
    row.method = std::move(method);
    return row;
}

// Instants over 1900 to 2100, out of step with the periods of sun and moon.
std::vector<double> instants(bool quick) {
    std::vector<double> utc(quick ? 401 : 6007);
    for (std::size_t i = 0; i < utc.size(); ++i) {
        utc[i] = century_s * (-1.0 + 2.0 * (static_cast<double>(i) + 0.37) / static_cast<double>(utc.size()));
    }
    return utc;
}

// Cycles through instants, so that no call repeats the last one.
class Clock {
public:
    explicit Clock(const std::vector<double>& utc) : utc_(utc) {}
    double next() {
        i_ = i_ + 1 < utc_.size() ? i_ + 1 : 0;
        return utc_[i_];
    }

private:
    const std::vector<double>& utc_;
    std::size_t i_ = 0;
};

using Direction = std::function<glm::dvec3(double)>;

std::vector<glm::dvec3> evaluate_all(const std::vector<double>& utc, const Direction& direction) {
    std::vector<glm::dvec3> all;
    all.reserve(utc.size());
    for (const double s : utc) {
        all.push_back(direction(s));
    }
    return all;
}

double worst_arcseconds(const std::vector<glm::dvec3>& a, const std::vector<glm::dvec3>& b) {
    double worst = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        worst = std::max(worst, angle_between(a[i], b[i]));
    }
    return worst / arcsecond_rad;
}

struct Method {
    std::string name;
    Direction direction; // to the body; the argument is TT (geocentric cases) or UTC (local ones), seconds since J2000
    double bytes;
};

// One case: all methods at `tt` against `reference` (none where the build found no ERFA).
void run_case(const Context& context, const std::string& name, const std::vector<Method>& methods,
              const std::vector<double>& tt, const std::vector<glm::dvec3>& reference,
              const std::string& reference_name) {
    for (const Method& method : methods) {
        Row row = row_of(name, method.name);
        row.error_metric = "max arcseconds, " + std::to_string(tt.size()) + " instants 1900 to 2100";
        row.reference = reference.empty() ? "none: built without ERFA" : reference_name;
        row.bytes = method.bytes;
        row.error = reference.empty() ? no_reference : worst_arcseconds(evaluate_all(tt, method.direction), reference);
        Clock clock(tt);
        context.run(row, [&] { keep(method.direction(clock.next())); });
    }
}

#ifdef ALPENGLOW_HAVE_ERFA
// The whole of ELP/MPP02 at the instants of the samples, in the true equator of date (ERFA's precession and nutation).
struct MoonReference {
    std::vector<double> tt;
    std::vector<glm::dvec3> moon_m;
};
MoonReference moon_reference() {
    MoonReference r;
    for (const test::MoonSample& sample : test::moon_samples) {
        const test::SeenMoon seen = test::seen(sample);
        r.tt.push_back(seen.tt_j2000_s);
        r.moon_m.push_back(test::erfa_true_from_gcrs(seen.tt_j2000_s) * seen.position_m);
    }
    return r;
}
#endif

const Case geocentric_sun("ephemeris/sun, geocentric", [](const Context& context) {
    std::vector<Method> methods{{"course series",
                                 [](double tt) {
                                     const double t = julian_centuries(tt);
                                     return rotation_x(course::obliquity(t)) * course::rectangular(course::sun(t));
                                 },
                                 0.0},
                                {"truncated VSOP87",
                                 [](double tt) {
                                     const double t = julian_centuries(tt);
                                     const EclipticPosition p = sun_series(t);
                                     const Nutation n = nutation(t);
                                     return rotation_x(mean_obliquity_rad(t) + n.obliquity_rad) *
                                            from_spherical(p.longitude_rad + n.longitude_rad, p.latitude_rad);
                                 },
                                 2088.0}};
#ifdef ALPENGLOW_HAVE_ERFA
    methods.push_back(
        {"ERFA (reference)", [](double tt) { return test::erfa_true_from_gcrs(tt) * test::erfa_sun_gcrs_m(tt); }, 0.0});
#endif
    const std::vector<double> tt = instants(context.quick());
    std::vector<glm::dvec3> reference;
#ifdef ALPENGLOW_HAVE_ERFA
    reference = evaluate_all(tt, methods.back().direction);
#endif
    run_case(context, "sun, geocentric apparent", methods, tt, reference, "ERFA 2.0: eraEpv00, IAU 2006/2000A");
});

const Case geocentric_moon("ephemeris/moon, geocentric", [](const Context& context) {
    std::vector<Method> methods{{"course series",
                                 [](double tt) {
                                     const double t = julian_centuries(tt);
                                     return rotation_x(course::obliquity(t)) * course::rectangular(course::moon(t));
                                 },
                                 0.0},
                                {"ELP/MPP02, 483 terms",
                                 [](double tt) {
                                     const double t = julian_centuries(tt);
                                     const Nutation n = nutation(t);
                                     const double obliquity = mean_obliquity_rad(t);
                                     return rotation_x(obliquity + n.obliquity_rad) * rotation_z(n.longitude_rad) *
                                            rotation_x(-obliquity) * date_from_j2000(t) * moon_elp_m(t);
                                 },
                                 8752.0},
                                {"ELP 2000-82, Meeus ch. 47",
                                 [](double tt) {
                                     const double t = julian_centuries(tt);
                                     const EclipticPosition p = moon_series(t);
                                     const Nutation n = nutation(t);
                                     return rotation_x(mean_obliquity_rad(t) + n.obliquity_rad) *
                                            from_spherical(p.longitude_rad + n.longitude_rad, p.latitude_rad);
                                 },
                                 2400.0}};
#ifdef ALPENGLOW_HAVE_ERFA
    methods.push_back(
        {"ERFA, eraMoon98", [](double tt) { return test::erfa_true_from_gcrs(tt) * test::erfa_moon_gcrs_m(tt); }, 0.0});
#endif
    std::vector<double> tt = instants(context.quick());
    std::vector<glm::dvec3> reference;
#ifdef ALPENGLOW_HAVE_ERFA
    const MoonReference whole = moon_reference();
    tt = whole.tt;
    reference = whole.moon_m;
#endif
    run_case(context, "moon, geocentric apparent", methods, tt, reference, "ELP/MPP02, all terms, fitted to DE405");
});

// Direction and rotation of everything geocentric, for a clock at 1000x and 60 frames a second: a span serves 1296
// frames.
const Case cubic("ephemeris/cubic cache", [](const Context& context) {
    const std::vector<double> tt = instants(context.quick());
    std::vector<glm::dvec3> series;
    std::vector<glm::dvec3> cached;
    GeocentricCache cache;
    for (const double s : tt) {
        series.push_back(geocentric(julian_centuries(s)).moon_m);
        cached.push_back(cache.at(s).moon_m);
    }
    const std::string name = "sun, moon, lunar axes, precession, nutation; geocentric";
    double clock = 0.0;
    Row row = row_of(name, "cubic cache, 1000x clock");
    row.error = worst_arcseconds(cached, series);
    row.error_metric = "max arcseconds of the moon, 1900 to 2100";
    row.reference = "the series";
    row.bytes = sizeof(GeocentricCache);
    context.run(row, [&] { keep(cache.at(clock += 1000.0 / 60.0)); });
    row = row_of(name, "VSOP87 and ELP/MPP02, truncated");
    row.error_metric = "max arcseconds of the moon, 1900 to 2100";
    row.reference = "the series";
    context.run(row, [&] { keep(geocentric(julian_centuries(clock += 1000.0 / 60.0))); });
});

// The larger error of sun and moon over the local horizon, with everything that the component holds or the course
// computes.
const Case local("ephemeris/sun and moon, local", [](const Context& context) {
    const Observer observer{47.27 * degree_rad, 11.39 * degree_rad, 574.0};
    using Both = std::array<glm::dvec3, 2>;
    struct LocalMethod {
        std::string name;
        std::function<Both(double)> directions;
    };
    std::vector<LocalMethod> methods{{"course series",
                                      [observer](double utc) {
                                          const course::HorizonPositions p = course::horizon_positions(
                                              julian_centuries(utc + delta_t_s(utc)), julian_centuries(utc),
                                              observer.latitude_rad, observer.longitude_rad);
                                          const glm::dmat3 to_local = course::local_from_horizon();
                                          return Both{to_local * p.sun, to_local * p.moon};
                                      }},
                                     {"evaluate (whole CelestialState)", [observer](double utc) {
                                          const CelestialState s = evaluate(observer, utc, delta_t_s(utc));
                                          return Both{glm::dvec3(s.to_sun), glm::dvec3(s.to_moon)};
                                      }}};
    GeocentricCache cache;
    methods.push_back({"evaluate, cubic cache", [observer, &cache](double utc) {
                           const double delta_t = delta_t_s(utc);
                           const CelestialState s = evaluate(observer, utc, delta_t, cache.at(utc + delta_t));
                           return Both{glm::dvec3(s.to_sun), glm::dvec3(s.to_moon)};
                       }});
#ifdef ALPENGLOW_HAVE_ERFA
    methods.push_back({"ERFA", [observer](double utc) {
                           const test::ErfaTopocentric e = test::erfa_topocentric(
                               utc, delta_t_s(utc), observer.latitude_rad, observer.longitude_rad, observer.height_m);
                           return Both{e.sun_m, e.moon_m};
                       }});
#endif
#ifdef ALPENGLOW_HAVE_ERFA
    std::vector<double> utc;
    std::vector<glm::dvec3> suns;
    std::vector<glm::dvec3> moons;
    const MoonReference whole = moon_reference();
    for (std::size_t i = 0; i < whole.tt.size(); ++i) {
        // UTC whose delta T leads to this TT; delta T changes by less than 1e-5 s meanwhile.
        const double delta_t = delta_t_s(whole.tt[i] - delta_t_s(whole.tt[i]));
        utc.push_back(whole.tt[i] - delta_t);
        const test::ErfaTopocentric e =
            test::erfa_topocentric(utc[i], delta_t, observer.latitude_rad, observer.longitude_rad, observer.height_m);
        suns.push_back(e.sun_m);
        moons.push_back(test::erfa_local_from_true(utc[i], whole.tt[i], observer.latitude_rad, observer.longitude_rad) *
                            whole.moon_m[i] -
                        test::erfa_observer_local_m(observer.latitude_rad, observer.longitude_rad, observer.height_m));
    }
#endif
    for (const LocalMethod& method : methods) {
        Row row = row_of("sun and moon, topocentric, local axes", method.name);
        row.error_metric = "max arcseconds of sun and moon, 300 instants 1900 to 2100";
        row.reference = "ERFA 2.0 with the moon of ELP/MPP02, all terms";
        row.error = no_reference;
#ifdef ALPENGLOW_HAVE_ERFA
        row.error =
            std::max(worst_arcseconds(evaluate_all(utc, [&](double s) { return method.directions(s)[0]; }), suns),
                     worst_arcseconds(evaluate_all(utc, [&](double s) { return method.directions(s)[1]; }), moons));
#endif
        // Frames of a clock at 1000x and 60 frames a second.
        double clock = 0.0;
        context.run(row, [&] { keep(method.directions(clock += 1000.0 / 60.0)); });
    }
});

// What a frame pays when the skip rule finds that the state still holds.
const Case skip("ephemeris/skip test", [](const Context& context) {
    const Observer observer{47.27 * degree_rad, 11.39 * degree_rad, 574.0};
    const CelestialState state = evaluate(observer, 8.35e8, delta_t_s(8.35e8));
    Row row = row_of("sun and moon, topocentric, local axes", "skipped: drift bound");
    row.error = observer.max_error_rad / arcsecond_rad;
    row.error_metric = "arcseconds allowed by the default max_error_rad";
    row.reference = "its own last evaluation";
    double offset = 0.0;
    context.run(row, [&] {
        offset = offset < 0.1 ? offset + 1e-3 : 0.0;
        const double utc = 8.35e8 + offset;
        const WorldClock clock{.utc_j2000_s = utc};
        keep(inputs_valid(observer, clock) &&
             direction_drift_bound_rad(state, observer, utc, delta_t_of(clock)) <= observer.max_error_rad);
    });
});

} // namespace
} // namespace alpenglow::bench
