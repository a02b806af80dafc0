#include "sandbox/render/image_sets.hpp"

#include <utility>

namespace alpenglow::sandbox {

Result<ImageSets> ImageSets::create(const vulkan::Device& device, VkDescriptorSetLayout layout, std::uint32_t count,
                                    const vulkan::SamplerOptions& options) {
    const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, count};
    Result<vulkan::DescriptorPool> pool = vulkan::create_descriptor_pool(device, count, {&size, 1});
    Result<vulkan::Sampler> sampler = vulkan::create_sampler(device, options);
    if (!pool || !sampler) {
        return !pool ? pool.error() : sampler.error();
    }
    ImageSets made;
    made.pool_ = std::move(pool).value();
    made.sampler_ = std::move(sampler).value();
    for (std::uint32_t i = 0; i < count; ++i) {
        Result<VkDescriptorSet> set = vulkan::allocate_descriptor_set(device, made.pool_.get(), layout);
        if (!set) {
            return set.error();
        }
        made.sets_.push_back(*set);
    }
    return made;
}

void ImageSets::show(const vulkan::Device& device, std::size_t i, const vulkan::Image& image) const {
    vulkan::write_image_descriptor(device, sets_[i], 0, image.view(), sampler_.get());
}

} // namespace alpenglow::sandbox
