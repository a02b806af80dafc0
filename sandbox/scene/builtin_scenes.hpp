// The scenes of sandbox/scenes, embedded by the build.
#pragma once

#include <span>
#include <string_view>

namespace alpenglow::sandbox {

struct BuiltinScene {
    std::string_view name;
    std::string_view json;
};

[[nodiscard]] std::span<const BuiltinScene> builtin_scenes();

} // namespace alpenglow::sandbox
