#include "helpers.hpp"

#include <alpenglow/prt/bake.hpp>
#include <alpenglow/prt/compress.hpp>
#include <alpenglow/prt/evaluate.hpp>
#include <alpenglow/prt/shapes.hpp>
#include <alpenglow/prt/transfer_file.hpp>

#include <gtest/gtest.h>

#include <unistd.h>

namespace alpenglow::prt {
namespace {

TransferField small_figure(bool colour) {
    Mesh mesh = figure(3000);
    BakeSettings settings;
    settings.rays = 1024;
    settings.gather_rays = 64;
    settings.colour = colour;
    settings.transport = colour ? Transport::interreflected : Transport::shadowed;
    return bake(mesh, settings)->field;
}

TEST(Cpca, ErrorFallsWithComponentsAndIsWhatItSays) {
    const TransferField field = small_figure(false);
    double last = 1.0;
    for (const std::size_t components : {1U, 4U, 8U, 16U, 25U}) {
        const Result<TransferTable> table = encode_cpca(field, {.clusters = 12, .components = components});
        ASSERT_TRUE(table);
        const double error = relative_rms(decode(*table), field);
        EXPECT_NEAR(error, static_cast<double>(table->info.encoding_rms), 1e-6);
        EXPECT_LT(error, last);
        last = error;
    }
    EXPECT_LT(last, 0.005); // all components: what 8-bit weights leave, a half step of 1/127 each
}

TEST(Cpca, OneClusterOfOnePlaneIsExact) {
    // Points on a plane through the space of vectors: two components hold them.
    TransferField field = test::random_field(3, 0, 1, 500, 1);
    for (std::size_t p = 0; p < field.count; ++p) {
        const float a = field.point(p)[0];
        const float b = field.point(p)[1];
        for (std::size_t k = 0; k < 9; ++k) {
            const float t = static_cast<float>(k);
            field.point(p)[k] = 1.0F + a * std::sin(t) + b * std::cos(2.0F * t);
        }
    }
    const Result<TransferTable> table = encode_cpca(field, {.clusters = 1, .components = 2});
    ASSERT_TRUE(table);
    EXPECT_LT(table->info.encoding_rms, 0.5F / 127.0F); // half a step of the weights
}

TEST(Cpca, EvaluationAndFileAgreeWithTheReference) {
    for (const bool colour : {false, true}) {
        const TransferField field = small_figure(colour);
        const Result<TransferTable> table = encode_cpca(field, {.clusters = 7, .components = 6});
        ASSERT_TRUE(table);
        const std::filesystem::path path =
            std::filesystem::temp_directory_path() / ("alpenglow_cpca_" + std::to_string(getpid()));
        ASSERT_TRUE(save_transfer(*table, path));
        const Result<TransferTable> loaded = load_transfer(path);
        std::filesystem::remove(path);
        ASSERT_TRUE(loaded) << loaded.error().message();
        for (const int order : {3, 5}) {
            const std::vector<glm::vec3> light = test::random_light(order, 9);
            std::vector<glm::vec3> fast(field.count, glm::vec3(77.0F));
            std::vector<glm::vec3> slow(field.count);
            evaluate(*loaded, light, fast);
            evaluate_scalar(*table, light, slow);
            for (std::size_t i = 0; i < field.count; ++i) {
                for (int c = 0; c < 3; ++c) {
                    EXPECT_NEAR(fast[i][c], slow[i][c], 2e-5F);
                }
            }
        }
    }
}

TEST(Cpca, WithinAnErrorAndSameForAnyThreads) {
    const TransferField field = small_figure(false);
    const Result<TransferTable> table = encode_cpca_within(field, 0.02);
    ASSERT_TRUE(table) << table.error().message();
    EXPECT_LE(table->info.encoding_rms, 0.02F);
    const Result<TransferTable> one = encode_cpca_within(field, 0.02, 24, 1);
    ASSERT_TRUE(one);
    EXPECT_TRUE(std::equal(one->blocks.begin(), one->blocks.end(), table->blocks.begin(), table->blocks.end()));
    EXPECT_FALSE(encode_cpca_within(field, 1e-9));
    EXPECT_FALSE(encode_cpca(field, {.clusters = 0, .components = 1}));
    EXPECT_FALSE(encode_cpca(field, {.clusters = 1, .components = 0}));
}

} // namespace
} // namespace alpenglow::prt
