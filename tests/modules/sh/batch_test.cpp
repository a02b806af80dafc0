// Every batch function against its scalar namesake, on every instruction set that this machine has.
#include "support.hpp"

#include <alpenglow/sh/batch.hpp>
#include <alpenglow/sh/product.hpp>
#include <alpenglow/sh/project.hpp>
#include <alpenglow/sh/rotate.hpp>

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace alpenglow::sh {
namespace {

class Batches : public ::testing::TestWithParam<BatchTarget> {
protected:
    void SetUp() override {
        if (!limit_batch_target(GetParam())) {
            GTEST_SKIP() << "not on this machine";
        }
    }
    void TearDown() override { limit_batch_target(BatchTarget::best); }

    // Not a multiple of the group, so that the tail is tested.
    static constexpr std::size_t count = 101;
    test::Random random{77};

    BatchBuffer coefficients(int order) {
        BatchBuffer b(static_cast<std::size_t>(coefficient_count(order)), count);
        for (std::size_t i = 0; i < b.rows(); ++i) {
            for (std::size_t k = 0; k < count; ++k) {
                b.row(i)[k] = static_cast<float>(random.normal());
            }
        }
        return b;
    }
    BatchBuffer directions() {
        BatchBuffer b(3, count);
        for (std::size_t k = 0; k < count; ++k) {
            const glm::vec3 d(random.direction());
            b.row(0)[k] = d.x;
            b.row(1)[k] = d.y;
            b.row(2)[k] = d.z;
        }
        return b;
    }
    static std::vector<double> item(const BatchBuffer& b, std::size_t k) {
        std::vector<double> v;
        for (std::size_t i = 0; i < b.rows(); ++i) {
            v.push_back(static_cast<double>(b.row(i)[k]));
        }
        return v;
    }
    static glm::dvec3 direction(const BatchBuffer& b, std::size_t k) {
        const std::vector<double> v = item(b, k);
        return {v[0], v[1], v[2]};
    }
};

TEST_P(Batches, BasisAndFusedEvaluation) {
    const BatchBuffer d = directions();
    for (int order = 1; order <= max_order; ++order) {
        const BatchBuffer c = coefficients(order);
        BatchBuffer y(c.rows(), count), own(1, count), shared(1, count);
        evaluate_basis(order, d, y);
        evaluate(order, c.view(), d.view(), own.view());
        const std::vector<double> first = item(c, 0);
        evaluate(order, test::to_float(first), d, shared);
        const double basis_bound = order <= 3 ? 1.5e-7 : order <= 5 ? 4e-7 : order <= 6 ? 6e-7 : 2e-6;
        for (std::size_t k = 0; k < count; ++k) {
            const glm::dvec3 direction_k = direction(d, k);
            std::vector<double> expected(c.rows());
            evaluate_basis(order, direction_k, expected);
            for (std::size_t i = 0; i < c.rows(); ++i) {
                EXPECT_NEAR(static_cast<double>(y.row(i)[k]), expected[i], basis_bound) << order << ' ' << i;
            }
            const std::vector<double> ck = item(c, k);
            EXPECT_NEAR(static_cast<double>(own.row(0)[k]), evaluate(order, ck, direction_k), 5e-7 * test::norm(ck));
            EXPECT_NEAR(static_cast<double>(shared.row(0)[k]), evaluate(order, first, direction_k),
                        (order <= 6 ? 4e-7 : 1e-6) * test::norm(first));
        }
    }
}

TEST_P(Batches, RotationByOneMatrixAndByOwnQuaternions) {
    for (int order = 1; order <= max_order; ++order) {
        const BatchBuffer f = coefficients(order);
        BatchBuffer q(4, count), shared(f.rows(), count), own(f.rows(), count);
        const Rotation rotation(order, random.rotation());
        for (std::size_t k = 0; k < count; ++k) {
            // A third of the rotations are tiny tilts, some about z only, some by half a turn.
            glm::dquat r = random.rotation();
            if (k % 3 == 0) {
                const double tilt = std::pow(10.0, random.uniform(-9.0, -1.0));
                const glm::dvec3 axis = random.direction() * std::sin(tilt / 2.0);
                r = glm::dquat(std::cos(tilt / 2.0), axis.x, axis.y, axis.z);
            } else if (k % 10 == 1) {
                r = glm::dquat(0.6, 0.0, 0.0, 0.8);
            } else if (k % 10 == 2) {
                r = glm::dquat(0.0, 0.6, 0.8, 0.0);
            }
            q.row(0)[k] = static_cast<float>(r.x);
            q.row(1)[k] = static_cast<float>(r.y);
            q.row(2)[k] = static_cast<float>(r.z);
            q.row(3)[k] = static_cast<float>(r.w);
        }
        rotate(rotation, f, shared);
        rotate(order, q.view(), f.view(), own.view());
        for (std::size_t k = 0; k < count; ++k) {
            const std::vector<double> fk = item(f, k);
            std::vector<double> expected(fk);
            rotation.apply(fk, expected);
            EXPECT_LE(test::distance(item(shared, k), expected), 3e-7 * test::norm(fk));
            const std::vector<double> qk = item(q, k);
            Rotation(order, glm::dquat(qk[3], qk[0], qk[1], qk[2])).apply(fk, expected);
            EXPECT_LE(test::distance(item(own, k), expected), (order <= 6 ? 3e-7 : 5e-7) * test::norm(fk))
                << order << ' ' << k;
        }
    }
}

TEST_P(Batches, RotationAboutZ) {
    for (int order = 1; order <= max_order; ++order) {
        const BatchBuffer f = coefficients(order);
        BatchBuffer cos_sin(2, count), shared(f.rows(), count), own(f.rows(), count);
        std::vector<double> angles;
        for (std::size_t k = 0; k < count; ++k) {
            angles.push_back(random.uniform(-3.2, 3.2));
            cos_sin.row(0)[k] = static_cast<float>(std::cos(angles[k]));
            cos_sin.row(1)[k] = static_cast<float>(std::sin(angles[k]));
        }
        rotate_z(order, 0.7, f, shared);
        rotate_z(order, cos_sin.view(), f.view(), own.view());
        for (std::size_t k = 0; k < count; ++k) {
            const std::vector<double> fk = item(f, k);
            std::vector<double> expected(fk);
            rotate_z(order, 0.7, fk, expected);
            EXPECT_LE(test::distance(item(shared, k), expected), 2e-7 * test::norm(fk));
            rotate_z(order, angles[k], fk, expected);
            EXPECT_LE(test::distance(item(own, k), expected), 6e-7 * test::norm(fk));
        }
    }
}

TEST_P(Batches, Products) {
    for (int order = 1; order <= max_order; ++order) {
        const BatchBuffer f = coefficients(order), g = coefficients(order);
        BatchBuffer h(f.rows(), count);
        product(order, f.view(), g.view(), h.view());
        for (std::size_t k = 0; k < count; ++k) {
            const std::vector<double> fk = item(f, k), gk = item(g, k);
            std::vector<double> expected(fk.size());
            product(order, fk, gk, expected);
            for (std::size_t i = 0; i < fk.size(); ++i) {
                EXPECT_NEAR(static_cast<double>(h.row(i)[k]), expected[i], 5e-8 * test::norm(fk) * test::norm(gk))
                    << order;
            }
        }
    }
}

TEST_P(Batches, TripleProductsAndProductMatrices) {
    for (int order = 1; order <= max_order; ++order) {
        const BatchBuffer f = coefficients(order), g = coefficients(order), h = coefficients(order);
        BatchBuffer triple(1, count);
        triple_product(order, f, g, h, triple);
        for (std::size_t k = 0; k < count; ++k) {
            const std::vector<double> fk = item(f, k), gk = item(g, k), hk = item(h, k);
            EXPECT_NEAR(static_cast<double>(triple.row(0)[k]), triple_product(order, fk, gk, hk),
                        1e-7 * test::norm(fk) * test::norm(gk) * test::norm(hk))
                << order;
        }
        if (order > 6) {
            continue; // 4096 rows
        }
        const std::size_t n = f.rows();
        BatchBuffer matrix(n * n, count);
        product_matrix(order, f, matrix);
        std::vector<double> expected(n * n);
        for (std::size_t k = 0; k < count; k += 10) {
            const std::vector<double> fk = item(f, k);
            product_matrix(order, fk, expected);
            for (std::size_t i = 0; i < n * n; ++i) {
                EXPECT_NEAR(static_cast<double>(matrix.row(i)[k]), expected[i], 2e-7 * test::norm(fk)) << order;
            }
        }
    }
}

TEST_P(Batches, ProjectionOfWeightedSamples) {
    // Lengths about the kernel's tiles; two, three and four channels.
    for (const std::size_t samples : {std::size_t{1}, std::size_t{100}, std::size_t{128}, std::size_t{1017}}) {
        for (int order = 1; order <= max_order; ++order) {
            const auto n = static_cast<std::size_t>(coefficient_count(order));
            BatchBuffer d(3, samples), values(4, samples);
            std::vector<glm::dvec3> directions;
            std::vector<float> weights;
            std::vector<double> double_weights;
            for (std::size_t k = 0; k < samples; ++k) {
                const glm::vec3 direction_k(random.direction());
                directions.emplace_back(direction_k);
                weights.push_back(static_cast<float>(random.uniform(0.0, 2.0)));
                double_weights.push_back(static_cast<double>(weights.back()));
                for (int i = 0; i < 3; ++i) {
                    d.row(static_cast<std::size_t>(i))[k] = direction_k[i];
                }
                for (std::size_t c = 0; c < 4; ++c) {
                    values.row(c)[k] = static_cast<float>(random.normal());
                }
            }
            for (std::size_t c = 0; c < 4 && samples % 16 != 0; ++c) {
                values.row(c)[samples] = std::numeric_limits<float>::quiet_NaN(); // padding is not read
            }
            for (const int channels : {1, 3, 4}) {
                std::vector<double> out(static_cast<std::size_t>(channels) * n);
                project_samples(order, d, values, channels, weights, out);
                for (std::size_t c = 0; c < static_cast<std::size_t>(channels); ++c) {
                    std::vector<double> channel, expected(n);
                    double total = 0.0;
                    for (std::size_t k = 0; k < samples; ++k) {
                        channel.push_back(static_cast<double>(values.row(c)[k]));
                        total += std::abs(channel[k] * double_weights[k]);
                    }
                    project_samples(order, directions, channel, double_weights, expected);
                    for (std::size_t i = 0; i < n; ++i) {
                        EXPECT_NEAR(out[c * n + i], expected[i], (order <= 6 ? 3e-7 : 2e-6) * total)
                            << order << ' ' << i;
                    }
                }
            }
        }
    }
}

TEST_P(Batches, ScalingOfBandsAndInPlaceUse) {
    const std::vector<float> factors{1.0F, 0.5F, 0.25F, 0.0F};
    BatchBuffer f = coefficients(4);
    const BatchBuffer before = [&] {
        BatchBuffer copy(f.rows(), count);
        scale_bands(4, std::vector<float>(4, 1.0F), f, copy);
        return copy;
    }();
    scale_bands(4, factors, f, f);
    for (int l = 0; l < 4; ++l) {
        for (int m = -l; m <= l; ++m) {
            const auto i = static_cast<std::size_t>(index(l, m));
            for (std::size_t k = 0; k < count; ++k) {
                EXPECT_EQ(f.row(i)[k], before.row(i)[k] * factors[static_cast<std::size_t>(l)]);
            }
        }
    }
    BatchBuffer turned(f.rows(), count);
    const Rotation rotation(4, random.rotation());
    rotate(rotation, before, turned);
    BatchBuffer again(f.rows(), count);
    scale_bands(4, std::vector<float>(4, 1.0F), before, again);
    rotate(rotation, again, again);
    for (std::size_t i = 0; i < f.rows(); ++i) {
        for (std::size_t k = 0; k < count; ++k) {
            EXPECT_EQ(turned.row(i)[k], again.row(i)[k]);
        }
    }
}

TEST_P(Batches, NanStaysWithItsItem) {
    const int order = 5;
    BatchBuffer f = coefficients(order);
    const BatchBuffer g = coefficients(order);
    BatchBuffer clean(f.rows(), count), spoilt(f.rows(), count);
    product(order, f.view(), g.view(), clean.view());
    f.row(3)[50] = std::numeric_limits<float>::quiet_NaN();
    product(order, f.view(), g.view(), spoilt.view());
    for (std::size_t i = 0; i < f.rows(); ++i) {
        for (std::size_t k = 0; k < count; ++k) {
            if (k != 50) {
                EXPECT_EQ(clean.row(i)[k], spoilt.row(i)[k]);
            }
        }
    }
    EXPECT_TRUE(std::isnan(spoilt.row(3)[50]));
}

TEST_P(Batches, BlendIsTheWeightedSumOfCorners) {
    constexpr std::size_t stride = 32, probes = 20, receivers = 13;
    std::vector<float> grid(stride * probes), out(stride * receivers), weights;
    for (float& v : grid) {
        v = static_cast<float>(random.normal());
    }
    std::vector<std::uint32_t> corners;
    for (std::size_t i = 0; i < 8 * receivers; ++i) {
        corners.push_back(static_cast<std::uint32_t>(random.uniform(0.0, probes - 0.001)));
        weights.push_back(static_cast<float>(random.uniform(0.0, 0.25)));
    }
    blend(27, grid.data(), stride, corners, weights, out.data());
    for (std::size_t r = 0; r < receivers; ++r) {
        for (std::size_t i = 0; i < 27; ++i) {
            double sum = 0.0;
            for (std::size_t c = 0; c < 8; ++c) {
                sum += static_cast<double>(weights[8 * r + c]) *
                       static_cast<double>(grid[corners[8 * r + c] * stride + i]);
            }
            EXPECT_NEAR(static_cast<double>(out[r * stride + i]), sum, 1e-6);
        }
    }
}

INSTANTIATE_TEST_SUITE_P(AllTargets, Batches,
                         ::testing::Values(BatchTarget::scalar, BatchTarget::sse4, BatchTarget::avx2,
                                           BatchTarget::avx512));

} // namespace
} // namespace alpenglow::sh
