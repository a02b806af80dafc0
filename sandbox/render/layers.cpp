#include "sandbox/render/layers.hpp"

#include "sandbox/render/cloud_layer.hpp"
#include "sandbox/render/environment_layer.hpp"
#include "sandbox/render/impostor_layer.hpp"
#include "sandbox/render/overlay_layer.hpp"
#include "sandbox/render/probe_layer.hpp"
#include "sandbox/render/transfer_layer.hpp"

namespace alpenglow::sandbox {

std::vector<std::unique_ptr<Layer>> make_layers(const LayerContext& context) {
    std::vector<std::unique_ptr<Layer>> layers;
    layers.push_back(std::make_unique<CloudLayer>(context));
    layers.push_back(std::make_unique<ProbeLayer>(context));
    layers.push_back(std::make_unique<EnvironmentLayer>(context)); // behind what blends
    layers.push_back(std::make_unique<TransferLayer>(context));
    layers.push_back(std::make_unique<ImpostorLayer>(context));
    layers.push_back(std::make_unique<OverlayLayer>(context));
    return layers;
}

} // namespace alpenglow::sandbox
