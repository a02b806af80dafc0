#include <alpenglow/systems/ephemeris.hpp>

#include <alpenglow/core/constants.hpp>
#include <alpenglow/ephemeris/frames.hpp>
#include <alpenglow/ephemeris/time.hpp>

#include "registries.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace alpenglow {
namespace {

template <class R>
class EphemerisSystem : public ::testing::Test {
protected:
    R registry;
    Frame frame;

    auto add(Observer observer = {.latitude_rad = 0.825, .longitude_rad = 0.199, .height_m = 574.0},
             WorldClock clock = {.utc_j2000_s = 835291800.0}) {
        const auto e = registry.create();
        registry.template emplace<WorldClock>(e, clock);
        registry.template emplace<Observer>(e, observer);
        registry.template emplace<CelestialState>(e);
        return e;
    }
};
TYPED_TEST_SUITE(EphemerisSystem, test::TestRegistries, test::RegistryNames);

TYPED_TEST(EphemerisSystem, FirstUpdateWritesWhatTheModuleSays) {
    const auto e = this->add();
    const SystemReport report = update_ephemeris(this->registry, this->frame);
    EXPECT_STREQ(report.system, "ephemeris");
    EXPECT_EQ(report.considered, 1U);
    EXPECT_EQ(report.updated, 1U);
    EXPECT_EQ(report.skipped, 0U);
    const auto& state = this->registry.template get<CelestialState>(e);
    const CelestialState expected =
        ephemeris::evaluate(this->registry.template get<Observer>(e), 835291800.0, ephemeris::delta_t_s(835291800.0));
    EXPECT_LT(glm::distance(state.to_sun, expected.to_sun), 2e-7F);
    EXPECT_LT(glm::distance(state.to_moon, expected.to_moon), 2e-7F);
    EXPECT_EQ(state.revision, 1U);
}

TYPED_TEST(EphemerisSystem, StaticClockDoesNoWork) {
    const auto e = this->add();
    update_ephemeris(this->registry, this->frame);
    for (int i = 0; i < 100; ++i) {
        const SystemReport report = update_ephemeris(this->registry, this->frame);
        ASSERT_EQ(report.updated, 0U);
        ASSERT_EQ(report.skipped, 1U);
        ASSERT_EQ(report.error_bound, 0.0);
    }
    EXPECT_EQ(this->registry.template get<CelestialState>(e).revision, 1U);
}

TYPED_TEST(EphemerisSystem, NobodyAsksNothingIsDone) {
    const auto e = this->registry.create();
    this->registry.template emplace<WorldClock>(e);
    this->registry.template emplace<Observer>(e);
    EXPECT_EQ(update_ephemeris(this->registry, this->frame).considered, 0U);
}

// Real time at 1x and 60 frames a second: a state holds for 1e-5 / 7.7e-5 s = 0.13 s, eight frames.
TYPED_TEST(EphemerisSystem, RealTimeRecomputesEveryEighthFrame) {
    const auto e = this->add();
    unsigned updated = 0;
    for (int i = 0; i < 600; ++i) {
        updated += update_ephemeris(this->registry, this->frame).updated;
        this->registry.template get<WorldClock>(e).utc_j2000_s += 1.0 / 60.0;
    }
    EXPECT_GE(updated, 60U);
    EXPECT_LE(updated, 80U);
}

// Sweep the inputs, recompute in secret: the true error never exceeds the reported bound, nor that the observer's
// limit.
TYPED_TEST(EphemerisSystem, TrueErrorNeverExceedsTheBound) {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    constexpr double rounding = 4e-7; // two directions, each rounded to float
    for (const double limit : {0.0, 1e-5, 1e-3, 0.05}) {
        const auto e = this->add();
        this->registry.template get<Observer>(e).max_error_rad = limit;
        unsigned skipped = 0;
        for (int i = 0; i < 2000; ++i) {
            auto& clock = this->registry.template get<WorldClock>(e);
            auto& observer = this->registry.template get<Observer>(e);
            const double size = std::max(limit, 1e-6) * 0.3;
            clock.utc_j2000_s += size * 1.4e4 * unit(random);
            observer.latitude_rad = std::clamp(observer.latitude_rad + size * unit(random), -0.5 * pi, 0.5 * pi);
            observer.longitude_rad = std::remainder(observer.longitude_rad + size * unit(random), two_pi);
            observer.height_m = std::clamp(observer.height_m + 100.0 * unit(random), 0.0, 9000.0);
            const SystemReport report = update_ephemeris(this->registry, this->frame);
            skipped += report.skipped;
            const auto& state = this->registry.template get<CelestialState>(e);
            const CelestialState now = ephemeris::evaluate(observer, clock.utc_j2000_s, ephemeris::delta_t_of(clock));
            double error = std::max(ephemeris::angle_between(glm::dvec3(state.to_sun), glm::dvec3(now.to_sun)),
                                    ephemeris::angle_between(glm::dvec3(state.to_moon), glm::dvec3(now.to_moon)));
            for (int axis = 0; axis < 3; ++axis) {
                error = std::max(
                    {error,
                     ephemeris::angle_between(state.local_from_equatorial[axis], now.local_from_equatorial[axis]),
                     ephemeris::angle_between(state.local_from_moon[axis], now.local_from_moon[axis])});
            }
            ASSERT_LE(error, report.error_bound + rounding);
            ASSERT_LE(report.error_bound, limit);
        }
        EXPECT_EQ(skipped > 0, limit > 0.0) << limit;
        this->registry.destroy(e);
    }
}

TYPED_TEST(EphemerisSystem, BadInputsKeepTheLastValidState) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double infinity = std::numeric_limits<double>::infinity();
    const auto e = this->add();
    update_ephemeris(this->registry, this->frame);
    const CelestialState good = this->registry.template get<CelestialState>(e);
    const Observer observer = this->registry.template get<Observer>(e);
    const WorldClock clock = this->registry.template get<WorldClock>(e);
    const auto refused = [&](const Observer& bad_observer, const WorldClock& bad_clock) {
        this->registry.template get<Observer>(e) = bad_observer;
        this->registry.template get<WorldClock>(e) = bad_clock;
        const SystemReport report = update_ephemeris(this->registry, this->frame);
        const auto& state = this->registry.template get<CelestialState>(e);
        EXPECT_EQ(report.updated, 0U);
        EXPECT_EQ(report.skipped, 1U);
        EXPECT_EQ(state.revision, good.revision);
        EXPECT_EQ(state.to_sun, good.to_sun);
    };
    for (const double bad : {nan, infinity, -infinity, 1e300}) {
        refused({bad, observer.longitude_rad, observer.height_m}, clock);
        refused({observer.latitude_rad, bad, observer.height_m}, clock);
        refused({observer.latitude_rad, observer.longitude_rad, bad}, clock);
        refused(observer, {.utc_j2000_s = bad});
    }
    refused(observer, {.utc_j2000_s = clock.utc_j2000_s, .delta_t_s = infinity});
    // Back to valid inputs: the state follows again.
    this->registry.template get<Observer>(e) = observer;
    this->registry.template get<WorldClock>(e) = {.utc_j2000_s = clock.utc_j2000_s + 3600.0};
    EXPECT_EQ(update_ephemeris(this->registry, this->frame).updated, 1U);
}

