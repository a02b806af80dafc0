#include "gpu_test.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <random>

#include <alpenglow/vulkan/buffer.hpp>
#include <alpenglow/vulkan/image.hpp>
#include <alpenglow/vulkan/mip_chain.hpp>
#include <alpenglow/vulkan/transfer.hpp>

namespace alpenglow::vulkan {
namespace {

using TransferTest = GpuTest;

std::vector<std::byte> random_bytes(std::size_t count) {
    std::mt19937 generator(7);
    std::vector<std::byte> bytes(count);
    std::generate(bytes.begin(), bytes.end(), [&] { return static_cast<std::byte>(generator() & 0xFFU); });
    return bytes;
}

TEST_F(TransferTest, BufferRoundTripInEveryPlacement) {
    const std::vector<std::byte> bytes = random_bytes(10001);
    for (const Placement placement : {Placement::device, Placement::upload, Placement::readback}) {
        const Result<Buffer> buffer =
            Buffer::create(*device, bytes.size(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT, placement);
        ASSERT_TRUE(buffer) << buffer.error().message();
        ASSERT_TRUE(upload_buffer(*device, *buffer, bytes));
        const Result<std::vector<std::byte>> read = read_buffer(*device, *buffer);
        ASSERT_TRUE(read);
        EXPECT_EQ(*read, bytes);
    }
}

TEST_F(TransferTest, PartOfABufferLeavesTheRest) {
    std::vector<std::byte> bytes = random_bytes(256);
    const Result<Buffer> buffer =
        Buffer::create(*device, bytes.size(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT, Placement::device);
    ASSERT_TRUE(buffer);
    ASSERT_TRUE(upload_buffer(*device, *buffer, bytes));
    const std::vector<std::byte> part(32, std::byte{0xAB});
    ASSERT_TRUE(upload_buffer(*device, *buffer, part, 100));
    std::copy(part.begin(), part.end(), bytes.begin() + 100);
    const Result<std::vector<std::byte>> read = read_buffer(*device, *buffer);
    ASSERT_TRUE(read);
    EXPECT_EQ(*read, bytes);
}

TEST_F(TransferTest, ImageRoundTripOfAnOddSize) {
    const VkExtent2D extent{33, 17};
    const std::vector<std::byte> bytes = random_bytes(33 * 17 * 4);
    const Result<Image> image = Image::create(
        *device, {VK_FORMAT_R8G8B8A8_UNORM, extent,
                  VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT, 1});
    ASSERT_TRUE(image) << image.error().message();
    ASSERT_TRUE(upload_image(*device, *image, bytes));
    for (int i = 0; i < 2; ++i) { // twice: reading must leave the layout as it was
        const Result<std::vector<std::byte>> read =
            read_image(*device, *image, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
        ASSERT_TRUE(read);
        EXPECT_EQ(*read, bytes);
    }
}

TEST_F(TransferTest, ImageWithMipLevels) {
    const VkExtent2D extent{64, 16};
    const Result<Image> image = Image::create(
        *device, {VK_FORMAT_R8G8B8A8_UNORM, extent, VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT, 7});
    ASSERT_TRUE(image);
    EXPECT_TRUE(upload_image(*device, *image, make_mip_chain(random_bytes(64 * 16 * 4), extent)));
}

// Every level has the image's mean within half a step plus what rounding its texels may add up to, also for sizes that
// do not halve.
TEST(MipChainTest, KeepsTheMean) {
    for (const VkExtent2D extent : {VkExtent2D{64, 64}, VkExtent2D{33, 17}, VkExtent2D{1, 9}, VkExtent2D{1, 1}}) {
        const std::vector<std::byte> texels = random_bytes(std::size_t{extent.width} * extent.height * 4);
        const std::vector<std::byte> chain = make_mip_chain(texels, extent);
        std::size_t offset = 0;
        std::array<double, 4> mean_of_all{};
        for (std::uint32_t level = 0; level < mip_level_count(extent); ++level) {
            const VkExtent2D size = mip_extent(extent, level);
            const std::size_t count = std::size_t{size.width} * size.height;
            for (std::size_t channel = 0; channel < 4; ++channel) {
                double sum = 0.0;
                for (std::size_t i = 0; i < count; ++i) {
                    sum += std::to_integer<int>(chain[offset + 4 * i + channel]);
                }
                const double mean = sum / static_cast<double>(count);
                if (level == 0) {
                    mean_of_all[channel] = mean;
                }
                EXPECT_NEAR(mean, mean_of_all[channel], 0.501);
            }
            offset += 4 * count;
        }
        EXPECT_EQ(offset, chain.size());
        EXPECT_TRUE(std::equal(texels.begin(), texels.end(), chain.begin()));
    }
}

TEST(MipChainTest, ConstantStaysConstant) {
    const std::vector<std::byte> texels(std::size_t{4} * 45 * 7, std::byte{127});
    for (const std::byte b : make_mip_chain(texels, {45, 7})) {
        ASSERT_EQ(b, std::byte{127});
    }
}

} // namespace
} // namespace alpenglow::vulkan
