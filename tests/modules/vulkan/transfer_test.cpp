#include "gpu.hpp"

#include <algorithm>
#include <cstdint>
#include <random>

#include <alpenglow/vulkan/buffer.hpp>
#include <alpenglow/vulkan/image.hpp>
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

TEST_F(TransferTest, MipChainIsBuiltWithoutHazards) {
    const Result<Image> image = Image::create(
        *device, {VK_FORMAT_R8G8B8A8_UNORM,
                  {64, 16},
                  VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                  7});
    ASSERT_TRUE(image);
    EXPECT_TRUE(upload_image(*device, *image, random_bytes(64 * 16 * 4)));
}

} // namespace
} // namespace alpenglow::vulkan
