// The contract between the world (terrain, objects), the systems and the renderer: plain data, no Vulkan.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace alpenglow::sandbox {

struct CloudRenderData;       // cloud_render_data.hpp
struct EnvironmentRenderData; // environment_render_data.hpp
struct ImpostorRenderData;    // impostor_render_data.hpp
struct OverlayRenderData;     // overlay_render_data.hpp
struct ProbeRenderData;       // probe_render_data.hpp
struct TransferRenderData;    // transfer_render_data.hpp

// A number that no revision in this run has had: equal revisions mean equal content, whatever scene they come from.
[[nodiscard]] inline std::uint32_t next_revision() {
    static std::uint32_t last = 0;
    return ++last;
}

// One vertex of terrain or object, 40 bytes. World frame: metres, +X east, +Y north, +Z up.
struct Vertex {
    glm::vec3 position_m;
    std::uint32_t normal; // xyz as snorm8, packed as VK_FORMAT_R8G8B8A8_SNORM; w unused
    std::uint32_t albedo; // linear reflectance RGB as unorm8 with square-root encoding (value^2); w: sky
                          // visibility (ambient occlusion) as unorm8
    std::array<std::uint32_t, 4> horizon; // 16 azimuths x 8 bits, azimuth k at 22.5 k degrees from north through east:
                                          // elevation of the terrain's horizon, 0..255 -> 0..90 degrees, by sqrt
                                          // encoding: angle = 90 deg * (v/255)^2; below-horizon counts as 0
    std::uint32_t reserved = 0;
};

struct MeshData {
    std::vector<Vertex> vertices;
    std::vector<std::uint32_t> indices;
};

// One drawn copy of a mesh. Objects take the terrain's horizon angles at their foot.
struct ObjectInstance {
    glm::mat4 world_from_object{1.0F};
    std::array<std::uint32_t, 4> horizon{};
    std::uint32_t mesh = 0; // index into WorldData::object_meshes
};

// A soft shadow that objects throw on the ground: small grids draped over the terrain; `shade` is the fraction of the
// disc of the stronger of sun and moon that is hidden, 0..1. Multiplied into the terrain as a loss of that light.
struct ShadowVertex {
    glm::vec3 position_m;
    float shade;
    std::array<std::uint32_t, 4> horizon{}; // of the terrain there, as in Vertex
};

// Vertices of the terrain that form a square grid, row by row from the south-west: the renderer keeps them as an image,
// so that the ground's relief shows where triangles are coarse.
struct TerrainGrid {
    std::uint32_t first_vertex = 0; // in WorldData::terrain.vertices
    std::uint32_t samples = 0;      // a side
    float spacing_m = 0.0F;
    glm::vec2 origin_m{0.0F}; // of the first vertex
};

// What stays for the whole scene.
struct WorldData {
    MeshData terrain;                       // all vertices; indices hold the coarse default
    std::vector<TerrainGrid> terrain_grids; // outer first
    std::vector<MeshData> object_meshes;
    std::vector<ObjectInstance> objects; // sorted by mesh
};

// One vertex of the sky dome: direction and linear radiance in cd/m^2 (before exposure).
struct SkyVertex {
    glm::vec3 direction;
    glm::vec3 radiance_cd_m2;
};

// What a frame is drawn from. Spans stay valid during draw(). Revisions say what changed: equal revision, no upload.
struct FrameData {
    glm::mat4 view{1.0F};
    glm::mat4 projection{1.0F}; // Vulkan clip space: y down, depth 0..1
    glm::vec3 camera_m{0.0F};
    std::array<std::uint32_t, 4>
        camera_horizon{};  // of the terrain below the camera, as in Vertex: 0 is an open horizon
    float exposure = 1.0F; // radiance * exposure = scene value before the tone curve
    // Lights, on surfaces that face them.
    glm::vec3 to_sun{0.0F, 0.0F, 1.0F};
    glm::vec3 sun_illuminance_lux{0.0F};
    float sun_angular_radius_rad = 4.65e-3F;
    glm::vec3 to_moon{0.0F, 0.0F, -1.0F};
    glm::vec3 moon_illuminance_lux{0.0F};
    float moon_angular_radius_rad = 4.5e-3F;
    // The discs as they are seen: the light that comes to the camera, where it differs from that on surfaces (which lie
    // deeper in the air), as it would be without the horizon; height over width.
    std::optional<glm::vec3> sun_seen_lux, moon_seen_lux;
    float sun_flattening = 1.0F, moon_flattening = 1.0F;
    float horizon_rad = 0.0F;    // elevation at which sky ends and the discs set
    bool moon_makes_sky = false; // the dome's vertices stand around the moon instead of the sun
    // Irradiance of sky (and ground bounce) as the quadratic form n^T M n, n = (x, y, z, 1), for R, G, B, in lux.
    std::array<glm::mat4, 3> irradiance_matrix{};
    // Aerial perspective: sea-level extinction of molecules and aerosol per metre (RGB) and scale heights. Distant air
    // saturates to the radiance of the sky's horizon in its azimuth, from sky_vertices.
    glm::vec3 rayleigh_per_m{5.8e-6F, 13.5e-6F, 33.1e-6F};
    glm::vec3 mie_per_m{2.0e-5F};
    float rayleigh_height_m = 8000.0F;
    float mie_height_m = 1200.0F;
    glm::vec3 air_light{1.0F};          // factor on it: less where clouds keep light from the air
    glm::vec3 air_radiance_cd_m2{0.0F}; // saturated air where sky_vertices is empty
    // Terrain level of detail: indices into WorldData::terrain.vertices.
    std::span<const std::uint32_t> terrain_indices;
    std::uint32_t terrain_indices_revision = 0;
    std::span<const ShadowVertex> shadow_vertices;
    std::span<const std::uint32_t> shadow_indices;
    std::uint32_t shadow_revision = 0;
    std::span<const SkyVertex> sky_vertices; // the topology is the dome's, see render/sky_dome.hpp
    std::uint32_t sky_revision = 0;
    // What the scene's parts add, each drawn by its own layer (render/layers.hpp). Null: nothing to draw.
    const CloudRenderData* clouds = nullptr;
    const EnvironmentRenderData* environment = nullptr;
    const ProbeRenderData* probes = nullptr;
    const ImpostorRenderData* impostors = nullptr;
    const TransferRenderData* transfer = nullptr;
    // A picture for a light probe: without the discs of sun and moon, and without what is not part of the scene.
    bool capturing = false;
    const OverlayRenderData* overlay = nullptr;
};

} // namespace alpenglow::sandbox
