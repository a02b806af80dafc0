// The section `environment` of a scene: a picture of the surroundings in place of sky, sun and moon.
#pragma once

#include <filesystem>

namespace alpenglow::sandbox {

class Reader;

struct EnvironmentSettings {
    std::filesystem::path file; // an equirectangular Radiance .hdr; relative to the scene's file
    float scale = 1.0F;         // cd/m^2 a unit of the picture
    float azimuth_deg = 0.0F;   // turns it, from north towards east
};

[[nodiscard]] EnvironmentSettings read_environment_settings(Reader& section);

} // namespace alpenglow::sandbox
