// Impostors and a GPU. Drawables that draw on one: a mesh by its rasterizer, slab by slab, and the march of a cloud.
// Pictures of both are held against drawing the same thing on the same device from where the viewer has gone.
#include "gpu_test.hpp"

#include "real_cloud.hpp"

#include <alpenglow/clouds/shader_tables.hpp>
#include <alpenglow/impostors/raster.hpp>
#include <alpenglow/impostors/reproject.hpp>
#include <alpenglow/vulkan/buffer.hpp>
#include <alpenglow/vulkan/pipeline.hpp>
#include <alpenglow/vulkan/render_pass.hpp>
#include <alpenglow/vulkan/transfer.hpp>

#include <alpenglow_shaders/cloud_picture.frag.hpp>
#include <alpenglow_shaders/impostor_draw.frag.hpp>
#include <alpenglow_shaders/mesh.frag.hpp>
#include <alpenglow_shaders/mesh.vert.hpp>
#include <alpenglow_shaders/resolve.vert.hpp>

#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>

namespace alpenglow::vulkan {
namespace {

using namespace impostors;

constexpr double degree = std::numbers::pi / 180.0;
constexpr RenderPassOptions picture_pass{
    .color = VK_FORMAT_R32G32B32A32_SFLOAT, .depth = VK_FORMAT_D32_SFLOAT, .keep_depth = true};

Frustum orbit(const Sphere& bounds, double angle, int pixels) {
    const glm::dvec3 eye =
        bounds.centre_m + 4.0 * bounds.radius_m * glm::dvec3(std::sin(angle), -std::cos(angle), 0.2 * std::sin(angle));
    return look_at(eye, bounds.centre_m, {0, 0, 1}, 2.0 * std::atan(1.05 / std::sqrt(15.0)), pixels, pixels);
}

template <class T>
std::vector<T> read(const Device& device, const Image& image, VkImageLayout layout) {
    Result<std::vector<std::byte>> bytes = read_image(device, image, layout);
    EXPECT_TRUE(bytes);
    std::vector<T> values(bytes->size() / sizeof(T));
    std::memcpy(values.data(), bytes->data(), values.size() * sizeof(T));
    return values;
}

struct Vertex {
    glm::vec3 position, normal;
};

// A ring that is thicker here and thinner there.
std::vector<Vertex> ring() {
    constexpr int along = 96;
    constexpr int around = 32;
    const auto point = [](int i, int j) {
        const double u = 2.0 * std::numbers::pi * i / along;
        const double v = 2.0 * std::numbers::pi * j / around;
        const double thick = 0.22 + 0.06 * std::sin(5.0 * u);
        const glm::dvec3 out(std::cos(u), std::sin(u), 0.4 * std::sin(2.0 * u));
        return 0.65 * out + thick * (std::cos(v) * glm::dvec3(out.x, out.y, 0.0) + std::sin(v) * glm::dvec3(0, 0, 1));
    };
    std::vector<Vertex> vertices;
    for (int i = 0; i < along; ++i) {
        for (int j = 0; j < around; ++j) {
            for (const auto& [a, b] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}}) {
                const glm::dvec3 along_u = point(i + a + 1, j + b) - point(i + a - 1, j + b);
                const glm::dvec3 along_v = point(i + a, j + b + 1) - point(i + a, j + b - 1);
                vertices.push_back(
                    {glm::vec3(point(i + a, j + b)), glm::vec3(glm::normalize(glm::cross(along_u, along_v)))});
            }
        }
    }
    return vertices;
}

class GpuDrawable : public GpuTest {
protected:
    struct Draw {
        glm::mat4 clip_from_eye;
        glm::vec4 eye, to_key;
    };
    struct Pixels {
        std::vector<glm::vec4> colour;
        std::vector<float> depth;
    };

    void SetUp() override {
        GpuTest::SetUp();
        Result<RenderPass> made = create_render_pass(*device, picture_pass);
        ASSERT_TRUE(made) << made.error().message();
        pass = std::move(made).value();
    }
    void TearDown() override {
        pass = {};
        vertices.reset();
        GpuTest::TearDown();
    }