TYPED_TEST(EphemerisSystem, ALimitThatIsNaNOrNegativeMeansAnyChange) {
    for (const double limit : {std::numeric_limits<double>::quiet_NaN(), -1.0, 0.0}) {
        const auto e = this->add();
        this->registry.template get<Observer>(e).max_error_rad = limit;
        EXPECT_EQ(update_ephemeris(this->registry, this->frame).updated, 1U);
        EXPECT_EQ(update_ephemeris(this->registry, this->frame).updated, 0U);
        this->registry.template get<WorldClock>(e).utc_j2000_s += 1e-3;
        EXPECT_EQ(update_ephemeris(this->registry, this->frame).updated, 1U);
        this->registry.destroy(e);
    }
}

TYPED_TEST(EphemerisSystem, EachEntityHasItsOwnClockAndPlace) {
    for (int i = 0; i < 50; ++i) {
        this->add({.latitude_rad = 0.02 * i}, {.utc_j2000_s = 1e6 * i});
    }
    EXPECT_EQ(update_ephemeris(this->registry, this->frame).updated, 50U);
    const auto moved = this->add();
    EXPECT_EQ(update_ephemeris(this->registry, this->frame).updated, 1U);
    this->registry.template get<Observer>(moved).latitude_rad += 1e-3;
    const SystemReport report = update_ephemeris(this->registry, this->frame);
    EXPECT_EQ(report.updated, 1U);
    EXPECT_EQ(report.skipped, 50U);
}

} // namespace
} // namespace alpenglow
