#include "sandbox/app/parts.hpp"

#include "sandbox/app/probe_scene.hpp"

namespace alpenglow::sandbox {

std::vector<std::unique_ptr<Part>> make_parts(Stage& stage, const Scene& scene) {
    std::vector<std::unique_ptr<Part>> parts;
    if (scene.probes) {
        parts.push_back(std::make_unique<ProbeScene>(stage.registry, stage.world, *scene.probes));
    }
    return parts;
}

} // namespace alpenglow::sandbox
