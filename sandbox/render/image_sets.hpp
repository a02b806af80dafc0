// Descriptor sets of one image each, with the sampler that reads them.
#pragma once

#include <cstdint>
#include <vector>

#include <alpenglow/vulkan/image.hpp>
#include <alpenglow/vulkan/pipeline.hpp>

namespace alpenglow::sandbox {

class ImageSets {
public:
    // `layout`: Passes::image_set.
    static Result<ImageSets> create(const vulkan::Device& device, VkDescriptorSetLayout layout, std::uint32_t count,
                                    const vulkan::SamplerOptions& options = {});

    [[nodiscard]] VkDescriptorSet operator[](std::size_t i) const { return sets_[i]; }
    // No frame in flight uses the set.
    void show(const vulkan::Device& device, std::size_t i, const vulkan::Image& image) const;

private:
    vulkan::DescriptorPool pool_;
    vulkan::Sampler sampler_;
    std::vector<VkDescriptorSet> sets_;
};

} // namespace alpenglow::sandbox
