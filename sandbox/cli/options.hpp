// The sandbox's command line.
#pragma once

#include <optional>
#include <span>
#include <string>

#include <alpenglow/core/result.hpp>

#include "sandbox/scene/scene.hpp"

namespace alpenglow::sandbox {

struct Options {
    std::string scene{default_scene}; // a scene's name or a file
    bool headless = false;            // render without a window
    int frames = 0;                   // how many to render; 0: until the window is closed (headless: 1)
    int width = 960;
    int height = 540;
    std::optional<double> utc_j2000_s; // these override the scene
    std::optional<double> latitude_deg;
    std::optional<double> longitude_deg;
    std::optional<Quality> quality;
    std::optional<Chart> chart;
    std::optional<int> chart_bands;
    std::string out;          // PNG of the last frame; empty: none
    std::string report;       // JSON of all frames; empty: none
    std::string device;       // part of the Vulkan device's name; empty: the one with the best type
    unsigned threads = 0;     // for parallel loops; 0: as many as the machine has
    bool validate = false;    // Vulkan validation layer; its messages make the run fail
    int compare = 0;          // headless: every so many frames is held against one drawn without shortcuts; 0: none
    bool hud = false;         // draw the HUD in headless runs too
    bool list_scenes = false; // print the names and stop
    bool help = false;        // print help_text() and stop
};

// Arguments after the program's name. The error names option, value and what would be right: exit code 2. Whether the
// scene exists and is right is seen by load_scene; whether files can be written, by check_writable.
[[nodiscard]] Result<Options> parse_options(std::span<const char* const> arguments);

[[nodiscard]] std::string help_text();

// Whether a file can be written there later: its folder exists and takes a new file, and nothing but a file is in the
// way. Leaves nothing behind and does not touch what exists.
[[nodiscard]] Status check_writable(const std::string& option, const std::string& path);

} // namespace alpenglow::sandbox