    // The mesh between two axis depths, `samples` x `samples` pixels for each of the view's.
    Result<Pixels> draw_mesh(const Frustum& view, double near_m, double far_m, int samples) {
        const VkPushConstantRange range{VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof(Draw)};
        Result<PipelineLayout> layout = create_pipeline_layout(*device, {}, {&range, 1});
        const std::array<ShaderStage, 2> stages{
            {{VK_SHADER_STAGE_VERTEX_BIT, mesh_vert}, {VK_SHADER_STAGE_FRAGMENT_BIT, mesh_frag}}};
        const VkVertexInputBindingDescription binding{0, sizeof(Vertex), VK_VERTEX_INPUT_RATE_VERTEX};
        const std::array<VkVertexInputAttributeDescription, 2> attributes{
            {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, 0}, {1, 0, VK_FORMAT_R32G32B32_SFLOAT, sizeof(glm::vec3)}}};
        Result<Pipeline> pipeline = create_graphics_pipeline(*device, {.stages = stages,
                                                                       .bindings = {&binding, 1},
                                                                       .attributes = attributes,
                                                                       .layout = layout->get(),
                                                                       .pass = pass.get(),
                                                                       .cull = VK_CULL_MODE_BACK_BIT,
                                                                       .depth_test = true,
                                                                       .depth_write = true});
        if (!pipeline) {
            return pipeline.error();
        }
        const auto side = [samples](int n) { return static_cast<std::uint32_t>(n * samples); };
        Result<RenderTarget> target = create_render_target(
            *device, picture_pass, pass.get(), {side(view.width), side(view.height)}, VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
            VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_SAMPLED_BIT);
        if (!target) {
            return target.error();
        }
        if (!vertices) {
            const std::vector<Vertex> mesh = ring();
            count = static_cast<std::uint32_t>(mesh.size());
            Result<Buffer> made = Buffer::create(*device, mesh.size() * sizeof(Vertex),
                                                 VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, Placement::upload);
            std::memcpy(made->mapped().data(), mesh.data(), mesh.size() * sizeof(Vertex));
            vertices = std::move(made).value();
        }
        const Draw draw{clip_from_eye(view, near_m, far_m), glm::vec4(glm::vec3(view.eye_m), 0.0F),
                        glm::vec4(0.3F, -0.4F, 0.866F, 0.0F)};
        const Status done = submit_and_wait(*device, [&](VkCommandBuffer commands) {
            begin_render_pass(commands, pass.get(), *target);
            vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline->get());
            vkCmdPushConstants(commands, layout->get(), range.stageFlags, 0, sizeof draw, &draw);
            const VkBuffer buffer = vertices->get();
            const VkDeviceSize zero = 0;
            vkCmdBindVertexBuffers(commands, 0, 1, &buffer, &zero);
            vkCmdDraw(commands, count, 1, 0, 0);
            vkCmdEndRenderPass(commands);
        });
        if (!done) {
            return done.error();
        }
        return Pixels{read<glm::vec4>(*device, *target->color, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL),
                      read<float>(*device, *target->depth, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL)};
    }

    // What a game passes to capture() and to CaptureStore: slab by slab, straight off the device.
    Drawable mesh_drawable(int samples = 4) {
        return [this, samples](const CaptureRequest& request, std::span<SlabImage> slabs) -> Status {
            for (std::size_t k = 0; k < slabs.size(); ++k) {
                const double far_m = request.edges_m[k + 1];
                const double near_m = k == 0 ? request.edges_m[0] : 1.1 * request.edges_m[k] - 0.1 * far_m;
                const Result<Pixels> pixels = draw_mesh(request.view, near_m, far_m, samples);
                if (!pixels) {
                    return pixels.error();
                }
                fill_slab(request, near_m, far_m, pixels->colour, pixels->depth, samples, slabs[k]);
            }
            return Ok{};
        };
    }

    RenderPass pass;
    std::optional<Buffer> vertices;
    std::uint32_t count = 0;
};

