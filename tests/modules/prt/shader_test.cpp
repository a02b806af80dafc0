// shaders/alpenglow/transfer.glsl, compiled as C++: the same arithmetic as the CPU's, from the same tables.
#include "helpers.hpp"

#include <alpenglow/prt/compress.hpp>
#include <alpenglow/prt/evaluate.hpp>
#include <alpenglow/prt/shader_tables.hpp>

#include <gtest/gtest.h>

#include <cstring>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/packing.hpp>
#include <glm/vec2.hpp>

namespace alpenglow::prt {
namespace {

std::span<const std::byte> words;
std::vector<glm::vec3> shader_values;

#define ALPENGLOW_AS_CPP(NAME)                                                                                         \
    namespace NAME {                                                                                                   \
    using glm::uintBitsToFloat, glm::unpackHalf2x16, glm::vec2, glm::vec3, glm::uint;                                  \
    inline uint transfer_word(uint index) {                                                                            \
        uint word = 0;                                                                                                 \
        std::memcpy(&word, words.data() + 4 * std::size_t{index}, 4);                                                  \
        return word;                                                                                                   \
    }                                                                                                                  \
    inline vec3 transfer_light(uint i) {                                                                               \
        return shader_values[i];                                                                                       \
    }                                                                                                                  \
    }

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wunused-function"
ALPENGLOW_AS_CPP(as_f32)
#define ALPENGLOW_TRANSFER_ENCODING 0
namespace as_f32 {
#include <alpenglow/transfer.glsl>
}
#undef ALPENGLOW_TRANSFER_GLSL
#undef ALPENGLOW_TRANSFER_ENCODING
ALPENGLOW_AS_CPP(as_f16)
#define ALPENGLOW_TRANSFER_ENCODING 1
namespace as_f16 {
#include <alpenglow/transfer.glsl>
}
#undef ALPENGLOW_TRANSFER_GLSL
#undef ALPENGLOW_TRANSFER_ENCODING
ALPENGLOW_AS_CPP(as_s8)
#define ALPENGLOW_TRANSFER_ENCODING 2
namespace as_s8 {
#include <alpenglow/transfer.glsl>
}
#undef ALPENGLOW_TRANSFER_GLSL
#undef ALPENGLOW_TRANSFER_ENCODING
ALPENGLOW_AS_CPP(as_cpca)
#define ALPENGLOW_TRANSFER_ENCODING 3
namespace as_cpca {
#include <alpenglow/transfer.glsl>
}
#pragma GCC diagnostic pop

constexpr std::size_t count = 75;

TEST(TransferShader, VectorsAgreeWithTheCpu) {
    for (const Encoding encoding : {Encoding::f32, Encoding::f16, Encoding::s8}) {
        for (const int channels : {1, 3}) {
            for (const int light_order : {3, 5}) {
                const TransferField field = test::random_field(5, 0, channels, count, 3);
                const Result<TransferTable> table = encode(field, encoding);
                ASSERT_TRUE(table);
                const std::vector<glm::vec3> light = test::random_light(light_order, 2);
                std::vector<glm::vec3> cpu(count);
                evaluate(*table, light, cpu);
                words = table->blocks;
                shader_values.assign(25, glm::vec3(0.0F));
                const auto lit = static_cast<unsigned>(shader_light(*table, light, shader_values));
                EXPECT_EQ(lit, static_cast<unsigned>(light_order * light_order));
                for (unsigned p = 0; p < count; ++p) {
                    const auto c = static_cast<unsigned>(channels);
                    const glm::vec3 gpu = encoding == Encoding::f32   ? as_f32::alpenglow_transfer(p, c, 25, lit)
                                          : encoding == Encoding::f16 ? as_f16::alpenglow_transfer(p, c, 25, lit)
                                                                      : as_s8::alpenglow_transfer(p, c, 25, lit);
                    EXPECT_LT(glm::length(gpu - cpu[p]), 1e-5F);
                }
            }
        }
    }
}

TEST(TransferShader, GlossyAgreesWithTheCpu) {
    const TransferField field = test::random_field(3, 5, 1, count, 3);
    const Result<TransferTable> table = encode(field, Encoding::f16);
    ASSERT_TRUE(table);
    const std::vector<glm::vec3> light = test::random_light(3, 2);
    const std::vector<float> kernel{1.0F, 0.7F, 0.5F, 0.3F, 0.1F};
    const std::vector<glm::vec3> directions(count, glm::vec3(0.6F, 0.0F, 0.8F));
    std::vector<glm::vec3> cpu(count);
    evaluate_glossy(*table, light, kernel, directions, cpu);
    words = table->blocks;
    shader_values = light;
    float weights[36] = {};
    std::array<float, 25> y{};
    sh::evaluate_basis(5, directions[0], y);
    for (unsigned i = 0; i < 25; ++i) {
        weights[i] = y[i] * kernel[static_cast<std::size_t>(std::sqrt(static_cast<double>(i)))];
    }
    for (unsigned p = 0; p < count; ++p) {
        EXPECT_LT(glm::length(as_f16::alpenglow_transfer_glossy(p, 25, 1, 9, 9, weights) - cpu[p]), 2e-5F);
    }
}

TEST(TransferShader, CpcaAgreesWithTheCpu) {
    const TransferField field = test::random_field(4, 0, 3, count, 3);
    const Result<TransferTable> table = encode_cpca(field, {.clusters = 3, .components = 9});
    ASSERT_TRUE(table);
    const std::vector<glm::vec3> light = test::random_light(4, 2);
    std::vector<glm::vec3> cpu(count);
    evaluate(*table, light, cpu);
    words = table->blocks;
    shader_values.resize(table->info.clusters * (std::size_t{table->info.components} + 1));
    light_clusters(*table, light, shader_values);
    const std::vector<glm::uvec2> slots = vertex_slots(*table);
    for (unsigned p = 0; p < count; ++p) {
        const glm::vec3 gpu = as_cpca::alpenglow_transfer_cpca(slots[p].x, slots[p].y, table->info.components);
        EXPECT_LT(glm::length(gpu - cpu[p]), 1e-5F);
    }
}

} // namespace
} // namespace alpenglow::prt
