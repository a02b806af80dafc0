// Smoke from an OpenVDB file, resampled to the dense grid that a volume bake takes.
#pragma once

#include <alpenglow/prt/bake_volume.hpp>

#include <filesystem>

namespace alpenglow::bake {

// The first float grid called "density", or the first float grid at all, at `size` points along its longest axis.
// Values times `extinction_scale` are extinction per metre.
[[nodiscard]] Result<prt::VolumeDensity> read_vdb(const std::filesystem::path& path, unsigned size,
                                                  float extinction_scale);

} // namespace alpenglow::bake