TEST_F(GpuDrawable, MeshFromAnotherEye) {
    const Sphere bounds{{0, 0, 0}, 1.0};
    const auto directly = [&](const Frustum& view) {
        CaptureRequest request{
            .view = view, .edges_m = {2.5, 5.5}, .depth_origin_m = 4.0, .depth_scale_m = 1.5, .lights = {}};
        std::vector<SlabImage> image(1);
        image[0].colour.resize(static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height));
        image[0].depth.resize(image[0].colour.size());
        EXPECT_TRUE(mesh_drawable()(request, image));
        return image[0].colour;
    };
    const auto picture = [&](Representation kind, int layers, bool sharpen) {
        CaptureSettings settings;
        settings.representation = kind;
        settings.layers = layers;
        settings.sharpen = sharpen;
        Result<Capture> made = capture(bounds, *fit_frustum(bounds, orbit(bounds, 0.0, 96).eye_m, {0, 0, 1}, 128),
                                       settings, mesh_drawable());
        EXPECT_TRUE(made);
        EXPECT_EQ(made->rejected_texels, 0U);
        return std::move(made).value();
    };
    const auto error = [&](const Capture& of, double angle) {
        const Frustum view = angle < 0.0 ? of.view : orbit(bounds, angle, 96);
        const auto exact = directly(view);
        std::vector<glm::vec4> image(exact.size(), glm::vec4(0.0F));
        draw(of, view, {}, image);
        return std::pair{test::relative_rmse(image, exact), test::tone_mapped_psnr(image, exact)};
    };
    const auto angles = {1.0, 5.0};
    std::vector<std::pair<double, double>> plane;
    const Capture flat = picture(Representation::plane, 1, true);
    for (const double angle : angles) {
        plane.push_back(error(flat, angle * degree));
    }
    for (const auto& [kind, layers] : {std::pair{Representation::plane, 1},
                                       {Representation::depth_warp, 1},
                                       {Representation::layers, 8},
                                       {Representation::warped_layers, 4}}) {
        // From where it was taken. Layers blend what they have of one texel as if it covered each other by chance.
        EXPECT_LT(error(picture(kind, layers, false), -1.0).first, layers == 1 ? 1e-5 : 0.03);
        if (kind == Representation::plane) {
            continue;
        }
        const Capture of = picture(kind, layers, true);
        std::size_t k = 0;
        for (const double angle : angles) {
            const auto [rmse, psnr] = error(of, angle * degree);
            EXPECT_LT(rmse, 0.5 * plane[k].first) << static_cast<int>(kind) << " at " << angle;
            EXPECT_GT(psnr, plane[k].second + 5.0) << static_cast<int>(kind) << " at " << angle;
            RecordProperty("psnr_" + std::to_string(static_cast<int>(kind)) + "_at_" + std::to_string(k),
                           std::to_string(psnr) + " plane " + std::to_string(plane[k].second));
            ++k;
        }
        if (kind == Representation::warped_layers) { // at five degrees better than a plane at one
            EXPECT_GT(error(of, 5.0 * degree).second, plane[0].second);
        }
    }
}

