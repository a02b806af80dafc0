// The section `clouds` of a scene.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

namespace alpenglow::sandbox {

class Reader;

// What the matter of a cloud does to light.
struct CloudMatter {
    float extinction_per_m = 0.05F; // where it is densest
    float albedo = 0.9995F;
    float anisotropy = 0.85F;
};

enum class CloudLayerType { cumulus, stratus, cirrus }; // as clouds::CloudType

// Clouds modelled from the weather, over a square that repeats towards the horizon.
struct CloudLayerSettings {
    CloudLayerType type = CloudLayerType::cumulus;
    float cover = 0.4F;                      // fraction of the ground with cloud above it
    float base_m = 2300.0F, top_m = 3600.0F; // above sea level
    float extent_m = 20000.0F;
    float voxel_m = 40.0F;
    int seed = 1;
    CloudMatter matter;
};

// A cloud from a .vdb file.
struct CloudFileSettings {
    std::string path;                          // as in the scene file, relative to its folder
    std::string grid;                          // empty: "density", or else the first float grid
    glm::vec3 position_m{0.0F, 0.0F, 3000.0F}; // of the middle of its matter
    float scale = 1.0F;                        // of the file's size
    CloudMatter matter;
};

struct CloudSettings {
    std::vector<CloudLayerSettings> layers;
    std::vector<CloudFileSettings> files;
    float wind_m_s = 6.0F;
    float wind_from_deg = 270.0F; // azimuth that the wind comes from, from north through east
    int method = 3;               // as CloudMethod
    bool shadows = true;          // on terrain and objects
    int march = 0;                // 0: by the device where the quality is full and it can; 1: by the CPU
    float reshape_s = 600.0F;     // in which what is finer than a voxel has become another; 0: never
    std::string folder;           // of the scene file
    std::string scene;            // its name, or the file's
};

[[nodiscard]] CloudSettings read_cloud_settings(Reader& section);

} // namespace alpenglow::sandbox
