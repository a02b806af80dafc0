#include "sandbox/app/parts.hpp"

#include "sandbox/app/probe_scene.hpp"
#include "sandbox/app/transfer_scene.hpp"

namespace alpenglow::sandbox {

std::vector<std::unique_ptr<Part>> make_parts(Stage& stage, const Scene& scene) {
    std::vector<std::unique_ptr<Part>> parts;
    if (scene.probes) {
        parts.push_back(std::make_unique<ProbeScene>(stage.registry, stage.world, *scene.probes));
    }
    if (scene.transfer) {
        parts.push_back(std::make_unique<TransferScene>(stage, *scene.transfer));
    }
    return parts;
}

} // namespace alpenglow::sandbox
