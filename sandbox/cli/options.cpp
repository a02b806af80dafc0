#include "options.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <vector>

#include <CLI/CLI.hpp>

#include "sandbox/scene/calendar.hpp"

namespace alpenglow::sandbox {
namespace {

constexpr int min_size_px = 16;
constexpr int max_size_px = 16384;
constexpr int max_frames = 1000000;
constexpr int max_threads = 256;

// Everything is read as text first, so that our messages say what would be right.
struct Texts {
    std::string frames, size, time, latitude, longitude, quality, chart, threads, compare;
};

void declare(CLI::App& app, Options& options, Texts& texts) {
    app.add_option("--scene", options.scene, "Scene by name, or a JSON file")->type_name("NAME|FILE");
    app.add_flag("--list-scenes", options.list_scenes, "Print the names of the scenes");
    app.add_option("--time", texts.time, "Date and time, ISO 8601, UTC unless it says otherwise")->type_name("ISO8601");
    app.add_option("--lat", texts.latitude, "Latitude in degrees, north positive")->type_name("DEGREES");
    app.add_option("--lon", texts.longitude, "Longitude in degrees, east positive")->type_name("DEGREES");
    app.add_flag("--headless", options.headless, "Render without a window or display");
    app.add_option("--frames", texts.frames, "Frames to render (headless: 1, window: until closed)")->type_name("N");
    app.add_option("--size", texts.size, "Image size in pixels (960x540)")->type_name("WxH");
    app.add_option("--out", options.out, "Write the last frame as a PNG")->type_name("FILE.png");
    app.add_option("--report", options.report, "Write what each frame did and cost as JSON")->type_name("FILE.json");
    app.add_option("--quality", texts.quality, "lean or full (chosen by device)")->type_name("LEVEL");
    app.add_option("--chart", texts.chart, "Over the picture: sky (its SH beside it; sky:1 .. sky:7 bands), day, none")
        ->type_name("CHART");
    app.add_option("--device", options.device, "Vulkan device whose name contains this")->type_name("NAME");
    app.add_option("--threads", texts.threads, "Threads for parallel loops (0: all)")->type_name("N");
    app.add_option("--compare", texts.compare, "Headless: hold every N-th frame against one without impostors")
        ->type_name("N");
    app.add_flag("--hud", options.hud, "Draw the HUD in headless runs too");
    app.add_flag("--validate", options.validate, "Turn the Vulkan validation layer on; any message fails the run");
    app.set_help_flag("");
    app.add_flag("-h,--help", options.help, "Print this");
}

constexpr const char* description = "Alpenglow sandbox: a landscape under the sky of a date and a place";

template <class Number>
bool read_number(const std::string& text, Number& out) {
    const char* first = text.data();
    const char* last = first + text.size();
    if (text.size() > 1 && text.front() == '+') {
        ++first;
    }
    const auto [end, failure] = std::from_chars(first, last, out);
    return failure == std::errc{} && end == last;
}

Error bad(const std::string& option, const std::string& value, const std::string& expected) {
    return {"is " + (value.empty() ? "empty" : value), option, expected};
}

Status read_integer(const std::string& option, const std::string& text, int low, int high, int& out) {
    int value = 0;
    if (!read_number(text, value) || value < low || value > high) {
        return bad(option, text, "a whole number from " + std::to_string(low) + " to " + std::to_string(high));
    }
    out = value;
    return Ok{};
}

Status read_angle(const std::string& option, const std::string& text, double limit, std::optional<double>& out) {
    double value = 0.0;
    if (!read_number(text, value) || !(std::abs(value) <= limit)) {
        const std::string degrees = std::to_string(static_cast<int>(limit));
        return bad(option, text, "degrees from -" + degrees + " to " + degrees);
    }
    out = value;
    return Ok{};
}

Status read_size(const std::string& text, int& width, int& height) {
    const std::string expected =
        "WIDTHxHEIGHT, each from " + std::to_string(min_size_px) + " to " + std::to_string(max_size_px);
    const std::size_t cross = text.find('x');
    int w = 0;
    int h = 0;
    if (cross == std::string::npos || !read_number(text.substr(0, cross), w) ||
        !read_number(text.substr(cross + 1), h) || w < min_size_px || h < min_size_px || w > max_size_px ||
        h > max_size_px) {
        return bad("--size", text, expected);
    }
    width = w;
    height = h;
    return Ok{};
}

Status interpret(const CLI::App& app, const Texts& texts, Options& options) {
    const auto given = [&](const char* name) { return app.count(name) > 0; };
    Status status = Ok{};
    if (given("--frames") && !(status = read_integer("--frames", texts.frames, 1, max_frames, options.frames))) {
        return status;
    }
    if (given("--size") && !(status = read_size(texts.size, options.width, options.height))) {
        return status;
    }
    if (given("--lat") && !(status = read_angle("--lat", texts.latitude, 90.0, options.latitude_deg))) {
        return status;
    }
    if (given("--lon") && !(status = read_angle("--lon", texts.longitude, 180.0, options.longitude_deg))) {
        return status;
    }
    if (given("--time")) {
        const Result<double> utc = read_time(texts.time, "--time");
        if (!utc) {
            return utc.error();
        }
        options.utc_j2000_s = *utc;
    }
    if (given("--quality")) {
        if (texts.quality != "lean" && texts.quality != "full") {
            return bad("--quality", texts.quality, "lean or full");
        }
        options.quality = texts.quality == "lean" ? Quality::lean : Quality::full;
    }
    if (given("--chart")) {
        const std::string name = texts.chart.substr(0, texts.chart.find(':'));
        const auto known = std::find(chart_names.begin(), chart_names.end(), name);
        int bands = 0;
        const bool counted = name != texts.chart;
        if (known == chart_names.end() ||
            (counted &&
             (name != "sky" || !read_number(texts.chart.substr(name.size() + 1), bands) || bands < 1 || bands > 7))) {
            return bad("--chart", texts.chart, "sky, sky:1 to sky:7, day or none");
        }
        options.chart = static_cast<Chart>(known - chart_names.begin());
        if (counted) {
            options.chart_bands = bands;
        }
    }
    if (given("--threads")) {
        int threads = 0;
        if (!(status = read_integer("--threads", texts.threads, 0, max_threads, threads))) {
            return status;
        }
        options.threads = static_cast<unsigned>(threads);
    }
    if (given("--compare") && !(status = read_integer("--compare", texts.compare, 1, max_frames, options.compare))) {
        return status;
    }
    for (const auto& [name, value] : {std::pair{"--scene", &options.scene}, std::pair{"--out", &options.out},
                                      std::pair{"--report", &options.report}, std::pair{"--device", &options.device}}) {
        if (given(name) && value->empty()) {
            return bad(name, "", "a name");
        }
    }
    if (!options.out.empty() && std::filesystem::path(options.out).extension() != ".png") {
        return bad("--out", options.out, "a file name that ends in .png");
    }
    if (!options.out.empty() && options.out == options.report) {
        return bad("--report", options.report, "another file than --out");
    }
    if (options.headless && options.frames == 0) {
        options.frames = 1;
    }
    return Ok{};
}

} // namespace

Result<Options> parse_options(std::span<const char* const> arguments) {
    Options options;
    Texts texts;
    CLI::App app(description);
    declare(app, options, texts);
    // CLI11 takes the arguments from the back.
    std::vector<std::string> reversed(arguments.rbegin(), arguments.rend());
    try {
        app.parse(reversed);
    } catch (const CLI::Error& error) {
        return Error{error.what(), "command line", "see --help"};
    }
    const Status status = interpret(app, texts, options);
    if (!status) {
        return status.error();
    }
    return options;
}

std::string help_text() {
    Options options;
    Texts texts;
    CLI::App app(description, "alpenglow-sandbox");
    declare(app, options, texts);
    return app.help();
}

Status check_writable(const std::string& option, const std::string& path) {
    namespace fs = std::filesystem;
    std::error_code failure;
    const fs::path target(path);
    const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
    if (!target.has_filename() || fs::is_directory(target, failure)) {
        return Error{"is a folder", option + " " + path, "a file name"};
    }
    if (!fs::is_directory(folder, failure)) {
        return Error{"its folder does not exist", option + " " + path, "a file in a folder that exists"};
    }
    if (fs::exists(target, failure) && !fs::is_regular_file(target, failure)) {
        return Error{"is not a regular file", option + " " + path, "a file that may be replaced"};
    }
    // Asking for permissions is not enough (read-only file systems, the superuser): try.
    fs::path probe = target;
    probe += ".tmp";
    const bool was_there = fs::exists(probe, failure);
    {
        std::ofstream stream(probe, std::ios::binary | std::ios::app);
        if (!stream) {
            return Error{"cannot be written", option + " " + path, "a folder that takes new files"};
        }
    }
    if (!was_there) {
        fs::remove(probe, failure);
    }
    return Ok{};
}

} // namespace alpenglow::sandbox
