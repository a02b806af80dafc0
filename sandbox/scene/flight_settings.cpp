#include "flight_settings.hpp"

#include "reader.hpp"

namespace alpenglow::sandbox {

FlightSettings read_flight_settings(Reader& section) {
    FlightSettings settings;
    section.require("keys");
    section.each("keys", [&](Reader& item) {
        FlightKey key;
        item.require("time_s");
        item.require("position_m");
        item.number("time_s", 0.0, 1e5, key.time_s);
        item.numbers("position_m", -60000.0, 60000.0, key.position_m);
        item.number("yaw_deg", -360.0, 360.0, key.yaw_deg);
        item.number("pitch_deg", -89.0, 89.0, key.pitch_deg);
        item.no_others();
        if (!item.failed() && !settings.keys.empty() && !(key.time_s > settings.keys.back().time_s)) {
            item.fail("time_s", shown(key.time_s), "more than the key before");
        }
        settings.keys.push_back(key);
    });
    section.boolean("loop", settings.loop);
    if (!section.failed() && settings.keys.size() < 2) {
        section.fail("keys", std::to_string(settings.keys.size()) + " long", "two keys or more");
    }
    return settings;
}

} // namespace alpenglow::sandbox
