// Moves the camera along a recorded path, until the player takes over.
#pragma once

#include <optional>

#include "sandbox/app/part.hpp"
#include "sandbox/scene/flight_settings.hpp"

namespace alpenglow::sandbox {

// Where the camera is at a time: a cubic through the keys (Catmull and Rom 1974, tangents by the keys' times).
[[nodiscard]] FlightKey flight_at(const FlightSettings& flight, double time_s);

// Lets go as soon as somebody else moves or turns the camera.
class CameraFlight final : public Part {
public:
    explicit CameraFlight(const FlightSettings& flight) : flight_(flight) {}
    void begin(Stage& stage) override;
    void update(Stage& /*stage*/) override {}
    void draw_panel(PanelWriter& panel) override;
    bool press(int key) override; // P: flies on or lets go

private:
    FlightSettings flight_;
    double time_s_ = 0.0;
    bool flying_ = true;
    std::optional<Camera> set_; // as the last frame left it
};

} // namespace alpenglow::sandbox
