// Scene `probes`: the courtyard, its grid, what is lit by it and how it is shown.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <string_view>
#include <tuple>
#include <vector>

#include <glm/geometric.hpp>

#include <alpenglow/probes/grid.hpp>
#include <alpenglow/sh/irradiance.hpp>
#include <alpenglow/sh/zonal.hpp>

#include "one_game.hpp"
#include "sandbox/app/probe_display.hpp"
#include "sandbox/app/probe_scene.hpp"
#include "sandbox/world/probe_render_data.hpp"

namespace alpenglow::sandbox {
namespace {

constexpr double frame_s = 1.0 / 60.0;

// One landscape for all tests.
class ProbeSceneTest : public OneGame {
protected:
    static void enter(Deringing deringing, double time_rate = 0.0) {
        Scene scene = *load_scene("probes");
        scene.time_rate = time_rate;
        scene.probes->deringing = deringing;
        game_->enter(scene);
    }
    static void update(int frames) {
        for (int i = 0; i < frames; ++i) {
            game_->update(frame_s, 960, 540);
        }
    }
    // The lowest luminance that any ball shows, relative to the mean of that ball.
    static float darkest() {
        float least = 1.0F;
        for (const LitSphere& sphere : game_->frame().probes->spheres) {
            const auto luminance = [](const glm::vec3& c) { return 0.2126F * c.r + 0.7152F * c.g + 0.0722F * c.b; };
            const float mean = 0.28209479F * luminance(sphere.radiance[0]);
            for (int i = 0; i < 2000; ++i) {
                const glm::vec3 normal = lattice_direction(i, 2000);
                const glm::vec3 shown = sh::evaluate(3, std::span<const glm::vec3>(sphere.radiance), normal);
                least = std::min(least, luminance(shown) / mean);
            }
        }
        return least;
    }
};

TEST_F(ProbeSceneTest, OtherScenesHaveNoProbesAndDoNoWorkForThem) {
    enter(Deringing::exact);
    update(2);
    ASSERT_NE(report("probes"), nullptr);
    game_->enter(*load_scene("noon"));
    update(2);
    EXPECT_EQ(game_->reports().size(), 6U);
    EXPECT_EQ(report("probes"), nullptr);
    EXPECT_EQ(report("probe_receivers"), nullptr);
    EXPECT_EQ(game_->part<ProbeScene>(), nullptr);
    EXPECT_EQ(game_->frame().probes, nullptr);
}

TEST_F(ProbeSceneTest, ProbesConvergeAndRest) {
    enter(Deringing::exact);
    update(1);
    EXPECT_GT(report("probes")->updated, 50U);
    EXPECT_EQ(report("probes")->rejected, 0U);
    const std::uint32_t made = game_->part<ProbeScene>()->numbers().probes;
    EXPECT_GT(made, 50U);
    for (int frame = 0; frame < 3; ++frame) { // time stands still, and so do the balls
        update(1);
        for (const SystemReport& r : game_->reports()) {
            EXPECT_EQ(r.updated, 0U) << r.system;
        }
        EXPECT_LE(report("probes")->error_bound, static_cast<double>(game_->part<ProbeScene>()->grid().max_error));
    }
    EXPECT_EQ(game_->part<ProbeScene>()->numbers().probes, made);
}

TEST_F(ProbeSceneTest, BallsGlideAndOnlyTheyAreWorkedOn) {
    enter(Deringing::exact, 1.0);
    update(2);
    const auto balls = static_cast<std::uint32_t>(game_->frame().probes->spheres.size());
    const glm::vec3 before = game_->frame().probes->spheres[2].centre_m;
    for (int frame = 0; frame < 10; ++frame) {
        update(1);
        EXPECT_EQ(report("probes")->updated, 0U);
        EXPECT_EQ(report("probe_receivers")->updated, balls);
    }
    EXPECT_GT(glm::distance(game_->frame().probes->spheres[2].centre_m, before), 0.05F);
}

TEST_F(ProbeSceneTest, LightIsNegativeWithoutDeringingAndNotWithExact) {
    enter(Deringing::none);
    update(2);
    const ProbeNumbers none = game_->part<ProbeScene>()->numbers();
    EXPECT_LT(none.least_irradiance, -0.05F);
    EXPECT_LT(darkest(), -0.02F);
    EXPECT_EQ(none.least_window, 1.0F);
    EXPECT_EQ(none.direct_window, 1.0F);
    EXPECT_NEAR(none.contrast, 1.0F, 1e-5F);
    EXPECT_NEAR(none.least_contrast, 1.0F, 1e-4F);

    // As the panel does it: in place.
    game_->part<ProbeScene>()->settings.deringing = Deringing::exact;
    update(2);
    const ProbeNumbers exact = game_->part<ProbeScene>()->numbers();
    EXPECT_EQ(exact.probes, none.probes);
    EXPECT_GE(exact.least_irradiance, -1e-6F);
    EXPECT_GE(darkest(), -1e-6F);
    EXPECT_LT(exact.direct_window, 1.0F);
    EXPECT_LT(exact.contrast, 1.0F);
    EXPECT_GT(exact.least_contrast, 0.0F);

    game_->part<ProbeScene>()->settings.deringing = Deringing::paper;
    update(2);
    const ProbeNumbers paper = game_->part<ProbeScene>()->numbers();
    EXPECT_GT(paper.least_irradiance, none.least_irradiance);
    EXPECT_LT(paper.least_irradiance, exact.least_irradiance); // under the roof its table does not reach far enough
    EXPECT_LT(paper.contrast, exact.contrast);                 // and costs more
}

TEST_F(ProbeSceneTest, BallsAreNowhereNegativeOnTheirWay) {
    enter(Deringing::exact, 1.0);
    for (int i = 0; i < 20; ++i) {
        game_->update(1.0, 960, 540);
        EXPECT_GE(darkest(), -1e-6F) << "after " << i << " s";
    }
}

TEST_F(ProbeSceneTest, OutOfViewNothingIsLitOrDrawn) {
    enter(Deringing::exact, 1.0);
    game_->camera.turn(3.0F, 0.0F);
    game_->camera.position_m.y -= 30.0F;
    update(2);
    EXPECT_EQ(game_->frame().probes, nullptr);
    for (const char* system : {"probes", "probe_receivers", "probe_yard"}) {
        EXPECT_EQ(report(system)->updated, 0U) << system;
    }
}

TEST_F(ProbeSceneTest, HiddenProbesAreNotUpdatedForTheirOwnSake) {
    enter(Deringing::exact);
    update(2);
    const std::uint32_t shown = game_->part<ProbeScene>()->numbers().probes;
    const std::size_t vertices = game_->frame().probes->display.vertices.size();
    Scene scene = *load_scene("probes");
    scene.probes->show = false;
    game_->enter(scene);
    update(2);
    EXPECT_LT(game_->part<ProbeScene>()->numbers().probes, shown);
    EXPECT_LT(game_->frame().probes->display.vertices.size(), vertices);
}

TEST_F(ProbeSceneTest, CapturedProbesTakeTheirPicturesAFewAFrameAndRest) {
    std::uint32_t faces = 0;
    game_->capture_with([&](const FrameData& frame, const glm::vec3&, int, std::span<glm::vec3> texels) {
        ++faces;
        EXPECT_NE(frame.probes, nullptr); // the yard is part of the picture
        std::fill(texels.begin(), texels.end(), glm::vec3(300.0F, 200.0F, 100.0F));
    });
    Scene scene = *load_scene("probes");
    scene.time_rate = 0.0;
    scene.probes->source = ProbeSource::captured;
    game_->enter(scene);
    update(1);
    EXPECT_EQ(faces, 12U); // two probes a frame
    update(150);           // every probe in use has had its turn
    const std::uint32_t converged = faces;
    EXPECT_GT(converged, 6U * 50U);
    update(3);
    EXPECT_EQ(faces, converged);
    // In the shade of the roof, a uniform surrounding is all that there is.
    const ProbeGrid& grid = game_->part<ProbeScene>()->grid();
    const ProbeGridSh& light = game_->part<ProbeScene>()->grid_light();
    int shaded = 0;
    for (std::size_t p = 0; p < grid.valid.size(); ++p) {
        if (light.made_pass[p] != 0 && grid.valid[p] != 0 && grid.sun_visibility[p] == 0.0F &&
            grid.moon_visibility[p] == 0.0F) {
            const glm::vec3 mean = 0.28209479F * probes::coefficient(light, p, 0);
            EXPECT_NEAR(mean.r, 300.0F, 0.1F);
            EXPECT_NEAR(mean.b, 100.0F, 0.1F);
            EXPECT_NEAR(probes::coefficient(light, p, 2).g, 0.0F, 0.1F);
            ++shaded;
        }
    }
    EXPECT_GT(shaded, 5);
    game_->capture_with({});
}

TEST_F(ProbeSceneTest, TheSameTwiceWithNewRevisions) {
    const auto run = [] {
        enter(Deringing::exact, 1.0);
        update(5);
        const ProbeRenderData* data = game_->frame().probes;
        return std::tuple(std::vector<ColorVertex>(data->yard.vertices.begin(), data->yard.vertices.end()),
                          std::vector<LitSphere>(data->spheres.begin(), data->spheres.end()), data->yard.revision,
                          data->spheres_revision);
    };
    const auto [vertices, spheres, mesh_revision, spheres_revision] = run();
    const auto [vertices_2, spheres_2, mesh_revision_2, spheres_revision_2] = run();
    ASSERT_EQ(vertices.size(), vertices_2.size());
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        ASSERT_EQ(vertices[i].position_m, vertices_2[i].position_m);
        ASSERT_EQ(vertices[i].light, vertices_2[i].light);
    }
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        EXPECT_EQ(spheres[i].centre_m, spheres_2[i].centre_m);
        EXPECT_EQ(spheres[i].radiance, spheres_2[i].radiance);
    }
    EXPECT_GT(mesh_revision_2, mesh_revision); // whoever draws both scenes must see a change
    EXPECT_GT(spheres_revision_2, spheres_revision);
}

