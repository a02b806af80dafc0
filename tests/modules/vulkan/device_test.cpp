#include "gpu_test.hpp"

#include <array>
#include <cctype>
#include <cstring>

#include <alpenglow/vulkan/buffer.hpp>
#include <alpenglow/vulkan/frame_ring.hpp>
#include <alpenglow/vulkan/image.hpp>
#include <alpenglow/vulkan/transfer.hpp>

namespace alpenglow::vulkan {
namespace {

using DeviceTest = GpuTest;

TEST_F(DeviceTest, HasAQueueAndVulkan11) {
    EXPECT_NE(device->queue(), VK_NULL_HANDLE);
    EXPECT_GE(device->info().api_version, VK_API_VERSION_1_1);
    EXPECT_FALSE(device->info().name.empty());
    EXPECT_TRUE(device->wait_idle());
}

TEST_F(DeviceTest, PrefersAGpuToTheCpu) {
    for (const DeviceInfo& info : list_devices(*instance)) {
        if (!info.is_cpu && info.api_version >= VK_API_VERSION_1_1) {
            EXPECT_FALSE(device->info().is_cpu) << info.name << " was there";
        }
    }
}

TEST_F(DeviceTest, IsChosenByAPartOfItsNameWhateverTheCase) {
    std::string part = device->info().name.substr(0, 4);
    for (char& c : part) {
        c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    }
    const Result<Device> chosen = Device::create(*instance, {.name = part});
    ASSERT_TRUE(chosen) << chosen.error().message();
    EXPECT_EQ(chosen->info().name, device->info().name);
}

TEST_F(DeviceTest, UnknownNameSaysNoUsableDeviceAndListsWhatIsThere) {
    const Result<Device> chosen = Device::create(*instance, {.name = "abacus"});
    ASSERT_FALSE(chosen);
    EXPECT_NE(chosen.error().message().find("no usable device named \"abacus\""), std::string::npos);
    EXPECT_NE(chosen.error().message().find(device->info().name), std::string::npos);
}

TEST(InstanceTest, UnknownExtensionIsAnError) {
    const std::array<const char*, 1> extensions{"VK_EXT_of_another_world"};
    const Result<Instance> made = Instance::create({.extensions = extensions});
    ASSERT_FALSE(made);
    EXPECT_NE(made.error().message().find("VK_ERROR_EXTENSION_NOT_PRESENT"), std::string::npos);
}

TEST_F(DeviceTest, ImageOfBadSizeNamesTheSize) {
    for (const VkExtent2D extent : {VkExtent2D{0, 0}, VkExtent2D{100000, 100000}, VkExtent2D{16, 0}}) {
        const Result<Image> image =
            Image::create(*device, {VK_FORMAT_R8G8B8A8_UNORM, extent, VK_IMAGE_USAGE_SAMPLED_BIT, 1});
        ASSERT_FALSE(image);
        EXPECT_NE(image.error().what.find(std::to_string(extent.width) + "x" + std::to_string(extent.height)),
                  std::string::npos);
    }
}

// Proof that the log hears the layer: two writes to one buffer without a barrier are a hazard that only
// synchronization validation sees.
TEST(InstanceTest, SynchronizationValidationIsHeard) {
    const Result<Instance> instance = Instance::create({.validation = true});
    ASSERT_TRUE(instance) << instance.error().message();
    const Result<Device> device = Device::create(*instance);
    ASSERT_TRUE(device) << device.error().message();
    const Result<Buffer> buffer = Buffer::create(*device, 64, 0, Placement::device);
    ASSERT_TRUE(buffer);
    ASSERT_EQ(instance->messages().count(), 0U);
    ASSERT_TRUE(submit_and_wait(*device, [&](VkCommandBuffer commands) {
        vkCmdFillBuffer(commands, buffer->get(), 0, 64, 1);
        vkCmdFillBuffer(commands, buffer->get(), 0, 64, 2);
    }));
    EXPECT_GT(instance->messages().count(), 0U);
}

TEST_F(DeviceTest, FrameRingComesRoundAndSignalsItsFences) {
    Result<FrameRing> ring = FrameRing::create(*device, 2);
    ASSERT_TRUE(ring);
    const Result<Buffer> buffer = Buffer::create(*device, 4 * sizeof(std::uint32_t), 0, Placement::readback);
    ASSERT_TRUE(buffer);
    for (std::uint32_t i = 0; i < 4; ++i) {
        const Result<FrameRing::Frame> frame = ring->begin();
        ASSERT_TRUE(frame) << frame.error().message();
        EXPECT_EQ(frame->slot, i % 2);
        vkCmdFillBuffer(frame->commands, buffer->get(), i * sizeof(std::uint32_t), sizeof(std::uint32_t), i + 7);
        record_host_read_barrier(frame->commands);
        ASSERT_TRUE(ring->submit(*frame));
    }
    ASSERT_TRUE(ring->wait(0));
    ASSERT_TRUE(ring->wait(1));
    for (std::uint32_t i = 0; i < 4; ++i) {
        std::uint32_t value = 0;
        std::memcpy(&value, buffer->mapped().data() + i * sizeof value, sizeof value);
        EXPECT_EQ(value, i + 7);
    }
}

} // namespace
} // namespace alpenglow::vulkan
