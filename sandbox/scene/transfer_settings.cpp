#include "transfer_settings.hpp"

#include <array>
#include <filesystem>
#include <string_view>

#include "reader.hpp"

namespace alpenglow::sandbox {

TransferSettings read_transfer_settings(Reader& section) {
    constexpr std::array<std::string_view, 3> levels{"unshadowed", "shadowed", "interreflected"};   // as TransferLevel
    constexpr std::array<std::string_view, 3> paths{"auto", "cpu", "shader"};                       // as TransferPath
    constexpr std::array<std::string_view, 4> windows{"none", "irradiance", "halfway", "radiance"}; // as TransferWindow
    TransferSettings settings;
    auto level = static_cast<int>(settings.level);
    auto path = static_cast<int>(settings.path);
    auto window = static_cast<int>(settings.window);
    section.name("level", levels, level);
    section.name("path", paths, path);
    section.name("window", windows, window);
    settings.level = static_cast<TransferLevel>(level);
    settings.path = static_cast<TransferPath>(path);
    settings.window = static_cast<TransferWindow>(window);
    section.number("detail", 0.1, 2.0, settings.detail);
    section.text("mesh", settings.mesh);
    if (!settings.mesh.empty() && std::filesystem::path(settings.mesh).is_relative()) {
        settings.mesh = (std::filesystem::path(section.file()).parent_path() / settings.mesh).string();
    }
    return settings;
}

} // namespace alpenglow::sandbox
