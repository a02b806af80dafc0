#include "clouds_test_support.hpp"

#include <alpenglow/clouds/optical_depth.hpp>
#include <alpenglow/clouds/phase.hpp>

#include <gtest/gtest.h>

namespace {

using namespace alpenglow;
using namespace alpenglow::clouds;

const glm::vec3 directions[] = {{0, 0, 1},
                                {1, 0, 0},
                                {0, -1, 0},
                                {0.3F, 0.5F, 0.8F},
                                {-0.9F, 0.3F, 0.2F},
                                {0.1F, -0.8F, -0.4F},
                                {0.577F, 0.577F, 0.577F}};

TEST(CloudDepth, ColumnsAgreeWithAFineMarch) {
    SparseGrid grid = noise_cloud(31, 40);
    GridTransform transform;
    transform.voxel_m = {1.0, 1.5, 0.8};
    grid.set_transform(transform);
    const BrickVolume volume(grid);
    const Lattice lattice = lattice_over(volume, 1, 1, 1 << 24);
    const std::vector<float> density = volume.block_means(lattice.first, lattice.dims, 1);
    for (const glm::vec3& d : directions) {
        const LightDepth depth = light_depth(lattice, density, glm::vec3(transform.voxel_m), test::unit(d), 1.0F);
        double squares = 0.0;
        const int n = 300;
        for (std::uint32_t i = 0; i < n; ++i) {
            const glm::ivec3 c(glm::vec3(lattice.dims) * glm::vec3(test::random_at(3 * i), test::random_at(3 * i + 1),
                                                                   test::random_at(3 * i + 2)));
            const double a = depth.depth[(std::size_t(c.z) * std::size_t(lattice.dims.y) + std::size_t(c.y)) *
                                             std::size_t(lattice.dims.x) +
                                         std::size_t(c.x)];
            const double b = marched_depth(volume, glm::dvec3(lattice.first + c), test::unit(d), 0.25);
            const double e = std::exp(-0.3 * a) - std::exp(-0.3 * b);
            squares += e * e;
        }
        EXPECT_LT(std::sqrt(squares / n), 0.01) << d.x << " " << d.y << " " << d.z;
    }
}

TEST(CloudDepth, WhatIsReadFromSharpenedDepthsHasNoBias) {
    // Transmittance at random points inside, against a fine march from each: lines between depths lie above them where
    // light enters, sharpened ones do not on average.
    const SparseGrid grid = noise_cloud(33, 48);
    const BrickVolume volume(grid);
    const Lattice lattice = lattice_over(volume, 1, 1, 1 << 24);
    const std::vector<float> density = volume.block_means(lattice.first, lattice.dims, 1);
    for (const glm::vec3& d : {glm::vec3(0.0F, 0.8660254F, 0.5F), glm::vec3(-0.9F, 0.3F, 0.2F)}) {
        const LightDepth depth = light_depth(lattice, density, glm::vec3(1.0F), test::unit(d), 1.0F);
        const Field16 lines(lattice, depth.depth);
        const Field16 field(lattice, sharpened(lattice, depth.depth));
        double exact = 0.0;
        double by_lines = 0.0;
        double read = 0.0;
        for (std::uint32_t i = 0; i < 20000; ++i) {
            const glm::vec3 p = glm::vec3(48.0F) * glm::vec3(test::random_at(3 * i), test::random_at(3 * i + 1),
                                                             test::random_at(3 * i + 2));
            const double weight = double(volume.sample(p));
            if (weight <= 0.0) {
                continue;
            }
            exact += weight * std::exp(-marched_depth(volume, glm::dvec3(p), test::unit(d), 0.25));
            by_lines += weight * std::exp(-double(lines.sample(p)));
            read += weight * std::exp(-double(field.sample(p)));
        }
        EXPECT_LT(by_lines, exact);
        EXPECT_LT(std::abs(read / exact - 1.0), 0.4 * std::abs(by_lines / exact - 1.0)) << read / exact;
    }
    // Linear depths stay as they are.
    const Lattice cube{{0, 0, 0}, {6, 5, 7}, 1};
    std::vector<float> plane;
    for (std::size_t i = 0; i < cube.cells(); ++i) {
        plane.push_back(1.0F + 0.5F * static_cast<float>(i % 6) + 0.25F * static_cast<float>(i / 30));
    }
    const std::vector<float> same = sharpened(cube, plane);
    for (std::size_t i = 0; i < plane.size(); ++i) {
        ASSERT_NEAR(same[i], plane[i], 1e-5F);
    }
}

TEST(CloudDepth, WhatColumnsRemoveIsWhatTheCloudRemoves) {
    // For a thin cloud the light removed is extinction times mass, whatever the direction.
    const SparseGrid grid = noise_cloud(32, 32);
    const BrickVolume volume(grid);
    const Lattice lattice = lattice_over(volume, 1, 1, 1 << 24);
    const std::vector<float> density = volume.block_means(lattice.first, lattice.dims, 1);
    double mass = 0.0;
    for (const float d : density) {
        mass += double(d);
    }
    for (const glm::vec3& d : directions) {
        const LightDepth depth = light_depth(lattice, density, glm::vec3(1.0F), test::unit(d), 1e-4F);
        EXPECT_NEAR(depth.removed_m2 / (1e-4 * mass), 1.0, 5e-3) << d.x << " " << d.y << " " << d.z;
    }
}

TEST(CloudDepth, HarrisIsItsRecurrence) {
    // A cloud that varies along the light alone: each slice is one particle of eq. 8.
    const int n = 24;
    std::vector<float> tau(n);
    Lattice lattice{{0, 0, 0}, {9, 9, n}, 1};
    std::vector<float> density(lattice.cells());
    for (int z = 0; z < n; ++z) {
        const float d = 0.2F + test::random_at(std::uint32_t(z));
        tau[std::size_t(n - 1 - z)] = 0.6F * 2.0F * d; // extinction * thickness * density, from the light's side
        std::fill_n(density.begin() + z * 81, 81, d);
    }
    const double gain = 0.9 * double(phase_value({PhaseKind::rayleigh, 0, 0, 1}, 0.0F));
    const std::vector<float> depth =
        harris_depth(lattice, density, {1.0F, 1.0F, 2.0F}, {0, 0, 1}, 0.6F, static_cast<float>(gain), false);
    std::vector<double> incident(n);
    harris_incident(tau.data(), n, gain, incident.data());
    for (int k = 0; k < n; ++k) {
        const double i = std::exp(-double(depth[std::size_t(n - 1 - k) * 81 + 40]));
        EXPECT_NEAR(i, incident[std::size_t(k)], 1e-5);
        // Eq. 7, to which eq. 8 expands: I_0 prod T + sum g_j prod T.
        double sum = 1.0;
        for (int j = 0; j < k; ++j) {
            sum *= std::exp(-double(tau[std::size_t(j)]));
        }
        for (int j = 0; j < k; ++j) {
            double g = gain * double(tau[std::size_t(j)]) * incident[std::size_t(j)];
            for (int l = j + 1; l < k; ++l) {
                g *= std::exp(-double(tau[std::size_t(l)]));
            }
            sum += g;
        }
        EXPECT_NEAR(incident[std::size_t(k)], sum, 1e-12);
    }
    // The frame buffer's range: saturation keeps I at 1 where a forward phase would make it grow.
    const std::vector<float> held = harris_depth(lattice, density, {1.0F, 1.0F, 2.0F}, {0, 0, 1}, 0.6F, 6.0F, true);
    for (const float d : held) {
        EXPECT_GE(d, 0.0F);
    }
}

TEST(CloudDepth, SixteenBitsAreEnough) {
    Lattice lattice{{-3, 2, 5}, {7, 6, 5}, 2};
    std::vector<float> values(lattice.cells());
    for (std::size_t i = 0; i < values.size(); ++i) {
        values[i] = 40.0F * test::random_at(std::uint32_t(i));
    }
    const Field16 field(lattice, values);
    for (int z = 0; z < 5; ++z) {
        for (int y = 0; y < 6; ++y) {
            for (int x = 0; x < 7; ++x) {
                const glm::vec3 centre = glm::vec3(lattice.first) + glm::vec3(x, y, z) * 2.0F + 0.5F;
                EXPECT_NEAR(field.sample(centre), values[std::size_t((z * 6 + y) * 7 + x)], 40.0F / 131000.0F + 1e-5F);
            }
        }
    }
}

} // namespace
