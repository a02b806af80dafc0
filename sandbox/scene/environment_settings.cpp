#include "environment_settings.hpp"

#include <string>

#include "reader.hpp"

namespace alpenglow::sandbox {

EnvironmentSettings read_environment_settings(Reader& section) {
    EnvironmentSettings settings;
    std::string file;
    section.require("file");
    section.text("file", file);
    section.number("scale", 1e-6, 1e9, settings.scale);
    section.number("azimuth_deg", -360.0, 360.0, settings.azimuth_deg);
    settings.file = file;
    if (settings.file.is_relative()) {
        settings.file = std::filesystem::path(section.file()).parent_path() / settings.file;
    }
    return settings;
}

} // namespace alpenglow::sandbox
