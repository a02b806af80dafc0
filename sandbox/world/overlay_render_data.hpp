// A picture that lies over the frame, pixel by pixel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace alpenglow::sandbox {

struct OverlayRenderData {
    std::span<const std::byte> rgba; // premultiplied, 8 bits as the display takes them, rows from the top
    int width = 0, height = 0;
    int left = 0, top = 0;      // in the frame
    std::uint32_t revision = 0; // from next_revision(); equal: equal pixels
};

} // namespace alpenglow::sandbox
