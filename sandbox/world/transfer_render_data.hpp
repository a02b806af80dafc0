// What a scene with baked light draws beside the landscape (render_data.hpp): plain data, no Vulkan.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace alpenglow::sandbox {

// In the body's own frame, metres.
struct BodyVertex {
    glm::vec3 position_m;
    glm::vec3 normal;
    glm::vec3 albedo; // of diffuse light, linear
};

// A table of half floats as the vertex shader reads it (alpenglow/transfer.glsl), and the light that meets it.
struct ShadedTable {
    std::span<const std::byte> blocks; // empty: none
    std::uint32_t rows = 1;            // 1: vectors; more: matrices
    std::uint32_t channels = 1;
    std::uint32_t coefficients = 0;
    std::span<const glm::vec3> light; // in the body's frame, cd/m^2
};

struct TransferBody {
    std::span<const BodyVertex> vertices;
    std::span<const std::uint32_t> indices; // triangles, counter-clockwise from outside
    std::uint32_t mesh_revision = 0;
    glm::quat world_from_body{1.0F, 0.0F, 0.0F, 0.0F};
    glm::vec3 position_m{0.0F};
    // [vertex] Radiance in cd/m^2; where shaders evaluate the tables, the part of the light that other things leave.
    std::span<const glm::vec3> light;
    std::uint32_t light_revision = 0;
    // For shaders.
    ShadedTable diffuse, glossy;
    std::uint32_t table_revision = 0;  // of both tables' blocks
    std::uint32_t shade_revision = 0;  // of what follows and the tables' light
    glm::vec3 specular{0.0F};          // reflectance of the lobe
    std::uint32_t glossy_vertices = 0; // the first ones have it
    std::array<float, 6> kernel{};     // of the lobe, by band
};

struct SmokeVertex {
    glm::vec3 position_m;
    glm::vec4 radiance; // cd/m^2, premultiplied; w: what it covers, 0 .. 1
};

// Spans stay valid during draw(). Equal revision, no upload.
struct TransferRenderData {
    std::span<const TransferBody> bodies;
    bool by_shader = false; // whether shaders evaluate the tables
    std::span<const SmokeVertex> smoke_vertices;
    std::span<const std::uint32_t> smoke_indices;
    std::uint32_t smoke_revision = 0;
};

} // namespace alpenglow::sandbox
