// The report file: what every system did in every frame, and the medians over the frames.
#pragma once

#include <string>
#include <vector>

#include <alpenglow/core/result.hpp>
#include <alpenglow/core/system_report.hpp>

namespace alpenglow::sandbox {

struct FrameReport {
    double cpu_ms = 0.0; // CPU time of the whole process, all threads
    double wall_ms = 0.0;
    double direct_cpu_ms = 0.0; // of the same frame without impostors, where it was compared; else 0
    double direct_wall_ms = 0.0;
    std::vector<SystemReport> systems{}; // in the order of the frame
};

struct RunReport {
    std::string scene;
    std::string device;
    std::string quality;
    int width = 0;
    int height = 0;
    std::vector<FrameReport> frames{};
};

// The document as JSON text; its format is described in docs/sandbox.md.
[[nodiscard]] std::string to_json(const RunReport& report);

// Writes `bytes` to `path` through a temporary file beside it, so that a failure leaves no partial file.
[[nodiscard]] Status write_file(const std::string& path, const std::string& bytes);

} // namespace alpenglow::sandbox
