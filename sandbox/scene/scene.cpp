#include "scene.hpp"

#include "builtin_scenes.hpp"
#include "calendar.hpp"
#include "reader.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <system_error>

#include <nlohmann/json.hpp>

#include <alpenglow/core/constants.hpp>

namespace alpenglow::sandbox {
namespace {

constexpr std::uintmax_t max_file_bytes = 1U << 20U;

// "line 3, column 7" of the byte at which the parser stopped.
std::string place_in(std::string_view text, std::size_t byte) {
    const std::string_view before = text.substr(0, byte > 0 ? std::min(byte - 1, text.size()) : 0);
    const auto line = 1 + std::count(before.begin(), before.end(), '\n');
    const std::size_t start = before.rfind('\n');
    const std::size_t column = before.size() - (start == std::string_view::npos ? 0 : start + 1) + 1;
    return "line " + std::to_string(line) + ", column " + std::to_string(column);
}

Result<Json> parse_json(std::string_view text, const std::string& file) {
    // The parser keeps the last of several members with one name, in silence: we do not.
    std::vector<std::set<std::string>> open;
    std::string repeated;
    const auto watch = [&](int, Json::parse_event_t event, Json& parsed) {
        if (event == Json::parse_event_t::object_start) {
            open.emplace_back();
        } else if (event == Json::parse_event_t::object_end) {
            open.pop_back();
        } else if (event == Json::parse_event_t::key && !open.back().insert(parsed.get<std::string>()).second &&
                   repeated.empty()) {
            repeated = parsed.get<std::string>();
        }
        return true;
    };
    try {
        Json parsed = Json::parse(text.begin(), text.end(), watch);
        if (!repeated.empty()) {
            return Error{"is given twice", file + ": " + repeated, "each field once"};
        }
        return parsed;
    } catch (const Json::parse_error& error) {
        const std::string message = error.what();
        const std::size_t reason = message.find(": ");
        return Error{"malformed JSON" + (reason == std::string::npos ? "" : message.substr(reason)),
                     file + ": " + place_in(text, error.byte), "a JSON object"};
    } catch (const Json::exception& error) { // a number too large for a double
        const std::string message = error.what();
        const std::size_t reason = message.find("] ");
        return Error{reason == std::string::npos ? message : message.substr(reason + 2), file,
                     "numbers that fit a double"};
    }
}

constexpr std::array<std::pair<Quality, std::string_view>, 3> quality_names{
    {{Quality::automatic, "auto"}, {Quality::lean, "lean"}, {Quality::full, "full"}}};

} // namespace

std::string_view to_string(Quality quality) {
    for (const auto& [value, name] : quality_names) {
        if (value == quality) {
            return name;
        }
    }
    return "auto";
}

std::vector<std::string> builtin_scene_names() {
    std::vector<std::string> names;
    for (const BuiltinScene& scene : builtin_scenes()) {
        names.emplace_back(scene.name);
    }
    return names;
}

Result<Scene> parse_scene(std::string_view text, const std::string& file) {
    const Result<Json> parsed = parse_json(text, file);
    if (!parsed) {
        return parsed.error();
    }
    const Json& root = *parsed;
    if (!root.is_object()) {
        return Error{"is " + shown(root), file, "a JSON object"};
    }
    Scene scene;
    Reader top(root, file, "");
    top.require("name");
    top.require("time_utc");
    top.require("observer");
    top.text("name", scene.name);
    top.text("description", scene.description);
    top.text("time_utc", scene.time_utc);
    top.number("time_rate", 0.0, 100000.0, scene.time_rate);
    std::string quality = "auto";
    top.text("quality", quality);
    const auto known = std::find_if(quality_names.begin(), quality_names.end(),
                                    [&](const auto& entry) { return entry.second == quality; });
    if (known == quality_names.end()) {
        top.fail("quality", shown(Json(quality)), "auto, lean or full");
    } else {
        scene.quality = known->first;
    }
    const Json* observer = top.object("observer");
    const Json* atmosphere = top.object("atmosphere");
    const Json* camera = top.object("camera");
    const Json* exposure = top.object("exposure");
    const Json* chart = top.object("chart");
    const Json* clouds = top.object("clouds");
    const Json* flight = top.object("flight");
    const Json* environment = top.object("environment");
    const Json* probes = top.object("probes");
    const Json* impostors = top.object("impostors");
    const Json* transfer = top.object("transfer");
    top.no_others();
    if (top.failed()) {
        return top.error();
    }
    const Result<double> utc = read_time(scene.time_utc, top.where("time_utc"));
    if (!utc) {
        return utc.error();
    }
    scene.utc_j2000_s = *utc;

    Reader place(*observer, file, "observer.");
    place.require("latitude_deg");
    place.require("longitude_deg");
    place.number("latitude_deg", -90.0, 90.0, scene.latitude_deg);
    place.number("longitude_deg", -180.0, 180.0, scene.longitude_deg);
    place.number("height_m", -500.0, 80000.0, scene.height_m);
    place.no_others();
    if (place.failed()) {
        return place.error();
    }
    if (atmosphere != nullptr) {
        Reader air(*atmosphere, file, "atmosphere.");
        scene.atmosphere = read_atmosphere_settings(air);
        air.no_others();
        if (air.failed()) {
            return air.error();
        }
    }
    if (camera != nullptr) {
        Reader view(*camera, file, "camera.");
        view.numbers("position_m", -60000.0, 60000.0, scene.camera_position_m);
        view.number("yaw_deg", -360.0, 360.0, scene.camera_yaw_deg);
        view.number("pitch_deg", -89.0, 89.0, scene.camera_pitch_deg);
        view.number("fov_deg", 5.0, 120.0, scene.camera_fov_deg);
        view.no_others();
        if (view.failed()) {
            return view.error();
        }
    }
    if (exposure != nullptr) {
        Reader light(*exposure, file, "exposure.");
        light.number("bias_ev", -10.0, 10.0, scene.exposure_bias_ev);
        light.no_others();
        if (light.failed()) {
            return light.error();
        }
    }
    if (chart != nullptr) {
        Reader section(*chart, file, "chart.");
        scene.chart = read_chart_settings(section);
        section.no_others();
        if (section.failed()) {
            return section.error();
        }
    }
    if (clouds != nullptr) {
        Reader section(*clouds, file, "clouds.");
        scene.clouds = read_cloud_settings(section);
        section.no_others();
        if (section.failed()) {
            return section.error();
        }
    }
    if (flight != nullptr) {
        Reader section(*flight, file, "flight.");
        scene.flight = read_flight_settings(section);
        section.no_others();
        if (section.failed()) {
            return section.error();
        }
    }
    if (environment != nullptr) {
        Reader section(*environment, file, "environment.");
        scene.environment = read_environment_settings(section);
        section.no_others();
        if (section.failed()) {
            return section.error();
        }
    }
    if (impostors != nullptr) {
        Reader section(*impostors, file, "impostors.");
        scene.impostors = read_impostor_settings(section);
        section.no_others();
        if (section.failed()) {
            return section.error();
        }
    }
    if (probes != nullptr) {
        Reader section(*probes, file, "probes.");
        scene.probes = read_probe_settings(section);
        section.no_others();
        if (section.failed()) {
            return section.error();
        }
    }
    if (transfer != nullptr) {
        Reader section(*transfer, file, "transfer.");
        scene.transfer = read_transfer_settings(section);
        section.no_others();
        if (section.failed()) {
            return section.error();
        }
    }
    return scene;
}

Result<Scene> load_scene(const std::string& name_or_file) {
    std::string names;
    for (const BuiltinScene& scene : builtin_scenes()) {
        if (scene.name == name_or_file) {
            return parse_scene(scene.json, std::string(scene.name));
        }
        names += (names.empty() ? "" : ", ") + std::string(scene.name);
    }
    namespace fs = std::filesystem;
    std::error_code failure;
    const fs::path path(name_or_file);
    if (!fs::exists(path, failure)) {
        const bool looks_like_file = path.has_parent_path() || path.has_extension();
        return looks_like_file ? Error{"no such file", name_or_file, "a scene file, or one of " + names}
                               : Error{"unknown scene \"" + name_or_file + "\"", "", "one of " + names + ", or a file"};
    }
    if (!fs::is_regular_file(path, failure)) {
        return Error{"is not a file", name_or_file, "a scene file, or one of " + names};
    }
    if (const auto size = fs::file_size(path, failure); failure || size > max_file_bytes) {
        return Error{"is too large for a scene", name_or_file, "at most 1 MiB of JSON"};
    }
    std::ifstream stream(path, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
    if (!stream) {
        return Error{"cannot be read", name_or_file, "a scene file that may be read"};
    }
    return parse_scene(text, name_or_file);
}

Camera scene_camera(const Scene& scene) {
    Camera camera;
    camera.position_m = scene.camera_position_m;
    camera.yaw_rad = scene.camera_yaw_deg * static_cast<float>(degree_rad);
    camera.pitch_rad = scene.camera_pitch_deg * static_cast<float>(degree_rad);
    camera.fov_y_rad = scene.camera_fov_deg * static_cast<float>(degree_rad);
    camera.turn(0.0F, 0.0F); // brings the yaw into its range
    return camera;
}

} // namespace alpenglow::sandbox