TEST_F(ProbeSceneTest, YardHidesWhatStandsBehindItsWalls) {
    const Yard yard(game_->world());
    const glm::vec3 up(0.0F, 0.0F, 1.0F);
    const glm::vec3 middle = yard.middle_m();
    EXPECT_FALSE(yard.hides(middle + glm::vec3(0.0F, -1.0F, 1.0F), up));
    EXPECT_TRUE(yard.hides(middle + glm::vec3(0.0F, 4.0F, 1.0F), up)); // the arcade's roof
    EXPECT_TRUE(yard.hides(middle + glm::vec3(0.0F, 4.0F, 1.0F), glm::normalize(glm::vec3(0.1F, 1.0F, 0.5F))));
    EXPECT_TRUE(yard.hides(middle + glm::vec3(0.0F, 0.0F, 5.0F), -up)); // the floor
    EXPECT_TRUE(yard.is_solid(middle + glm::vec3(1.4F, 2.4F, 1.0F)));   // a pillar
    EXPECT_FALSE(yard.is_solid(middle + glm::vec3(0.0F, 2.4F, 1.0F)));  // between pillars
    // Half of a box that the roof's edge cuts, seen from below.
    const float part = yard.visibility(middle + glm::vec3(0.0F, 2.1F, 1.0F), glm::vec3(0.0F, 3.0F, 0.0F), up);
    EXPECT_GT(part, 0.3F);
    EXPECT_LT(part, 0.7F);
}

