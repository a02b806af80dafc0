// What every system is told about the frame that it works for.
#pragma once

#include <cstdint>

namespace alpenglow {

struct Frame {
    std::uint64_t index = 0; // counts frames
    double dt_s = 0.0;       // real time since the last frame
};

} // namespace alpenglow
