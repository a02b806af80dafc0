#include "clouds_test_support.hpp"

#include <alpenglow/clouds/compact.hpp>
#include <alpenglow/clouds/lighting.hpp>
#include <alpenglow/clouds/march.hpp>
#include <alpenglow/clouds/reference.hpp>

#include <gtest/gtest.h>

namespace {

using namespace alpenglow;
using namespace alpenglow::clouds;

glm::dvec3 centre_of(const BrickVolume& volume) {
    return volume.transform().world_from_index(glm::dvec3(volume.active_low() + volume.active_high()) * 0.5);
}

Picture picture_of(const BrickVolume& volume, const CloudLighting& lighting, const glm::dvec3& direction, int width,
                   int height, double distance = 80.0, float step = 1.0F) {
    MarchSettings settings;
    settings.step_voxels = step;
    const glm::dvec3 centre = centre_of(volume);
    return march(volume, lighting, look_at(centre + direction * distance, centre, 0.3F, width, height), settings);
}

TEST(CloudLighting, AWhiteFurnaceStaysWhiteAtEveryDensity) {
    const SparseGrid grid = noise_cloud(41, 32);
    const BrickVolume volume(grid);
    for (const float extinction : {1e-12F, 1e-3F, 0.3F, 3.0F, 100.0F, 1e6F}) {
        for (const float g : {0.0F, 0.85F}) {
            for (const int factor : {3, 2, 1}) { // of large clouds, small ones, and the slower level
                LightingSettings settings;
                settings.transport_factor = factor;
                CloudLighting lighting;
                lighting.reset(volume, {extinction, 1.0F, {PhaseKind::henyey_greenstein, g, 0, 0}}, settings);
                lighting.bake_sky(SkySh::uniform(glm::vec3(2.0F)));
                const Picture plain = picture_of(volume, lighting, {0.0, -1.0, 0.0}, 24, 16);
                const glm::dvec3 centre = centre_of(volume);
                const Camera camera = look_at(centre + glm::dvec3(0.0, -80.0, 0.0), centre, 0.3F, 24, 16);
                const Picture compact = march(CompactCloud(volume, lighting, camera.position_m), camera);
                for (const Picture* picture : {&plain, &compact}) {
                    for (std::size_t i = 0; i < picture->radiance.size(); ++i) {
                        ASSERT_NEAR((picture->radiance[i].y + 2.0F * picture->transmittance[i]) / 2.0F, 1.0F, 1e-3F)
                            << extinction << " " << g << " " << factor << (picture == &compact ? " compact" : "");
                    }
                }
            }
        }
    }
}

// A cloud of 24 mean free paths a side seen from three sides, and under the sky.
class CloudAccuracy : public ::testing::TestWithParam<Medium> {};

TEST_P(CloudAccuracy, TransportIsCloseToThePathTracerFromAllSides) {
    const SparseGrid grid = noise_cloud(42, 40);
    const BrickVolume volume(grid);
    const Medium medium = GetParam();
    const DirectionalLight sun{test::unit({0.0F, 0.8F, 0.5F}), glm::vec3(1.0F), 0.0F};
    struct Level {
        int factor;
        int sweeps;
        double rmse;
    };
    constexpr Level levels[] = {{2, 6, 0.10}, {1, 6, 0.05}}; // the default and the slower one
    CloudLighting lit[2];
    CloudLighting under_sky[2];
    for (std::size_t i = 0; i < 2; ++i) {
        LightingSettings settings;
        settings.transport_factor = levels[i].factor;
        settings.sweeps = levels[i].sweeps;
        lit[i].reset(volume, medium, settings);
        lit[i].bake_light(0, sun);
        under_sky[i].reset(volume, medium, settings);
        under_sky[i].bake_sky(SkySh::uniform(glm::vec3(1.0F)));
    }
    for (int view = 0; view < 4; ++view) {
        const glm::dvec3 eye[] = {{1.0, 0.0, 0.1}, {0.2, 0.9, 0.3}, {0.1, -0.9, 0.1}, {-0.7, 0.7, -0.1}};
        ReferenceScene scene;
        scene.grid = &grid;
        scene.medium = medium;
        if (view < 3) {
            scene.lights = {sun};
        } else {
            scene.sky = [](const glm::vec3&) { return glm::vec3(1.0F); };
        }
        const glm::dvec3 centre = centre_of(volume);
        const Camera camera = look_at(centre + eye[view] * 80.0, centre, 0.3F, 24, 16);
        ReferenceImage truth(24, 16);
        PathTracer(std::move(scene)).render(camera, truth, 0, 1024);
        Camera fine = camera;
        fine.width *= 4;
        fine.height *= 4;
        for (std::size_t i = 0; i < 2; ++i) {
            const Picture picture = march(volume, view < 3 ? lit[i] : under_sky[i], fine);
            std::vector<glm::vec3> image(24 * 16, glm::vec3(0.0F));
            std::vector<float> clear(image.size(), 0.0F);
            for (int y = 0; y < fine.height; ++y) {
                for (int x = 0; x < fine.width; ++x) {
                    const std::size_t from = std::size_t(y) * 96 + std::size_t(x);
                    const std::size_t to = std::size_t(y / 4) * 24 + std::size_t(x / 4);
                    image[to] += (picture.radiance[from] + (view == 3 ? picture.transmittance[from] : 0.0F)) / 16.0F;
                    clear[to] += picture.transmittance[from] / 16.0F;
                }
            }
            std::vector<bool> mask;
            for (const float t : clear) {
                mask.push_back(t < 0.99F);
            }
            const ImageError error = image_error(image, truth, mask);
            // What the reference's noise leaves unknown: of the mean over pixels, and of that of products of errors.
            const auto pixels = double(std::count(mask.begin(), mask.end(), true));
            const double unknown = error.noise * std::sqrt(2.0 / std::sqrt(pixels));
            EXPECT_LT(error.relative_rmse, std::hypot(view == 3 ? 0.03 : levels[i].rmse, unknown))
                << view << " level " << i;
            EXPECT_LT(std::abs(error.bias), 0.03 + 2.0 * error.noise / std::sqrt(pixels)) << view << " level " << i;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Media, CloudAccuracy,
                         ::testing::Values(Medium{1.0F, 0.99F, {PhaseKind::henyey_greenstein, 0.6F, 0, 0}},
                                           Medium{1.0F, 0.9F, {PhaseKind::henyey_greenstein, 0.0F, 0, 0}},
                                           Medium{1.0F, 1.0F, {PhaseKind::henyey_greenstein, 0.85F, 0, 0}}));

TEST(CloudLighting, LightAddsUpAndScales) {
    const SparseGrid grid = noise_cloud(43, 32);
    const BrickVolume volume(grid);
    const DirectionalLight sun{test::unit({0.5F, 0.5F, 0.6F}), glm::vec3(3.0F, 2.0F, 1.0F), 0.0F};
    const DirectionalLight moon{test::unit({-0.5F, 0.2F, 0.3F}), glm::vec3(0.1F, 0.2F, 0.4F), 0.0F};
    for (const LightingMethod method : {LightingMethod::single_scattering, LightingMethod::harris,
                                        LightingMethod::octaves, LightingMethod::transport}) {
        LightingSettings settings;
        settings.method = method;
        CloudLighting one;
        CloudLighting other;
        CloudLighting both;
        for (CloudLighting* lighting : {&one, &other, &both}) {
            lighting->reset(volume, {0.5F, 0.98F, {}}, settings);
        }
        one.bake_light(0, sun);
        other.bake_light(0, moon);
        both.bake_light(0, sun);
        both.bake_light(1, moon);
        const glm::dvec3 eye(0.3, -0.9, 0.2);
        const Picture a = picture_of(volume, one, eye, 16, 12);
        const Picture b = picture_of(volume, other, eye, 16, 12);
        const Picture c = picture_of(volume, both, eye, 16, 12);
        both.set_irradiance(0, sun.irradiance * 2.0F);
        const Picture d = picture_of(volume, both, eye, 16, 12);
        for (std::size_t i = 0; i < a.radiance.size(); ++i) {
            for (int k = 0; k < 3; ++k) {
                const float scale = 1e-3F * (a.radiance[i][k] + b.radiance[i][k]) + 2e-5F;
                ASSERT_NEAR(c.radiance[i][k], a.radiance[i][k] + b.radiance[i][k], scale);
                ASSERT_NEAR(d.radiance[i][k], 2.0F * a.radiance[i][k] + b.radiance[i][k], 2.0F * scale);
            }
        }
    }
}

TEST(CloudLighting, ATurnedSceneLooksTheSame) {
    // The same cloud, light and eye, all turned by one rotation, on a lattice that is turned with them.
    SparseGrid grid = noise_cloud(44, 28);
    const BrickVolume upright(grid);
    GridTransform turned_transform;
    const double a = 0.9;
    const double b = -0.4;
    turned_transform.axes = glm::dmat3(std::cos(a), std::sin(a), 0, -std::sin(a), std::cos(a), 0, 0, 0, 1) *
                            glm::dmat3(1, 0, 0, 0, std::cos(b), std::sin(b), 0, -std::sin(b), std::cos(b));
    turned_transform.origin_m = {500.0, -300.0, 100.0};
    grid.set_transform(turned_transform);
    const BrickVolume turned(grid);
    const glm::vec3 to_sun = test::unit({0.4F, -0.2F, 0.7F});
    const Medium medium{0.6F, 0.97F, {}};
    CloudLighting first;
    CloudLighting second;
    first.reset(upright, medium, {});
    second.reset(turned, medium, {});
    first.bake_light(0, {to_sun, glm::vec3(1.0F), 0.0F});
    second.bake_light(0, {glm::vec3(turned_transform.axes * glm::dvec3(to_sun)), glm::vec3(1.0F), 0.0F});
    const Camera camera = look_at({60.0, -20.0, 30.0}, {13.0, 13.0, 13.0}, 0.3F, 16, 12);
    Camera moved = camera;
    moved.position_m = turned_transform.world_from_index(camera.position_m);
    moved.forward = glm::vec3(turned_transform.axes * glm::dvec3(camera.forward));
    moved.right = glm::vec3(turned_transform.axes * glm::dvec3(camera.right));
    moved.up = glm::vec3(turned_transform.axes * glm::dvec3(camera.up));
    const Picture p = march(upright, first, camera);
    const Picture q = march(turned, second, moved);
    for (std::size_t i = 0; i < p.radiance.size(); ++i) {
        ASSERT_NEAR(p.radiance[i].x, q.radiance[i].x, 2e-3F * p.radiance[i].x + 1e-4F);
        ASSERT_NEAR(p.transmittance[i], q.transmittance[i], 1e-3F);
    }
}

TEST(CloudLighting, EnergyIsConserved) {
    // All light that a bright cloud takes from the sun leaves it again: the mean over directions of what an eye far
    // away gets, scattered, equals what the columns say was removed.
    const SparseGrid grid = noise_cloud(45, 28);
    const BrickVolume volume(grid);
    for (const float g : {0.0F, 0.85F}) {
        const Medium medium{0.8F, 1.0F, {PhaseKind::henyey_greenstein, g, 0, 0}};
        CloudLighting lighting;
        LightingSettings settings;
        settings.sweeps = 6;
        lighting.reset(volume, medium, settings);
        const glm::vec3 to_sun(0.0F, 0.0F, 1.0F);
        lighting.bake_light(0, {to_sun, glm::vec3(1.0F), 0.0F});
        const Lattice lattice = lattice_over(volume, 1, 1, 1 << 22);
        const std::vector<float> density = volume.block_means(lattice.first, lattice.dims, 1);
        const double removed =
            light_depth(lattice, density, glm::vec3(1.0F), to_sun, medium.extinction_per_m).removed_m2;
        double scattered = 0.0;
        const int n = 300; // Fibonacci directions; near-forward light is spread over few of them
        const double distance = 2000.0;
        for (int i = 0; i < n; ++i) {
            const double z = 1.0 - 2.0 * (i + 0.5) / n;
            const double azimuth = 2.399963 * i;
            const double s = std::sqrt(1.0 - z * z);
            const glm::dvec3 d(s * std::cos(azimuth), s * std::sin(azimuth), z);
            const glm::dvec3 centre = centre_of(volume);
            const float tangent = 0.0125F;
            const Picture picture = march(volume, lighting, look_at(centre + d * distance, centre, tangent, 32, 32));
            for (const glm::vec3& c : picture.radiance) {
                const double pixel = 2.0 * double(tangent) * distance / 32.0;
                scattered += double(c.x) * pixel * pixel * 12.566370614 / n;
            }
        }
        EXPECT_NEAR(scattered / removed, 1.0, g > 0.5F ? 0.08 : 0.04) << g;
    }
}

TEST(CloudLighting, BakesSideBySideAreBakesOneAfterTheOther) {
    const SparseGrid grid = noise_cloud(47, 32);
    const BrickVolume volume(grid);
    const DirectionalLight sun{test::unit({0.2F, 0.5F, 0.7F}), glm::vec3(9.0F, 8.0F, 7.0F), 0.0F};
    const DirectionalLight moon{test::unit({-0.7F, 0.1F, 0.4F}), glm::vec3(0.1F, 0.1F, 0.2F), 0.0F};
    SkySh sky = SkySh::uniform(glm::vec3(0.3F, 0.5F, 1.0F));
    sky.bands = 2;
    sky.coefficients[2] = glm::vec3(0.3F, 0.1F, 0.2F);
    CloudLighting apart;
    apart.reset(volume, {0.4F, 0.99F, {}}, {});
    apart.bake_light(0, sun, false);
    apart.bake_light(1, moon, false);
    apart.bake_sky(sky, false);
    CloudLighting together;
    together.reset(volume, {0.4F, 0.99F, {}}, {});
    together.start_light(0, sun, false);
    together.start_light(1, moon, false);
    together.start_sky(sky, false);
    EXPECT_TRUE(together.working());
    EXPECT_GT(together.finish().residual, 0.0F);
    EXPECT_FALSE(together.working());
    EXPECT_EQ(together.finish().residual, 0.0F); // nothing left
    const Picture a = picture_of(volume, apart, {0.6, -0.8, 0.0}, 24, 16);
    const Picture b = picture_of(volume, together, {0.6, -0.8, 0.0}, 24, 16);
    for (std::size_t i = 0; i < a.radiance.size(); ++i) {
        ASSERT_EQ(a.radiance[i], b.radiance[i]);
    }
}

TEST(CloudLighting, AWarmBakeForgetsWhereItCameFrom) {
    const SparseGrid grid = noise_cloud(46, 32);
    const BrickVolume volume(grid);
    CloudLighting warm;
    CloudLighting cold;
    LightingSettings settings;
    settings.sweeps = 6;
    settings.warm_sweeps = 2;
    warm.reset(volume, {0.8F, 0.99F, {}}, settings);
    cold.reset(volume, {0.8F, 0.99F, {}}, settings);
    const glm::vec3 now = test::unit({0.35F, 0.0F, 1.0F});
    warm.bake_light(0, {test::unit({0.30F, 0.0F, 1.0F}), glm::vec3(1.0F), 0.0F});
    warm.bake_light(0, {now, glm::vec3(1.0F), 0.0F});
    cold.bake_light(0, {now, glm::vec3(1.0F), 0.0F});
    const Picture a = picture_of(volume, warm, {0.0, -1.0, 0.2}, 24, 16);
    const Picture b = picture_of(volume, cold, {0.0, -1.0, 0.2}, 24, 16);
    double difference = 0.0;
    double norm = 0.0;
    for (std::size_t i = 0; i < a.radiance.size(); ++i) {
        difference += double(a.radiance[i].x - b.radiance[i].x) * double(a.radiance[i].x - b.radiance[i].x);
        norm += double(b.radiance[i].x) * double(b.radiance[i].x);
    }
    EXPECT_LT(std::sqrt(difference / norm), 0.02);
}

TEST(CloudLighting, DirectionalSkiesFollowTheirDirection) {
    // A sky that is bright above lights the top more than the underside; turned over, the reverse.
    const SparseGrid grid = test::box_cloud({24, 24, 24}, 1.0F);
    const BrickVolume volume(grid);
    SkySh sky = SkySh::uniform(glm::vec3(1.0F));
    sky.bands = 2;
    for (const float sign : {1.0F, -1.0F}) {
        sky.coefficients[2] = glm::vec3(sign * 1.5F);
        for (const LightingMethod method : {LightingMethod::single_scattering, LightingMethod::transport}) {
            CloudLighting lighting;
            LightingSettings settings;
            settings.method = method;
            lighting.reset(volume, {0.5F, 0.99F, {}}, settings);
            lighting.bake_sky(sky);
            const float top = lighting.mean_radiance({12.0F, 12.0F, 22.0F}).x;
            const float bottom = lighting.mean_radiance({12.0F, 12.0F, 1.0F}).x;
            EXPECT_GT(sign * (top - bottom), 0.1F);
        }
    }
}

} // namespace
