// The section `probes` of a scene.
#pragma once

#include <alpenglow/components/light_probe.hpp>

namespace alpenglow::sandbox {

class Reader;

// Of a scene with a probe grid.
struct ProbeSettings {
    Deringing deringing = Deringing::exact;
    ProbeSource source = ProbeSource::assembled;
    bool show = true; // draw probes of the grid
};

[[nodiscard]] ProbeSettings read_probe_settings(Reader& section);

} // namespace alpenglow::sandbox