// shaders/alpenglow/impostor.glsl draws what draw() does: every kind, near and far from where the picture was taken.
TEST_F(GpuDrawable, ResamplerIsTheCpus) {
    const test::BlobCloud cloud = test::make_blob_cloud(40, 5);
    const Frustum from = *fit_frustum(cloud.bounds, {0, -4, 0}, {0, 0, 1}, 64);
    const std::array<VkDescriptorSetLayoutBinding, 3> bindings{{
        {0, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1, VK_SHADER_STAGE_FRAGMENT_BIT, nullptr},
        {1, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1, VK_SHADER_STAGE_FRAGMENT_BIT, nullptr},
        {2, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1, VK_SHADER_STAGE_FRAGMENT_BIT, nullptr},
    }};
    struct Constants {
        glm::vec4 eye, window, size, ray, ray_x, ray_y, slab;
    };
    const Result<DescriptorSetLayout> set_layout = create_descriptor_set_layout(*device, bindings);
    const VkDescriptorSetLayout sets[] = {set_layout->get()};
    const VkPushConstantRange range{VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof(Constants)};
    const Result<PipelineLayout> layout = create_pipeline_layout(*device, sets, {&range, 1});
    const std::array<ShaderStage, 2> stages{
        {{VK_SHADER_STAGE_VERTEX_BIT, resolve_vert}, {VK_SHADER_STAGE_FRAGMENT_BIT, impostor_draw_frag}}};
    const Result<Pipeline> pipeline = create_graphics_pipeline(
        *device, {.stages = stages, .layout = layout->get(), .pass = pass.get(), .blend = Blend::over});
    ASSERT_TRUE(pipeline) << pipeline.error().message();
    const Result<Sampler> sampler = create_sampler(*device, {});
    const auto upload = [&](const auto& texels, VkFormat format) {
        Result<Image> image = Image::create(
            *device, {.format = format,
                      .extent = {static_cast<std::uint32_t>(from.width), static_cast<std::uint32_t>(from.height)},
                      .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT});
        EXPECT_TRUE(image);
        EXPECT_TRUE(upload_image(*device, *image, std::as_bytes(std::span(texels))));
        return std::move(image).value();
    };
    constexpr int side = 56;
    for (const Representation kind :
         {Representation::plane, Representation::layers, Representation::depth_warp, Representation::warped_layers}) {
        CaptureSettings settings;
        settings.representation = kind;
        settings.layers = 4;
        const Result<Capture> picture = capture(cloud.bounds, from, settings, test::drawable(cloud));
        ASSERT_TRUE(picture);
        std::vector<Image> images;
        std::vector<VkDescriptorSet> bound;
        const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 12}};
        const Result<DescriptorPool> pool = create_descriptor_pool(*device, 4, sizes);
        for (const Layer& layer : picture->layers) {
            const std::vector<float> flat(layer.mips.front().colour.size());
            images.push_back(upload(layer.mips.front().colour, VK_FORMAT_R32G32B32A32_SFLOAT));
            images.push_back(upload(layer.mips.front().fill, VK_FORMAT_R32G32B32A32_SFLOAT));
            images.push_back(upload(layer.warp.empty() ? flat : layer.warp, VK_FORMAT_R32_SFLOAT));
            bound.push_back(*allocate_descriptor_set(*device, pool->get(), set_layout->get()));
            for (std::uint32_t i = 0; i < 3; ++i) {
                write_image_descriptor(*device, bound.back(), i, images[images.size() - 3 + i].view(), sampler->get());
            }
        }
        for (const double angle : {0.0, 2.0, 15.0}) {
            const Frustum view = orbit(cloud.bounds, angle * degree, side);
            const auto local = [&](const glm::dvec3& a) {
                return glm::dvec3(glm::dot(a, from.right), glm::dot(a, from.up), glm::dot(a, from.forward));
            };
            const auto four = [](const glm::dvec3& a) { return glm::vec4(glm::vec3(a), 0.0F); };
            const glm::dvec3 eye = local(view.eye_m - from.eye_m);
            const Result<RenderTarget> target =
                create_render_target(*device, picture_pass, pass.get(), {side, side}, VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                                     VK_IMAGE_USAGE_SAMPLED_BIT);
            ASSERT_TRUE(submit_and_wait(*device, [&](VkCommandBuffer commands) {
                begin_render_pass(commands, pass.get(), *target);
                vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline->get());
                for (std::size_t k = picture->layers.size(); k-- > 0;) {
                    const Layer& layer = picture->layers[k];
                    // As reproject.cpp decides: how far the warp moves texels from the front of the slab to its back.
                    const double moved = std::hypot(eye.x * from.pixels_per_tan_x(), eye.y * from.pixels_per_tan_y()) *
                                         layer.plane_m / (layer.plane_m - eye.z) *
                                         (1.0 / layer.near_m - 1.0 / layer.far_m);
                    const double steps = layer.warp.empty() ? -1.0
                                         : moved < 2.0      ? 0.0
                                                            : std::min(8.0, std::ceil(moved / 3.5));
                    const Constants constants{
                        four(eye),
                        glm::vec4(from.tan_left, from.tan_top, from.pixels_per_tan_x(), -from.pixels_per_tan_y()),
                        glm::vec4(from.width, from.height, picture->depth_origin_m, picture->depth_scale_m),
                        four(local(view.direction(0.5, 0.5))),
                        four(local(view.right) / view.pixels_per_tan_x()),
                        four(-local(view.up) / view.pixels_per_tan_y()),
                        glm::vec4(layer.near_m, layer.far_m, 1.0 / layer.plane_m, steps)};
                    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout->get(), 0, 1, &bound[k],
                                            0, nullptr);
                    vkCmdPushConstants(commands, layout->get(), VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof constants,
                                       &constants);
                    vkCmdDraw(commands, 3, 1, 0, 0);
                }
                vkCmdEndRenderPass(commands);
            }));
            const auto gpu = read<glm::vec4>(*device, *target->color, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
            std::vector<glm::vec4> cpu(gpu.size(), glm::vec4(0.0F));
            DrawSettings draw_settings;
            draw_settings.gain.key = glm::vec3(1.5F, 1.0F, 0.5F);
            draw_settings.gain.fill = glm::vec3(0.5F, 1.0F, 2.0F);
            impostors::draw(*picture, view, draw_settings, cpu);
            EXPECT_LT(test::relative_rmse(gpu, cpu), 2e-3) << static_cast<int>(kind) << " at " << angle;
        }
    }
}

