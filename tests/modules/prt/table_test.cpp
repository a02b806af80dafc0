#include "helpers.hpp"

#include <alpenglow/prt/evaluate.hpp>
#include <alpenglow/prt/transfer_table.hpp>

#include <gtest/gtest.h>

#include <limits>

namespace alpenglow::prt {
namespace {

using test::random_field;
using test::random_light;

// Largest difference between two results, relative to the largest value.
double difference(std::span<const glm::vec3> a, std::span<const glm::vec3> b) {
    double worst = 0.0;
    double top = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        for (int c = 0; c < 3; ++c) {
            worst = std::max(worst, std::abs(static_cast<double>(a[i][c]) - static_cast<double>(b[i][c])));
            top = std::max(top, std::abs(static_cast<double>(b[i][c])));
        }
    }
    return worst / top;
}

TEST(TransferTable, DecodesToWhatItsEncodingHolds) {
    const TransferField field = random_field(5, 0, 3, 77, 1);
    const std::pair<Encoding, double> expected[] = {
        {Encoding::f32, 0.0}, {Encoding::f16, 3e-4}, {Encoding::s8, 1.2e-2}};
    for (const auto& [encoding, error] : expected) {
        const Result<TransferTable> table = encode(field, encoding);
        ASSERT_TRUE(table);
        const TransferField back = decode(*table);
        EXPECT_EQ(back.count, field.count);
        EXPECT_LE(relative_rms(back, field), error);
        EXPECT_NEAR(table->info.encoding_rms, relative_rms(back, field), 1e-6);
    }
}

TEST(TransferTable, RefusesValuesThatAreNotFinite) {
    TransferField field = random_field(3, 0, 1, 10, 1);
    field.values[4 * 9 + 2] = std::numeric_limits<float>::infinity();
    const Result<TransferTable> table = encode(field, Encoding::f16);
    ASSERT_FALSE(table);
    EXPECT_NE(table.error().message().find("point 4"), std::string::npos);
}

TEST(Evaluate, SimdIsTheScalarReference) {
    for (const Encoding encoding : {Encoding::f32, Encoding::f16, Encoding::s8}) {
        for (const int channels : {1, 3}) {
            for (const int order : {1, 2, 3, 4, 5, 6}) {
                for (const std::size_t count : {1U, 15U, 16U, 17U, 63U, 64U, 65U, 200U}) {
                    const TransferField field = random_field(order, 0, channels, count, 7);
                    const Result<TransferTable> table = encode(field, encoding);
                    ASSERT_TRUE(table);
                    const std::vector<glm::vec3> light = random_light(order, 3);
                    std::vector<glm::vec3> fast(count, glm::vec3(99.0F));
                    std::vector<glm::vec3> slow(count);
                    evaluate(*table, light, fast);
                    evaluate_scalar(*table, light, slow);
                    EXPECT_LT(difference(fast, slow), 2e-6);
                }
            }
        }
    }
}

TEST(Evaluate, BlockRangesWriteTheirPointsAlone) {
    const TransferField field = random_field(5, 0, 1, 100, 2);
    const Result<TransferTable> table = encode(field, Encoding::f16);
    ASSERT_TRUE(table);
    const std::vector<glm::vec3> light = random_light(5, 3);
    std::vector<glm::vec3> whole(100);
    std::vector<glm::vec3> parts(100, glm::vec3(-7.0F));
    evaluate(*table, light, whole);
    evaluate(*table, light, parts, {2, 4});
    for (std::size_t i = 0; i < 100; ++i) {
        EXPECT_EQ(parts[i], i >= 32 && i < 64 ? whole[i] : glm::vec3(-7.0F));
    }
}

TEST(Evaluate, OrdersMayDiffer) {
    const TransferField field = random_field(5, 0, 3, 40, 2);
    const Result<TransferTable> table = encode(field, Encoding::f32);
    ASSERT_TRUE(table);
    std::vector<glm::vec3> low = random_light(3, 5);
    std::vector<glm::vec3> padded = low;
    padded.resize(25, glm::vec3(0.0F));
    std::vector<glm::vec3> a(40);
    std::vector<glm::vec3> b(40);
    evaluate(*table, low, a);
    evaluate(*table, padded, b);
    EXPECT_LT(difference(a, b), 1e-6);
    // More light bands than the table has: the rest is ignored.
    std::vector<glm::vec3> high = random_light(6, 5);
    std::vector<glm::vec3> cut(high.begin(), high.begin() + 25);
    evaluate(*table, high, a);
    evaluate(*table, cut, b);
    EXPECT_EQ(a, b);
}

TEST(Evaluate, MatrixRowsAndGlossyAgreeWithScalar) {
    for (const Encoding encoding : {Encoding::f32, Encoding::f16, Encoding::s8}) {
        for (const int channels : {1, 3}) {
            const std::pair<int, int> shapes[] = {{5, 5}, {3, 5}, {5, 3}, {2, 2}, {6, 6}}; // out, in
            for (const auto& [out_order, order] : shapes) {
                constexpr std::size_t count = 37;
                const TransferField field = random_field(order, out_order, channels, count, 11);
                const Result<TransferTable> table = encode(field, encoding);
                ASSERT_TRUE(table);
                const std::vector<glm::vec3> light = random_light(order, 4);
                std::vector<glm::vec3> directions;
                for (std::size_t i = 0; i < count; ++i) {
                    const float a = static_cast<float>(i);
                    directions.emplace_back(std::sin(a) * 0.6F, std::cos(a) * 0.6F, 0.8F);
                }
                const std::vector<float> kernel{1.0F, 0.8F, 0.6F, 0.3F, 0.2F, 0.1F};
                std::vector<glm::vec3> fast(count);
                std::vector<glm::vec3> slow(count);
                evaluate_glossy(*table, light, kernel, directions, fast);
                evaluate_glossy_scalar(*table, light, kernel, directions, slow);
                EXPECT_LT(difference(fast, slow), 4e-6);

                std::vector<glm::vec3> planes(count * table->info.rows);
                evaluate_matrix(*table, light, planes);
                const TransferField back = decode(*table);
                const auto n = static_cast<std::size_t>(order * order);
                double worst = 0.0;
                for (std::size_t p = 0; p < count; ++p) {
                    for (std::size_t row = 0; row < table->info.rows; ++row) {
                        const auto c = static_cast<std::size_t>(channels == 3 ? 1 : 0);
                        double sum = 0.0;
                        for (std::size_t i = 0; i < n; ++i) {
                            sum += static_cast<double>(
                                       back.point(p)[(row * static_cast<std::size_t>(channels) + c) * n + i]) *
                                   static_cast<double>(light[i].y);
                        }
                        worst = std::max(worst, std::abs(sum - static_cast<double>(planes[row * count + p].y)));
                    }
                }
                EXPECT_LT(worst, 2e-5);
            }
        }
    }
}

TEST(TransferTable, BandNormsBoundAnyChangeOfLight) {
    const TransferField field = random_field(5, 0, 3, 50, 9);
    const Result<TransferTable> table = encode(field, Encoding::f32);
    ASSERT_TRUE(table);
    for (unsigned seed = 0; seed < 50; ++seed) {
        const std::vector<glm::vec3> light = random_light(5, 100 + seed);
        std::vector<glm::vec3> out(50);
        evaluate(*table, light, out);
        double bound = 0.0;
        for (int l = 0; l < 5; ++l) {
            glm::dvec3 sum(0.0);
            for (int i = l * l; i < (l + 1) * (l + 1); ++i) {
                sum += glm::dvec3(light[static_cast<std::size_t>(i)] * light[static_cast<std::size_t>(i)]);
            }
            bound += static_cast<double>(table->info.band_norm[static_cast<std::size_t>(l)]) *
                     std::sqrt(std::max({sum.x, sum.y, sum.z}));
        }
        for (const glm::vec3& v : out) {
            EXPECT_LE(std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}), bound);
        }
    }
}

} // namespace
} // namespace alpenglow::prt
