// The charts over the picture: what they show is where and what they say, and nothing is done while none is shown.
#include "sandbox/app/sky_charts.hpp"

#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <random>
#include <span>
#include <string_view>

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sky/horizon_filter.hpp>
#include <alpenglow/sky/sky_state.hpp>

#include "sandbox/app/game.hpp"
#include "sandbox/app/sky_chart.hpp"
#include "sandbox/world/landscape_file.hpp"

namespace alpenglow::sandbox {
namespace {

TEST(Canvas, FillsHalfOpenRectanglesAndDropsWhatLiesOutside) {
    Canvas canvas(10, 6, glm::vec3(0.0F), 0.5F);
    canvas.fill(-3, -3, 2, 2, glm::vec3(1.0F));
    canvas.fill(8, 4, 20, 20, glm::vec3(1.0F));
    for (int y = 0; y < 6; ++y) {
        for (int x = 0; x < 10; ++x) {
            const bool filled = (x < 2 && y < 2) || (x >= 8 && y >= 4);
            EXPECT_EQ(canvas.at(x, y).r, filled ? 1.0F : 0.0F);
            const auto alpha = canvas.rgba()[static_cast<std::size_t>(4 * (10 * y + x) + 3)];
            EXPECT_EQ(std::to_integer<int>(alpha), filled ? 255 : 128);
        }
    }
}

TEST(Canvas, TextStaysWithinItsWidth) {
    const std::string text = "lux 1e-4";
    const int width = Canvas::text_width(text);
    ASSERT_GT(width, 20);
    Canvas canvas(width + 20, 20, glm::vec3(0.0F), 1.0F);
    canvas.text(10, 5, text, glm::vec3(1.0F));
    int inside = 0;
    for (int y = 0; y < 20; ++y) {
        for (int x = 0; x < width + 20; ++x) {
            if (canvas.at(x, y).r > 0.5F) {
                EXPECT_TRUE(x >= 10 && x < 10 + width && y >= 5) << x << ' ' << y;
                ++inside;
            }
        }
    }
    EXPECT_GT(inside, 50);
}

TEST(SkyChart, PlacesAndDirectionsAreInverse) {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> unit(-0.7F, 0.7F);
    for (int i = 0; i < 200; ++i) {
        const glm::vec2 place(unit(random), unit(random));
        const glm::vec3 direction = chart_direction(place);
        EXPECT_NEAR(glm::length(direction), 1.0F, 1e-6F);
        EXPECT_NEAR(glm::distance(chart_place(direction), place), 0.0F, 1e-5F);
    }
    EXPECT_EQ(chart_direction(glm::vec2(0.0F)), glm::vec3(0.0F, 0.0F, 1.0F));
    EXPECT_GT(chart_direction({0.0F, 0.5F}).y, 0.0F); // north up
    EXPECT_LT(chart_direction({0.5F, 0.0F}).x, 0.0F); // west right, as seen lying on the back
}

// An overcast sky, which a few bands hold but for its edge.
struct Overcast {
    SkyState sky;
    SkyLightSh light;

