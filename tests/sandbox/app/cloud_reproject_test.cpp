#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "sandbox/app/cloud_reproject.hpp"

namespace alpenglow::sandbox {
namespace {

constexpr int width = 61; // neither is a multiple of 2 or 3
constexpr int height = 35;

clouds::Camera camera_at(const glm::dvec3& eye, const glm::dvec3& target) {
    return clouds::look_at(eye, target, 0.4F, width, height);
}

// A wall at y = 1000 with waves of 24 to 33 pixels on it: what a pixel shows hangs on the place alone.
clouds::Picture wall(const clouds::Camera& camera) {
    clouds::Picture picture(camera.width, camera.height);
    for (int y = 0; y < camera.height; ++y) {
        for (int x = 0; x < camera.width; ++x) {
            const glm::vec3 d = camera.direction(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F);
            const double distance = (1000.0 - camera.position_m.y) / double(d.y);
            const glm::dvec3 at = camera.position_m + distance * glm::dvec3(d);
            const auto pixel = static_cast<std::size_t>(y * camera.width + x);
            const auto wave = static_cast<float>(0.5 + 0.25 * std::sin(at.x / 120.0) + 0.25 * std::cos(at.z / 90.0));
            picture.radiance[pixel] = glm::vec3(1.0F, 0.8F, 0.6F) * wave;
            picture.transmittance[pixel] = 0.1F + 0.2F * wave;
            picture.depth_m[pixel] = static_cast<float>(distance);
        }
    }
    return picture;
}

double rmse(const clouds::Picture& a, const clouds::Picture& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.radiance.size(); ++i) {
        const glm::vec3 d = a.radiance[i] - b.radiance[i];
        sum += double(glm::dot(d, d)) / 3.0;
    }
    return std::sqrt(sum / double(a.radiance.size()));
}

TEST(CloudReprojection, ALatticesCameraLooksAlongItsPixels) {
    const clouds::Camera camera = camera_at({10, -20, 30}, {100, 400, 60});
    for (const int n : {1, 2, 3}) {
        for (int turn = 0; turn < n * n; ++turn) {
            const PixelLattice lattice = lattice_of(n, turn);
            const clouds::Camera some = lattice_camera(camera, lattice);
            for (int j = 0; j < some.height; j += 5) {
                for (int i = 0; i < some.width; i += 7) {
                    const glm::vec3 a = some.direction(static_cast<float>(i) + 0.5F, static_cast<float>(j) + 0.5F);
                    const glm::vec3 b = camera.direction(static_cast<float>(n * i + lattice.first.x) + 0.5F,
                                                         static_cast<float>(n * j + lattice.first.y) + 0.5F);
                    ASSERT_LT(glm::length(a - b), 2e-6F);
                }
            }
        }
    }
}

TEST(CloudReprojection, TheLatticesTogetherAreThePictureWhereNothingMoves) {
    const clouds::Camera camera = camera_at({0, 0, 0}, {0, 1000, 0});
    const clouds::Picture exact = wall(camera);
    const std::vector<float> sky(exact.radiance.size(), 1e30F);
    for (const int n : {2, 3}) {
        clouds::Picture last(width, height); // empty: every pixel has to come from somewhere
        for (int turn = 0; turn < n * n; ++turn) {
            const PixelLattice lattice = lattice_of(n, turn);
            clouds::Picture next(width, height);
            complete_picture(wall(lattice_camera(camera, lattice)), lattice, {last, camera, sky}, camera, sky, next);
            last = next;
        }
        for (int turn = 0; turn < n * n; ++turn) {
            const PixelLattice lattice = lattice_of(n, turn);
            clouds::Picture next(width, height);
            const std::size_t without = complete_picture(wall(lattice_camera(camera, lattice)), lattice,
                                                         {last, camera, sky}, camera, sky, next);
            EXPECT_EQ(without, 0U);
            last = next;
        }
        EXPECT_LT(rmse(last, exact), 1e-3); // 60 dB: crests are held to what is seen around them
    }
}

TEST(CloudReprojection, FollowsTheWallWhileTheCameraMoves) {
    glm::dvec3 eye(0.0);
    clouds::Camera camera = camera_at(eye, eye + glm::dvec3(0, 1000, 0));
    clouds::Picture last = wall(camera);
    const std::vector<float> sky(last.radiance.size(), 1e30F);
    double interpolated_worst = 0.0;
    double worst = 0.0;
    for (int frame = 0; frame < 30; ++frame) {
        eye += glm::dvec3(1.5, 4.0, 0.5);
        const clouds::Camera now = camera_at(eye, eye + glm::dvec3(0.02 * frame, 10.0, 0.01 * frame));
        const PixelLattice lattice = lattice_of(3, frame);
        const clouds::Picture fresh = wall(lattice_camera(now, lattice));
        clouds::Picture next(width, height);
        complete_picture(fresh, lattice, {last, camera, sky}, now, sky, next);
        const clouds::Picture exact = wall(now);
        worst = std::max(worst, rmse(next, exact));
        // What the same rays give without the picture before.
        const std::vector<float> wall_of_rock(last.radiance.size(), 1.0F);
        clouds::Picture alone(width, height);
        complete_picture(fresh, lattice, {last, camera, wall_of_rock}, now, sky, alone);
        interpolated_worst = std::max(interpolated_worst, rmse(alone, exact));
        last = next;
        camera = now;
    }
    EXPECT_LT(worst, 0.01); // 40 dB of a picture between 0 and 1
    EXPECT_LT(worst, 0.7 * interpolated_worst);
}

TEST(CloudReprojection, WhatWasBehindTheLandscapeIsNotTakenFromIt) {
    const clouds::Camera camera = camera_at({0, 0, 0}, {0, 1000, 0});
    const clouds::Picture exact = wall(camera);
    const std::vector<float> sky(exact.radiance.size(), 1e30F);
    const std::vector<float> hidden(exact.radiance.size(), 50.0F);
    const clouds::Picture nothing(width, height); // a mountain stood there
    const PixelLattice lattice = lattice_of(3, 0);
    clouds::Picture next(width, height);
    const std::size_t without =
        complete_picture(wall(lattice_camera(camera, lattice)), lattice, {nothing, camera, hidden}, camera, sky, next);
    EXPECT_EQ(without, exact.radiance.size() - std::size_t(21 * 12)); // all but the fresh ones
    EXPECT_LT(rmse(next, exact), 0.1);
}

} // namespace
} // namespace alpenglow::sandbox
