// Time at a thousand times its rate under the scattering sky: tables are rebuilt as the error needs, the light of the
// scene goes without jumps, and what is drawn is the sky as it would be made anew.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include <alpenglow/sky/sky_state.hpp>

#include "one_game.hpp"
#include "sandbox/render/sky_dome.hpp"

namespace alpenglow::sandbox {
namespace {

double luminance(const glm::vec3& rgb) {
    return static_cast<double>(glm::dot(rgb, glm::vec3(0.2126F, 0.7152F, 0.0722F)));
}

double sun_altitude_deg(const Game& game) {
    const glm::vec3& to_sun = game.celestial().to_sun;
    return static_cast<double>(std::atan2(to_sun.z, std::hypot(to_sun.x, to_sun.y))) * 180.0 / 3.14159265358979;
}

// The dome's worst relative error against tables made anew, by the norm of the colour.
double dome_error(const Game& game, SkyTables& anew) {
    anew.sun_view = anew.moon_view = nullptr;
    SkyState state = sky::make_sky_state(game.celestial(), game.sky().air, static_cast<double>(game.sky().height_m));
    sky::update_sky_tables(state, game.celestial(), {.sky_view = true}, anew);
    std::vector<glm::vec3> directions;
    std::vector<glm::vec3> drawn;
    for (std::size_t i = 0; i < SkyDome::vertices_above; i += 41) {
        directions.push_back(game.frame().sky_vertices[i].direction);
        drawn.push_back(game.frame().sky_vertices[i].radiance_cd_m2);
    }
    std::vector<glm::vec3> truth(directions.size());
    sky::sky_radiance(state, &anew, directions, truth);
    double worst = 0.0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        worst = std::max(worst, static_cast<double>(glm::distance(drawn[i], truth[i]) / glm::length(truth[i])));
    }
    return worst;
}

class DayTest : public OneGame {
protected:
};

TEST_F(DayTest, AnEveningAtAThousandTimesItsRateHasNoJumps) {
    Scene evening = *load_scene("alpine-morning");
    ASSERT_EQ(evening.atmosphere.model, SkyModel::scattering);
    evening.utc_j2000_s += 13.9 * 3600.0; // 19:24 UTC: the sun has just set
    evening.time_rate = 1000.0;
    game_->enter(evening);
    game_->update(0.0, 320, 180);
    // Zenith, horizon, irradiance from above, and what the camera makes of the ground's light.
    std::vector<std::array<double, 4>> logs;
    std::uint32_t rebuilt = 0;
    double worst = 0.0;
    double lowest = 90.0;
    SkyTables anew;
    constexpr int frames = 300;
    for (int frame = 0; frame < frames; ++frame) {
        game_->update(1.0 / 60.0, 320, 180);
        const FrameData& drawn = game_->frame();
        const double zenith = luminance(drawn.sky_vertices[SkyDome::vertices_above - 1].radiance_cd_m2);
        const glm::vec3 level(drawn.irradiance_matrix[0][3][3] + drawn.irradiance_matrix[0][2][2],
                              drawn.irradiance_matrix[1][3][3] + drawn.irradiance_matrix[1][2][2],
                              drawn.irradiance_matrix[2][3][3] + drawn.irradiance_matrix[2][2][2]);
        logs.push_back({std::log(zenith), std::log(luminance(drawn.air_radiance_cd_m2)), std::log(luminance(level)),
                        std::log(luminance(level) * static_cast<double>(drawn.exposure))});
        for (const SystemReport& report : game_->reports()) {
            rebuilt += std::string_view(report.system) == "sky" ? report.tables_rebuilt : 0U;
        }
        lowest = std::min(lowest, sun_altitude_deg(*game_));
        if (frame % 16 == 0) {
            worst = std::max(worst, dome_error(*game_, anew));
        }
    }
    EXPECT_LT(lowest, -9.0);
    double step = 0.0;
    double jump = 0.0; // of a step against its neighbours
    for (std::size_t k = 0; k < logs[0].size(); ++k) {
        for (std::size_t i = 1; i + 2 < logs.size(); ++i) {
            const double here = logs[i + 1][k] - logs[i][k];
            const double around = 0.5 * (logs[i][k] - logs[i - 1][k] + logs[i + 2][k] - logs[i + 1][k]);
            step = std::max(step, std::abs(here));
            jump = std::max(jump, std::abs(here - around));
        }
    }
    std::printf("evening at 1000x, %d frames: %u tables rebuilt, worst error of the dome %.4f, largest step %.3f, "
                "jump %.3f (natural logarithm)\n",
                frames, rebuilt, worst, step, jump);
    // The sun sinks 0.07 degrees a frame; twilight falls by a factor of ten in 2 degrees at its steepest.
    EXPECT_LT(step, 0.10);
    EXPECT_LT(jump, 0.03); // an eye tells 2 % apart at best, side by side
    EXPECT_LE(worst, 2.0 * static_cast<double>(game_->atmosphere().max_error));
    EXPECT_LE(rebuilt, 2U * frames + 2U); // a view for the sun and one for the moon at most
    EXPECT_GT(rebuilt, frames / 4U);
}

// A day of 24 hours in steps of a quarter of an hour: light at all times, and no number that is none.
TEST_F(DayTest, ADayRoundTheClockStaysFinite) {
    Scene day = *load_scene("alpine-morning");
    day.time_rate = 900.0;
    game_->enter(day);
    game_->update(0.0, 320, 180);
    double brightest = 0.0;
    double darkest = 1e9;
    for (int step = 0; step < 96; ++step) {
        game_->update(1.0, 320, 180);
        for (const SkyVertex& vertex : game_->frame().sky_vertices) {
            const double l = luminance(vertex.radiance_cd_m2);
            ASSERT_TRUE(l > 0.0 && l < 1e6) << step;
            brightest = std::max(brightest, l);
            darkest = std::min(darkest, l);
        }
        ASSERT_TRUE(game_->frame().exposure > 0.0F && game_->frame().exposure < 1e5F);
    }
    EXPECT_GT(brightest, 1e4);
    EXPECT_LT(darkest, 1e-2);
}

} // namespace
} // namespace alpenglow::sandbox
