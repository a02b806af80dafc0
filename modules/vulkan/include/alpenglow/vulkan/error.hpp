// Vulkan's result codes as the project's errors.
#pragma once

#include <string>

#include <vulkan/vulkan.h>

#include <alpenglow/core/result.hpp>

namespace alpenglow::vulkan {

// The name of a result code, such as "VK_ERROR_DEVICE_LOST".
const char* result_name(VkResult result);

// "CALL failed with VK_ERROR_...".
Error call_error(const char* call, VkResult result);

} // namespace alpenglow::vulkan
