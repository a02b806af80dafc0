// What a system did this frame. HUD, report file and tests read the same struct.
#pragma once

#include <cstdint>

namespace alpenglow {

struct SystemReport {
    const char* system = "";      // the system's name, a string literal
    std::uint32_t considered = 0; // items that could have needed work
    std::uint32_t updated = 0;    // items recomputed
    std::uint32_t skipped = 0;    // items left alone: no consumer, within the error budget, or not seen
    double cpu_ms = 0.0;          // CPU time of the calling thread
    double error_bound = 0.0;     // the largest bound on the error that a skipped output may now carry, in the
                              // measure of the system: relative for light, radians for directions, pixels for geometry
    std::uint32_t rejected = 0;       // items whose input is out of range: their previous output stands
    std::uint32_t tables_rebuilt = 0; // tables made anew for the items updated, where a system keeps some
    std::uint32_t tables_kept = 0;
};

} // namespace alpenglow