    explicit Overcast(int bands) {
        CelestialState bodies;
        bodies.to_sun = glm::normalize(glm::vec3(0.3F, -0.5F, 0.6F));
        Atmosphere air;
        air.model = SkyModel::cie_overcast;
        sky = sky::make_sky_state(bodies, air);
        light.bands = bands;
        sky::project_sky_state(sky, nullptr, bands, light.coefficients);
    }
};

TEST(SkyChart, MoreBandsAndTheFilterDoWhatTheyAreFor) {
    float error = 2.0F; // over the whole sphere it can only fall: bands are orthogonal
    for (int bands = 1; bands <= 7; ++bands) {
        const Overcast overcast(bands);
        const auto count = static_cast<std::size_t>(bands * bands);
        const ShQuality raw = sh_quality(overcast.sky, nullptr, bands, overcast.light.coefficients);
        EXPECT_LE(std::hypot(raw.blur, raw.ringing), error * 1.001F) << bands;
        error = std::hypot(raw.blur, raw.ringing);
        std::array<glm::vec3, 49> filtered = overcast.light.coefficients;
        sky::HorizonFilter(bands, 1.4).apply(std::span<glm::vec3>(filtered).first(count));
        const ShQuality after = sh_quality(overcast.sky, nullptr, bands, filtered);
        EXPECT_LT(after.ringing, raw.ringing) << bands;
    }
    EXPECT_LT(error, 0.2F);
}

// The disc of differences has the colour of the difference.
TEST(SkyChart, DifferencesHaveTheirColour) {
    constexpr int bands = 3;
    Overcast overcast(bands);
    const Canvas canvas = paint_sky_chart(overcast.sky, nullptr, overcast.light, bands, ChartFilter::sinc, 1e-4F, 640);
    constexpr int diameter = (640 - 5 * 10) / 4;
    const int x = 10 + 3 * (diameter + 10) + diameter / 2; // the middle: the zenith
    const int y = 16 + diameter / 2;
    std::array<glm::vec3, 9> filtered{};
    std::copy_n(overcast.light.coefficients.begin(), 9, filtered.begin());
    sky::filter_zonal_sinc(bands, std::span<glm::vec3>(filtered));
    constexpr std::array<float, 3> zonal{0.28209479F, 0.48860251F, 0.63078313F}; // Y_l^0 at the zenith
    const float there = filtered[0].g * zonal[0] + filtered[2].g * zonal[1] + filtered[6].g * zonal[2];
    const std::array<glm::vec3, 1> zenith{glm::vec3(0.0F, 0.0F, 1.0F)};
    std::array<glm::vec3, 1> dome{};
    sky::sky_radiance(overcast.sky, nullptr, zenith, dome);
    // (1 + 2 sin h) / 3 squared over the hemisphere: mean of (1 + 2 z)^2 / 9 for z in 0 .. 1 is 13 / 27.
    const float rms = dome[0].g * std::sqrt(13.0F / 27.0F);
    const glm::vec3 expected = signed_colour((there - dome[0].g) / (0.5F * rms));
    for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(canvas.at(x, y)[k], expected[k], 0.03F);
    }
    EXPECT_EQ(signed_colour(0.0F).r, signed_colour(0.0F).b);
    EXPECT_GT(signed_colour(1.0F).r, signed_colour(1.0F).b);
    EXPECT_GT(signed_colour(-1.0F).b, signed_colour(-1.0F).r);
}

Observer innsbruck() {
    return {.latitude_rad = 47.27 * degree_rad, .longitude_rad = 11.39 * degree_rad, .height_m = 600.0};
}

TEST(DayChart, TheDayRunsFromLocalMidnightAndIsBrightestAtNoon) {
    for (const SkyModel model : {SkyModel::preetham, SkyModel::scattering}) {
        Atmosphere air;
        air.model = model;
        const std::vector<DaySample> day = day_light(innsbruck(), air, 8.35e8, 97);
        ASSERT_EQ(day.size(), 97U);
        EXPECT_NEAR(day.back().utc_j2000_s - day.front().utc_j2000_s, 86400.0, 1e-3);
        EXPECT_LE(day.front().utc_j2000_s, 8.35e8);
        EXPECT_GE(day.back().utc_j2000_s, 8.35e8);
        std::size_t brightest = 0;
        for (std::size_t i = 0; i < day.size(); ++i) {
            brightest = day[i].sun_lux > day[brightest].sun_lux ? i : brightest;
            EXPECT_GT(day[i].sky_lux, 1e-4F); // the night's floor
            if (day[i].sun_altitude_rad < -0.02F) {
                EXPECT_EQ(day[i].sun_lux, 0.0F);
            }
        }
        EXPECT_NEAR(static_cast<double>(brightest), 48.0, 1.0); // the equation of time: 16 minutes at most
    }
}

TEST(DayChart, CurvesPassThroughTheirSamples) {
    const std::vector<DaySample> day = day_light(innsbruck(), Atmosphere{}, 8.35e8, 97);
    const Canvas canvas = paint_day_chart(day, day[30].utc_j2000_s, 700, 280);
    const DayAxes axes(700, 280);
    for (std::size_t i = 40; i <= 56; i += 4) { // around noon: the sun's curve is painted last
        const auto x = static_cast<int>(axes.x(static_cast<double>(i) / 96.0));
        const auto y = static_cast<int>(axes.y(day[i].sun_lux));
        EXPECT_GT(canvas.at(x, y).r, 0.9F);
        EXPECT_LT(canvas.at(x, y).b, 0.5F);
    }
    const auto now = static_cast<int>(axes.x(30.0 / 96.0));
    EXPECT_GT(canvas.at(now, axes.bottom - 40).r, 0.9F); // the mark
    EXPECT_LT(canvas.at(now + 4, axes.bottom - 40).r, 0.5F);
}

TEST(DayChart, WithoutAnEphemerisThereIsNoDay) {
    Observer nowhere = innsbruck();
    nowhere.latitude_rad = std::numeric_limits<double>::quiet_NaN();
    EXPECT_TRUE(day_light(nowhere, Atmosphere{}, 8.35e8, 97).empty());
    EXPECT_EQ(paint_day_chart({}, 8.35e8, 400, 200).width(), 400);
}

class ChartGameTest : public ::testing::Test {
protected:
    static void SetUpTestSuite() {
        const std::filesystem::path file = built_landscape();
        game_ = new Game(scene(), open_world(std::span(&file, 1)).world);
    }
    static void TearDownTestSuite() {
        delete game_;
        game_ = nullptr;
    }
    static Scene scene() {
        Scene scene = *load_scene("alpine-morning");
        scene.time_rate = 0.0;
        return scene;
    }
    // How often the chart was painted in the last update; -1: nothing was done for it.
    static int painted() {
        for (const SystemReport& report : game_->reports()) {
            if (std::string_view(report.system) == "chart") {
                return static_cast<int>(report.updated);
            }
        }
        return -1;
    }
    static std::uint32_t updated(std::string_view system) {
        for (const SystemReport& report : game_->reports()) {
            if (system == report.system) {
                return report.updated;
            }
        }
        return 0;
    }
    static inline Game* game_ = nullptr;
};

TEST_F(ChartGameTest, NothingIsDoneWhileNoneIsShown) {
    game_->enter(scene());
    SkyCharts* charts = game_->part<SkyCharts>();
    ASSERT_NE(charts, nullptr);
    game_->update(0.0, 960, 540);
    EXPECT_EQ(painted(), -1);
    EXPECT_EQ(game_->frame().overlay, nullptr);

    EXPECT_FALSE(charts->press('Q'));
    EXPECT_TRUE(charts->press('V'));
    game_->update(1.0 / 60.0, 960, 540);
    EXPECT_EQ(painted(), 1);
    EXPECT_EQ(updated("sky_light"), 1U); // five bands are asked for now
    ASSERT_NE(game_->frame().overlay, nullptr);
    EXPECT_GE(game_->frame().overlay->left, 0);
    EXPECT_EQ(game_->frame().overlay->top + game_->frame().overlay->height, 540);
    const std::uint32_t revision = game_->frame().overlay->revision;
    game_->update(1.0 / 60.0, 960, 540);
    EXPECT_EQ(painted(), 0); // as it was
    EXPECT_EQ(game_->frame().overlay->revision, revision);

    charts->settings.bands = 7;
    game_->update(1.0 / 60.0, 960, 540);
    EXPECT_EQ(painted(), 1);
    EXPECT_TRUE(charts->press('V'));
    game_->update(1.0 / 60.0, 960, 540);
    EXPECT_EQ(painted(), 1); // the day
    game_->update(1.0 / 60.0, 960, 540);
    EXPECT_EQ(painted(), 0);
    EXPECT_TRUE(charts->press('V'));
    game_->update(1.0 / 60.0, 960, 540);
    EXPECT_EQ(painted(), -1);
    EXPECT_EQ(game_->frame().overlay, nullptr);
}

TEST_F(ChartGameTest, EveryModelHasItsChart) {
    for (int model = 0; model <= static_cast<int>(SkyModel::scattering); ++model) {
        Scene one = scene();
        one.atmosphere.model = static_cast<SkyModel>(model);
        one.chart = {.show = Chart::sky, .bands = 1 + model};
        game_->enter(one);
        game_->update(0.0, 960, 540);
        EXPECT_EQ(painted(), 1);
        ASSERT_NE(game_->frame().overlay, nullptr);
        // The dome's disc is lit.
        const OverlayRenderData& overlay = *game_->frame().overlay;
        const std::size_t middle = 4 * static_cast<std::size_t>((16 + 112) * overlay.width + 10 + 112);
        EXPECT_GT(std::to_integer<int>(overlay.rgba[middle + 2]), 60) << model;
    }
}

} // namespace
} // namespace alpenglow::sandbox
