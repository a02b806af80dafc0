#include "cloud_settings.hpp"

#include <array>
#include <filesystem>
#include <string_view>

#include "reader.hpp"

namespace alpenglow::sandbox {
namespace {

constexpr double largest_axis_voxels = 2048.0; // of the generators

void read_matter(Reader& section, CloudMatter& matter) {
    section.number("extinction_per_m", 1e-5, 10.0, matter.extinction_per_m);
    section.number("albedo", 0.0, 1.0, matter.albedo);
    section.number("anisotropy", -0.99, 0.99, matter.anisotropy);
}

CloudLayerSettings read_layer(Reader& section) {
    constexpr std::array<std::string_view, 3> types{"cumulus", "stratus", "cirrus"}; // as CloudLayerType
    CloudLayerSettings layer;
    auto type = static_cast<int>(layer.type);
    section.name("type", types, type);
    layer.type = static_cast<CloudLayerType>(type);
    section.number("cover", 0.0, 1.0, layer.cover);
    section.number("base_m", -500.0, 20000.0, layer.base_m);
    section.number("top_m", -500.0, 20000.0, layer.top_m);
    section.number("extent_m", 100.0, 100000.0, layer.extent_m);
    section.number("voxel_m", 1.0, 1000.0, layer.voxel_m);
    section.number("seed", 0, 1000000, layer.seed);
    read_matter(section, layer.matter);
    section.no_others();
    if (!section.failed() && layer.top_m < layer.base_m + 2.0F * layer.voxel_m) {
        section.fail("top_m", shown(static_cast<double>(layer.top_m)), "two voxels or more above base_m");
    }
    if (!section.failed() &&
        static_cast<double>(layer.extent_m) > largest_axis_voxels * static_cast<double>(layer.voxel_m)) {
        section.fail("voxel_m", shown(static_cast<double>(layer.voxel_m)), "extent_m / 2048 or more");
    }
    return layer;
}

CloudFileSettings read_file(Reader& section) {
    CloudFileSettings file;
    section.require("path");
    section.text("path", file.path);
    section.text("grid", file.grid);
    section.numbers("position_m", -60000.0, 60000.0, file.position_m);
    section.number("scale", 1e-3, 1e6, file.scale);
    read_matter(section, file.matter);
    section.no_others();
    return file;
}

} // namespace

CloudSettings read_cloud_settings(Reader& section) {
    constexpr std::array<std::string_view, 4> methods{"single-scattering", "harris", "octaves", "transport"};
    constexpr std::array<std::string_view, 2> marches{"auto", "cpu"};
    CloudSettings settings;
    settings.folder = std::filesystem::path(section.file()).parent_path().string();
    settings.scene = std::filesystem::path(section.file()).stem().string();
    section.each("layers", [&](Reader& item) { settings.layers.push_back(read_layer(item)); });
    section.each("files", [&](Reader& item) { settings.files.push_back(read_file(item)); });
    section.number("wind_m_s", 0.0, 100.0, settings.wind_m_s);
    section.number("wind_from_deg", -360.0, 360.0, settings.wind_from_deg);
    section.name("method", methods, settings.method);
    section.boolean("shadows", settings.shadows);
    section.name("march", marches, settings.march);
    section.number("reshape_s", 0.0, 1e6, settings.reshape_s);
    return settings;
}

} // namespace alpenglow::sandbox
