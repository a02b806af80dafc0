// What a scene is: a date, a place, the air, and where the camera stands. Scenes are JSON; see docs/scenes.md.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <glm/vec3.hpp>

#include <alpenglow/core/result.hpp>

#include "sandbox/scene/atmosphere_settings.hpp"
#include "sandbox/scene/chart_settings.hpp"
#include "sandbox/scene/cloud_settings.hpp"
#include "sandbox/scene/flight_settings.hpp"
#include "sandbox/scene/environment_settings.hpp"
#include "sandbox/scene/impostor_settings.hpp"
#include "sandbox/scene/probe_settings.hpp"
#include "sandbox/scene/transfer_settings.hpp"
#include "sandbox/world/camera.hpp"
#include "sandbox/world/quality.hpp"

namespace alpenglow::sandbox {

struct Scene {
    std::string name;
    std::string description;
    std::string time_utc = "2026-06-21T05:30:00Z"; // ISO 8601, as written in the file
    double utc_j2000_s = 0.0;                      // the same, as the API takes it
    double time_rate = 1.0;                        // seconds of the scene per second
    double latitude_deg = 47.27;
    double longitude_deg = 11.39;
    double height_m = 600.0;
    Atmosphere atmosphere;
    glm::vec3 camera_position_m{0.0F, 0.0F, 2000.0F}; // east, north of the landscape's middle; above sea level
    float camera_yaw_deg = 0.0F;                      // azimuth of the view, from north through east
    float camera_pitch_deg = 0.0F;
    float camera_fov_deg = 50.0F; // vertical
    float exposure_bias_ev = 0.0F;
    Quality quality = Quality::automatic;
    ChartSettings chart;
    std::optional<CloudSettings> clouds;
    std::optional<FlightSettings> flight; // what the camera follows
    std::optional<EnvironmentSettings> environment; // a picture in place of sky, sun and moon
    std::optional<ImpostorSettings> impostors; // clouds drawn by their pictures, and aircraft among them
    std::optional<ProbeSettings> probes; // a courtyard lit by probes, with things that move in it
    std::optional<TransferSettings> transfer; // things on a meadow whose light is baked
};

inline constexpr std::string_view default_scene = "valley-afternoon";

// Names of the scenes in the binary, in the order to show them.
[[nodiscard]] std::vector<std::string> builtin_scene_names();

// The scene in a JSON text. `file` names the source in errors; an error names file, field, value and what would be
// right, or the line and column of malformed JSON. What the text leaves out keeps the default above, but for `name`,
// `time_utc` and `observer`, which must be there.
[[nodiscard]] Result<Scene> parse_scene(std::string_view json, const std::string& file);

// A scene in the binary by its name, or else one from a file.
[[nodiscard]] Result<Scene> load_scene(const std::string& name_or_file);

// The camera where the scene has it.
[[nodiscard]] Camera scene_camera(const Scene& scene);

[[nodiscard]] std::string_view to_string(Quality quality);

} // namespace alpenglow::sandbox
