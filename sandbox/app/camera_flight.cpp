#include "sandbox/app/camera_flight.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <alpenglow/core/constants.hpp>

namespace alpenglow::sandbox {
namespace {

// Value at s (0 .. 1) between b and c, one apart in s; a and d their neighbours, their times in the same unit.
float cubic(const std::array<float, 4>& v, const std::array<double, 4>& t, double s) {
    const auto x = static_cast<float>(s);
    const auto slope = [&](std::size_t i) {
        const std::size_t low = i == 0 ? 0 : i - 1;
        const std::size_t high = i == 3 ? 3 : i + 1;
        return (v[high] - v[low]) / static_cast<float>(std::max(t[high] - t[low], 1e-9));
    };
    const auto span = static_cast<float>(t[2] - t[1]);
    const float m1 = slope(1) * span;
    const float m2 = slope(2) * span;
    const float x2 = x * x;
    const float x3 = x2 * x;
    return (2.0F * x3 - 3.0F * x2 + 1.0F) * v[1] + (x3 - 2.0F * x2 + x) * m1 + (3.0F * x2 - 2.0F * x3) * v[2] +
           (x3 - x2) * m2;
}

float nearest_turn(float from_deg, float to_deg) {
    return from_deg + std::remainder(to_deg - from_deg, 360.0F);
}

} // namespace

FlightKey flight_at(const FlightSettings& flight, double time_s) {
    const std::vector<FlightKey>& keys = flight.keys;
    const double first = keys.front().time_s;
    const double last = keys.back().time_s;
    double t = first + time_s;
    if (flight.loop) {
        t = first + std::fmod(time_s, last - first);
    }
    t = std::clamp(t, first, last);
    std::size_t i = 0;
    while (i + 2 < keys.size() && keys[i + 1].time_s <= t) {
        ++i;
    }
    const std::array<std::size_t, 4> at{i == 0 ? 0 : i - 1, i, i + 1, std::min(i + 2, keys.size() - 1)};
    std::array<double, 4> times{};
    for (std::size_t k = 0; k < 4; ++k) {
        times[k] = keys[at[k]].time_s;
    }
    const double s = (t - times[1]) / (times[2] - times[1]);
    const auto through = [&](auto&& value) {
        return cubic({value(at[0]), value(at[1]), value(at[2]), value(at[3])}, times, s);
    };
    FlightKey out;
    out.time_s = t;
    for (int a = 0; a < 3; ++a) {
        out.position_m[a] = through([&](std::size_t k) { return keys[k].position_m[a]; });
    }
    const float yaw = keys[at[1]].yaw_deg;
    out.yaw_deg = through([&](std::size_t k) { return nearest_turn(yaw, keys[k].yaw_deg); });
    out.pitch_deg = std::clamp(through([&](std::size_t k) { return keys[k].pitch_deg; }), -89.0F, 89.0F);
    return out;
}

void CameraFlight::begin(Stage& stage) {
    if (!flying_) {
        return;
    }
    Camera& camera = stage.camera;
    if (set_ && (camera.position_m != set_->position_m || camera.yaw_rad != set_->yaw_rad ||
                 camera.pitch_rad != set_->pitch_rad)) {
        flying_ = false; // the player has taken over
        return;
    }
    time_s_ += stage.world_dt_s;
    const FlightKey key = flight_at(flight_, time_s_);
    camera.position_m = key.position_m;
    camera.yaw_rad = key.yaw_deg * static_cast<float>(degree_rad);
    camera.pitch_rad = key.pitch_deg * static_cast<float>(degree_rad);
    camera.turn(0.0F, 0.0F); // brings the yaw into its range
    set_ = camera;
}

void CameraFlight::draw_panel(PanelWriter& panel) {
    if (panel.toggle("follow the path (P)", flying_)) {
        set_.reset();
    }
}

bool CameraFlight::press(int key) {
    if (key != 'P') {
        return false;
    }
    flying_ = !flying_;
    set_.reset();
    return true;
}

} // namespace alpenglow::sandbox