// The march of shaders/alpenglow/cloud.glsl as a Drawable of one picture: alpha and mean depth, no spread.
TEST_F(GpuDrawable, CloudFromAnotherEye) {
    const test::RealCloud cloud(5, 24);
    constexpr std::uint32_t inputs = 5;
    const auto march = [&](const Frustum& view, bool distance) {
        const clouds::GridTransform& transform = cloud.volume.transform();
        const clouds::Camera camera = cloud_camera(view);
        const auto local = [&](const glm::vec3& world) {
            return glm::vec4(glm::vec3(transform.local_direction(glm::dvec3(world))), 0.0F);
        };
        const std::array<glm::vec4, 6> pinhole{
            glm::vec4(clouds::shader_eye(cloud.volume, camera.position_m),
                      0.5F * static_cast<float>(view.height) / camera.tan_half_height),
            local(camera.forward),
            local(camera.right),
            local(camera.up),
            glm::vec4(glm::vec3(transform.voxel_m), 0.0F),
            glm::vec4(view.width, view.height, 0.0F, 0.0F)};
        const std::vector<std::uint32_t> bricks = clouds::pack_volume(cloud.volume);
        const std::vector<std::uint32_t> light = clouds::pack_light(cloud.volume, cloud.lighting);
        const std::vector<std::uint32_t> marching = clouds::pack_view(
            cloud.volume, cloud.lighting, cloud.lighting.contract(transform.index_from_world(camera.position_m)), {});
        const std::array<std::span<const std::byte>, inputs> contents{
            std::as_bytes(std::span(bricks)), std::as_bytes(std::span(light)), std::as_bytes(std::span(pinhole)),
            std::as_bytes(std::span(marching)), std::as_bytes(std::span(pinhole))}; // no detail: not read
        std::array<VkDescriptorSetLayoutBinding, inputs> bindings{};
        for (std::uint32_t i = 0; i < inputs; ++i) {
            bindings[i] = {i, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_FRAGMENT_BIT, nullptr};
        }
        Result<DescriptorSetLayout> set_layout = create_descriptor_set_layout(*device, bindings);
        const VkDescriptorSetLayout sets[] = {set_layout->get()};
        Result<PipelineLayout> layout = create_pipeline_layout(*device, sets);
        const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, inputs}};
        Result<DescriptorPool> pool = create_descriptor_pool(*device, 1, sizes);
        Result<VkDescriptorSet> set = allocate_descriptor_set(*device, pool->get(), set_layout->get());
        std::array<std::optional<Buffer>, inputs> buffers;
        for (std::uint32_t i = 0; i < inputs; ++i) {
            Result<Buffer> made =
                Buffer::create(*device, contents[i].size(), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, Placement::upload);
            std::memcpy(made->mapped().data(), contents[i].data(), contents[i].size());
            buffers[i] = std::move(made).value();
            const VkDescriptorBufferInfo info{buffers[i]->get(), 0, VK_WHOLE_SIZE};
            VkWriteDescriptorSet write{};
            write.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
            write.dstSet = *set;
            write.dstBinding = i;
            write.descriptorCount = 1;
            write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
            write.pBufferInfo = &info;
            vkUpdateDescriptorSets(device->get(), 1, &write, 0, nullptr);
        }
        const std::array<ShaderStage, 2> stages{
            {{VK_SHADER_STAGE_VERTEX_BIT, resolve_vert}, {VK_SHADER_STAGE_FRAGMENT_BIT, cloud_picture_frag}}};
        const std::array<std::uint32_t, 1> constants{distance ? 1U : 0U};
        Result<Pipeline> pipeline = create_graphics_pipeline(
            *device, {.stages = stages, .constants = constants, .layout = layout->get(), .pass = pass.get()});
        EXPECT_TRUE(pipeline) << pipeline.error().message();
        Result<RenderTarget> target =
            create_render_target(*device, picture_pass, pass.get(),
                                 {static_cast<std::uint32_t>(view.width), static_cast<std::uint32_t>(view.height)},
                                 VK_IMAGE_USAGE_TRANSFER_SRC_BIT, VK_IMAGE_USAGE_SAMPLED_BIT);
        EXPECT_TRUE(submit_and_wait(*device, [&](VkCommandBuffer commands) {
            begin_render_pass(commands, pass.get(), *target);
            vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline->get());
            vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout->get(), 0, 1, &*set, 0, nullptr);
            vkCmdDraw(commands, 3, 1, 0, 0);
            vkCmdEndRenderPass(commands);
        }));
        return read<glm::vec4>(*device, *target->color, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    };
    const Drawable drawable = [&](const CaptureRequest& request, std::span<SlabImage> slabs) -> Status {
        slabs[0].colour = march(request.view, false);
        const std::vector<glm::vec4> distance = march(request.view, true);
        for (std::size_t i = 0; i < distance.size(); ++i) {
            const auto x = static_cast<double>(i % static_cast<std::size_t>(request.view.width)) + 0.5;
            const auto y = static_cast<double>(i / static_cast<std::size_t>(request.view.width)) + 0.5;
            const double z = static_cast<double>(distance[i].x) / glm::length(request.view.direction(x, y));
            const auto s = static_cast<float>((z - request.depth_origin_m) / request.depth_scale_m);
            slabs[0].depth[i] = slabs[0].colour[i].w * glm::vec2(s, s * s);
        }
        return Ok{};
    };
    CaptureSettings settings;
    settings.representation = Representation::depth_warp;
    const Frustum from = *fit_frustum(cloud.bounds, orbit(cloud.bounds, 0.0, 40).eye_m, {0, 0, 1}, 48);
    const Result<Capture> of = capture(cloud.bounds, from, settings, drawable);
    ASSERT_TRUE(of);
    for (const double angle : {1.0, 3.0}) {
        const Frustum view = orbit(cloud.bounds, angle * degree, 40);
        const auto exact = march(view, false);
        std::vector<glm::vec4> image(exact.size(), glm::vec4(0.0F));
        impostors::draw(*of, view, {}, image);
        EXPECT_LT(test::relative_rmse(image, exact), 0.04) << angle;
        EXPECT_GT(test::tone_mapped_psnr(image, exact), 50.0) << angle;
    }
}

} // namespace
} // namespace alpenglow::vulkan
