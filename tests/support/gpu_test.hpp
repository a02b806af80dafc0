// A validated device for a test; the validation layer must have stayed silent when it goes.
#pragma once

#include <memory>

#include <gtest/gtest.h>

#include <alpenglow/vulkan/device.hpp>
#include <alpenglow/vulkan/instance.hpp>

#ifdef __SANITIZE_ADDRESS__
// Drivers and layers leak, and are gone from memory when leaks are looked for, so that no suppression can name them.
extern "C" __attribute__((used)) inline const char* __asan_default_options() {
    return "detect_leaks=0";
}
#endif

namespace alpenglow::vulkan {

class GpuTest : public testing::Test {
protected:
    void SetUp() override {
        Result<Instance> made = Instance::create({.validation = true});
        ASSERT_TRUE(made) << made.error().message();
        instance = std::make_unique<Instance>(std::move(made).value());
        Result<Device> chosen = Device::create(*instance);
        ASSERT_TRUE(chosen) << chosen.error().message();
        device = std::make_unique<Device>(std::move(chosen).value());
    }

    void TearDown() override {
        device.reset();
        if (instance) {
            EXPECT_EQ(instance->messages().count(), 0U);
            for (const std::string& message : instance->messages().messages()) {
                ADD_FAILURE() << message;
            }
        }
    }

    std::unique_ptr<Instance> instance;
    std::unique_ptr<Device> device;
};

} // namespace alpenglow::vulkan
