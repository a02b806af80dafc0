#include "settings.hpp"

#include <alpenglow/prt/hash.hpp>

#include <string>

namespace alpenglow::prt {

std::uint64_t settings_hash(const BakeSettings& s) {
    Hasher hasher;
    const auto add = [&](const auto& value) { hasher.add(std::as_bytes(std::span(&value, 1))); };
    add(s.transport);
    add(s.sampling);
    add(s.order);
    add(s.rays);
    add(s.max_error);
    add(s.gather_rays);
    add(s.max_bounces);
    add(s.stop_energy);
    add(s.colour);
    add(s.default_albedo);
    add(s.seed);
    return hasher.digest();
}

Status check(const BakeSettings& s) {
    const auto wrong = [](const char* field, const std::string& what, const std::string& expected) {
        return Error{what, std::string("bake settings: ") + field, expected};
    };
    if (s.order < 1 || s.order > 6) {
        return wrong("order", std::to_string(s.order), "1 .. 6");
    }
    if (s.rays < 16 || s.rays > (std::size_t{1} << 24U)) {
        return wrong("rays", std::to_string(s.rays), "16 .. 16777216");
    }
    if (!(s.max_error >= 0.0)) {
        return wrong("max_error", std::to_string(s.max_error), "0 or more");
    }
    if (s.gather_rays < 1 || s.gather_rays > (std::size_t{1} << 20U)) {
        return wrong("gather_rays", std::to_string(s.gather_rays), "1 .. 1048576");
    }
    if (!(s.default_albedo >= 0.0F && s.default_albedo <= 1.0F)) {
        return wrong("default_albedo", std::to_string(s.default_albedo), "0 .. 1");
    }
    if (s.max_bounces < 0 || !(s.stop_energy >= 0.0)) {
        return wrong("max_bounces, stop_energy", std::to_string(s.max_bounces) + ", " + std::to_string(s.stop_energy),
                     "0 or more");
    }
    return Ok{};
}

} // namespace alpenglow::prt