TEST_F(ProbeSceneTest, YardsTrianglesLookOutwards) {
    Yard yard(game_->world());
    std::vector<ColorVertex> vertices;
    std::vector<std::uint32_t> indices;
    yard.append_mesh({.sun_lux = glm::vec3(5e4F)}, vertices, indices);
    ASSERT_EQ(indices.size() % 3, 0U);
    for (std::size_t i = 0; i < indices.size(); i += 3) {
        const glm::vec3 a = vertices[indices[i]].position_m;
        const glm::vec3 b = vertices[indices[i + 1]].position_m;
        const glm::vec3 c = vertices[indices[i + 2]].position_m;
        const glm::vec3 normal = glm::normalize(glm::cross(b - a, c - a));
        const glm::vec3 centre = (a + b + c) / 3.0F;
        ASSERT_TRUE(yard.is_solid(centre - 0.01F * normal)) << "triangle " << i / 3;
    }
}

// A lone sun overhead: red exactly where the sum of nine terms is below 0.
TEST(ProbeDisplay, IsRedWhereTheIrradianceIsNegative) {
    std::array<double, 3> zonal{};
    sh::zonal_delta(3, zonal);
    std::array<glm::vec3, 9> light{};
    for (int l = 0; l < 3; ++l) {
        light[static_cast<std::size_t>(l * (l + 1))] =
            glm::vec3(static_cast<float>(zonal[static_cast<std::size_t>(l)]));
    }
    std::array<glm::vec3, 9> lux{};
    sh::irradiance(3, std::span<const glm::vec3>(light), std::span<glm::vec3>(lux));
    std::vector<ColorVertex> vertices;
    std::vector<std::uint32_t> indices;
    append_probe_display(light, glm::vec3(0.0F), 1.0F, vertices, indices);
    ASSERT_GT(vertices.size(), 6U);
    int red = 0;
    for (std::size_t i = 0; i + 6 < vertices.size(); ++i) { // the pin comes last
        const glm::vec3 direction = glm::normalize(vertices[i].position_m);
        const float value = sh::evaluate(3, std::span<const glm::vec3>(lux), direction).g;
        if (std::abs(value) < 1e-5F) {
            continue;
        }
        EXPECT_EQ(vertices[i].light.w == 1.0F, value < 0.0F);
        red += value < 0.0F ? 1 : 0;
        EXPECT_NEAR(glm::length(vertices[i].position_m), 0.5F + 0.5F * std::sqrt(std::abs(value) * 4.0F), 1e-4F);
    }
    EXPECT_GT(red, 0);
    // The minimum of 1/4 + z/2 + 5/16 (3 z^2 - 1)/2 is at z = -8/15.
    const glm::vec3 pin = 0.5F * (vertices[vertices.size() - 1].position_m + vertices[vertices.size() - 2].position_m);
    EXPECT_NEAR(glm::normalize(pin).z, -8.0F / 15.0F, 1e-4F);
    for (const std::uint32_t index : indices) {
        ASSERT_LT(index, vertices.size());
    }
}

} // namespace
} // namespace alpenglow::sandbox
