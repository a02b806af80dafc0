// Small pictures of the scene for light probes: faces of a cube map, in radiance.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "sandbox/render/dynamic_buffer.hpp"
#include "sandbox/render/gpu_data.hpp"
#include "sandbox/render/layer.hpp"
#include "sandbox/render/visible_objects.hpp"

namespace alpenglow::sandbox {

inline constexpr int capture_edge = 32; // texels along a face: 16, supersampled by 2 (probes/capture.hpp)

struct MeshRange {
    std::uint32_t first_index = 0;
    std::uint32_t index_count = 0;
    std::int32_t vertex_offset = 0;
};

// What the renderer keeps on the device anyway. It outlives the captures.
struct SceneGeometry {
    VkBuffer terrain_vertices = VK_NULL_HANDLE;
    VkBuffer object_vertices = VK_NULL_HANDLE, object_indices = VK_NULL_HANDLE;
    std::vector<MeshRange> meshes;
    std::span<const gpu::Instance> instances; // one an object
    VisibleObjects objects;
    VkBuffer sky_indices = VK_NULL_HANDLE;
    std::uint32_t sky_index_count = 0;
};

// Terrain and objects are lit per vertex, whatever the quality of the frame; layers draw what they draw in `full`.
class SceneCapture {
public:
    static Result<std::unique_ptr<SceneCapture>>
    create(const vulkan::Device& device, const std::filesystem::path& shader_directory, SceneGeometry geometry);

    // See Renderer::capture(). No frame is in flight.
    Status render(const FrameData& frame, const glm::vec3& point_m, int face, std::span<glm::vec3> texels);

private:
    SceneCapture(const vulkan::Device& device, SceneGeometry geometry)
        : device_(device), geometry_(std::move(geometry)) {}
    Status create_passes(const std::filesystem::path& shader_directory);
    Status create_buffers();
    Status upload(const FrameData& view, DrawStats& stats);
    void record(VkCommandBuffer commands, const FrameData& view, DrawStats& stats);

    const vulkan::Device& device_;
    SceneGeometry geometry_;
    Passes passes_;
    std::vector<std::unique_ptr<Layer>> layers_;
    std::vector<Layer*> drawn_layers_;
    vulkan::RenderTarget target_;
    vulkan::DescriptorPool descriptors_;
    VkDescriptorSet set_ = VK_NULL_HANDLE;
    std::optional<vulkan::Buffer> block_;
    DynamicBuffer terrain_indices_, sky_vertices_, instances_;
    std::optional<std::uint32_t> terrain_revision_, sky_revision_;
    SkyExtract sky_extract_;
};

} // namespace alpenglow::sandbox
