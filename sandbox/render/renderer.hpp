// Draws a frame: into a window's swapchain or, headless, into memory. Both take the same path and give the same bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <alpenglow/core/result.hpp>
#include <alpenglow/vulkan/device.hpp>
#include <alpenglow/vulkan/frame_ring.hpp>
#include <alpenglow/vulkan/instance.hpp>
#include <alpenglow/vulkan/swapchain.hpp>

#include "sandbox/render/dynamic_buffer.hpp"
#include "sandbox/render/gpu_data.hpp"
#include "sandbox/render/hud.hpp"
#include "sandbox/render/layer.hpp"
#include "sandbox/render/passes.hpp"
#include "sandbox/render/scene_capture.hpp"
#include "sandbox/render/sky_dome.hpp"
#include "sandbox/render/terrain_image.hpp"
#include "sandbox/render/visible_objects.hpp"
#include "sandbox/world/render_data.hpp"

namespace alpenglow::sandbox {

struct RendererOptions {
    VkExtent2D extent{960, 540};
    Quality quality = Quality::automatic;
    std::uint32_t frames_in_flight = 2;
    std::filesystem::path shader_directory{}; // the folder shaders/ to follow for changes; empty: none
};

class Renderer {
public:
    // The device outlives the renderer; `world` is copied to the device and may go.
    static Result<std::unique_ptr<Renderer>> create(const vulkan::Device& device, const WorldData& world,
                                                    const RendererOptions& options);
    ~Renderer();
    Renderer(const Renderer&) = delete;
    Renderer& operator=(const Renderer&) = delete;

    [[nodiscard]] Quality quality() const { return quality_; }
    [[nodiscard]] VkExtent2D extent() const { return extent_; }

    // New targets. Waits for the device.
    Status resize(VkExtent2D extent);

    // Sets up ImGui's Vulkan backend for the current ImGui context, which must outlive the renderer.
    Status enable_hud(const vulkan::Instance& instance);

    // Draws and submits a frame; with a swapchain, also presents it, scaled to the window. Returns while the device is
    // still drawing; waits where `frames_in_flight` frames are under way. `hud`: ImGui's draw data, laid over the frame
    // (enable_hud() first); its picture is kept and drawn again only when it has changed.
    Result<DrawStats> draw(const FrameData& frame, vulkan::Swapchain* swapchain = nullptr, ImDrawData* hud = nullptr);

    // One face of the cube map of radiance around a point, cd/m^2, without the discs of sun and moon, in the light of
    // `frame`: probes::RenderFace. `texels`: capture_edge^2. Waits for the device.
    Status capture(const FrameData& frame, const glm::vec3& point_m, int face, std::span<glm::vec3> texels);

    // Waits until all submitted frames are done.
    Status finish();

    // The last frame, RGBA, 8 bits, sRGB, rows from the top. Waits for it.
    Result<std::vector<std::byte>> read_pixels();

    // Compiles shaders whose files have changed. One message for each pipeline that was made anew or that is kept as it
    // was because its shader is broken; empty where nothing changed.
    std::vector<std::string> reload_shaders();

private:
    explicit Renderer(const vulkan::Device& device) : device_(device) {}
    Status create_descriptors();
    Status upload_world(const WorldData& world);
    Status upload_terrain_images(const WorldData& world);
    Status create_targets(VkExtent2D extent);
    Status update_buffers(const FrameData& frame, std::uint32_t slot, DrawStats& stats);
    void record_shadow_map(VkCommandBuffer commands, DrawStats& stats);
    void record_scene(VkCommandBuffer commands, const FrameData& frame, DrawStats& stats);
    void record_objects(VkCommandBuffer commands, std::span<const ObjectRun> runs, VkBuffer instances,
                        DrawStats& stats) const;
    [[nodiscard]] const vulkan::Image& output() const;

    struct Mesh {
        std::uint32_t first_index = 0;
        std::uint32_t index_count = 0;
        std::int32_t vertex_offset = 0;
    };
    struct Slot {
        std::optional<vulkan::Buffer> block; // the FrameBlock
        VkDescriptorSet set = VK_NULL_HANDLE;
    };
    struct TerrainImage {
        std::optional<vulkan::Image> image;
        VkDescriptorSet set = VK_NULL_HANDLE;
        glm::vec4 from_position{0.0F};
    };

    const vulkan::Device& device_;
    Quality quality_ = Quality::lean;
    VkExtent2D extent_{};
    std::uint32_t frames_in_flight_ = 2;
    Passes passes_;
    vulkan::DescriptorPool descriptors_;
    vulkan::Sampler terrain_sampler_, detail_sampler_, shadow_sampler_, point_sampler_;
    vulkan::RenderTarget scene_target_, shadow_target_, final_target_; // lean: the first alone
    VkDescriptorSet resolve_set_ = VK_NULL_HANDLE;
    VkDescriptorSet hud_set_ = VK_NULL_HANDLE;
    std::vector<Slot> slots_;
    std::optional<vulkan::FrameRing> ring_;
    std::unique_ptr<Hud> hud_;

    // What stays.
    std::optional<vulkan::Buffer> terrain_vertices_;
    std::vector<TerrainGrid> terrain_grids_;
    std::vector<TerrainImage> terrain_images_; // one a grid
    std::vector<TerrainRun> terrain_runs_;     // of the current triangulation
    std::optional<vulkan::Image> detail_image_;
    VkDescriptorSet detail_set_ = VK_NULL_HANDLE;
    std::optional<vulkan::Buffer> object_vertices_;
    std::optional<vulkan::Buffer> object_indices_;
    std::optional<vulkan::Buffer> all_instances_; // for the shadow map
    std::vector<ObjectRun> all_runs_;
    std::optional<vulkan::Buffer> sky_indices_;
    std::vector<SkyPatch> sky_patches_ = sky_dome_patches();
    std::vector<IndexRun> sky_runs_; // in view
    std::vector<Mesh> meshes_;
    std::vector<gpu::Instance> instances_; // one an object
    VisibleObjects visible_;
    // What changes now and then, and the revision that it has.
    DynamicBuffer terrain_indices_, decal_vertices_, decal_indices_, sky_vertices_, visible_instances_;
    std::optional<std::uint32_t> terrain_revision_, decal_revision_, sky_revision_;
    SkyExtract sky_extract_;
    gpu::FrameBlock block_{};          // the frame's
    gpu::mat4 shadow_drawn_for_{0.0F}; // what the shadow map shows, and where the camera stood
    gpu::vec4 shadow_drawn_at_{0.0F};
    std::vector<std::unique_ptr<Layer>> layers_;
    std::vector<Layer*> drawn_layers_; // those that this frame wants
    std::filesystem::path shader_directory_;
    std::unique_ptr<SceneCapture> capture_; // null until the first capture()
};

} // namespace alpenglow::sandbox
