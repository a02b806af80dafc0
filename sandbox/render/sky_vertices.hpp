// The sky dome's vertices as the device reads them.
#pragma once

#include <array>
#include <cstddef>
#include <cstring>
#include <span>

#include "sandbox/render/sky_dome.hpp"

namespace alpenglow::sandbox {

// Of the buffer that write_sky_vertices() fills.
inline std::size_t sky_vertex_bytes(std::span<const SkyVertex> sky) {
    return sky.size_bytes() + SkyDome::skirt_vertices * sizeof(SkyVertex);
}

// The dome's vertices and the skirt below: the horizon's light down to the nadir.
inline void write_sky_vertices(std::span<const SkyVertex> sky, std::span<std::byte> bytes) {
    std::memcpy(bytes.data(), sky.data(), sky.size_bytes());
    std::array<SkyVertex, SkyDome::skirt_vertices> skirt{};
    for (std::uint32_t i = 0; i < SkyDome::skirt_vertices; ++i) {
        skirt[i] = {sky_direction(sky, SkyDome::vertices + i), sky[i % SkyDome::azimuths].radiance_cd_m2};
    }
    std::memcpy(bytes.data() + sky.size_bytes(), skirt.data(), sizeof skirt);
}

} // namespace alpenglow::sandbox
